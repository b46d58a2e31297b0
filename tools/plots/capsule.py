"""Figures of the dual-spin capsule: the paper's phase portraits 6 and 7, its condition for falling amplitude, the retro-burn's
error against spin-up, and where the capsule lands."""
import importlib.util
import math
import subprocess

# Limit points (integral of p, integral of q) of the paper's L0 = 0.75; the runs have a thousandth of it.
LIMITS = {"figure6": (0.0670992388580498, -0.0325242635870585), "figure7": (-0.176649962112910, -0.844573734013524)}
SCALE = 1000


def calc_angles(q):
    """gamma, psi of (2.3)."""
    w, x, y, z = q
    return math.asin(2 * (x * z + w * y)), math.atan2(-2 * (y * z - w * x), 1 - 2 * (x * x + y * y))


def load(tools, name):
    spec = importlib.util.spec_from_file_location(name, tools.SCENARIOS / f"capsule/{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def draw_amplitudes(bench, tools, axes, falling, make, xs, ys):
    """Ratios of runs as colours, where the paper's condition changes sign as lines. `make`: a Case of x and y."""
    ratios = []
    for y in ys:
        ratios.append([])
        for x in xs:
            run = bench.call("run", tools.SCENARIOS / "capsule/reference.yaml", "--dt", "0.004", "--json", "-", *make(x, y).list_options())
            ratios[-1].append(math.log2(falling.calc_run_ratio(run["samples"])))
    image = axes.pcolormesh(xs, ys, ratios, cmap="RdBu_r", vmin=-2, vmax=2, shading="nearest")
    fine_x, fine_y = ([v[0] + (v[-1] - v[0]) * i / 100 for i in range(101)] for v in (xs, ys))
    for condition, style in ((lambda case: case.calc_condition(), "-"), (lambda case: math.prod(case.calc_omega_mu()), ":")):
        axes.contour(fine_x, fine_y, [[condition(make(x, y)) for x in fine_x] for y in fine_y], levels=[0], colors="0.1", linestyles=style)
    axes.grid(False)
    return image


def add(figure, tools):
    @figure("capsule-amplitude")
    def amplitude(bench):
        import matplotlib.pyplot as plt
        falling = load(tools, "falling_amplitude")
        drawn, (left, right) = plt.subplots(1, 2, figsize=(7.5, 3.9), constrained_layout=True)
        draw_amplitudes(bench, tools, left, falling, lambda x, y: falling.Case(C1k=60 * (1 - x), A1k=90 - 270 * y),
                        [0.02 + 0.04 * i for i in range(11)], [0.01 + 0.02 * i for i in range(10)])
        left.set(xlabel="axial inertia that the motor loses", ylabel="lateral inertia that the whole loses")
        left.set_title("Burn law, capsule without spin", loc="left")
        image = draw_amplitudes(bench, tools, right, falling, lambda x, y: falling.Case(C1k=50, C2=y, r0=x, sigma0=6 - x),
                                [-3 + 0.5 * i for i in range(13)], [40 + 20 * i for i in range(11)])
        right.set(xlabel="spin of the capsule, rad/s (motor 6 rad/s)", ylabel="axial inertia of the capsule, kg m²")
        right.set_title("Spin and inertia", loc="left")
        drawn.colorbar(image, ax=[left, right], label="amplitude: end by beginning", ticks=(-2, -1, 0, 1, 2)).set_ticklabels(
            ("1/4", "1/2", "1", "2", "4"))
        lines = [plt.Line2D([], [], color="0.1", linestyle=style, label=label)
                 for style, label in (("-", "the condition changes"), (":", "the paper's condition changes"))]
        right.legend(handles=lines, loc="upper center", bbox_to_anchor=(0.5, -0.17))  # below the plot
        return drawn

    @figure("capsule-landing")
    def places(bench):
        import matplotlib.pyplot as plt
        landing = load(tools, "landing")
        drawn, (left, right) = plt.subplots(1, 2, figsize=(7.5, 3.6), constrained_layout=True)
        spins, sizes = (4, 6, 12), []
        for spin, colour in zip(spins, ("#c1121f", "#e09f3e", "#457b9d")):
            folder = bench.folder / f"landing{spin}"
            done = subprocess.run([bench.program, "campaign", tools.SCENARIOS / "capsule/landing.yaml", "--out", folder, "--set",
                                   f"constants.spin={spin} rad/s"], capture_output=True)
            assert done.returncode in (0, 1), done.stderr  # 1: some do not keep their direction
            found = landing.land(landing.read_states(folder))
            mean, axes, vectors = landing.calc_ellipse(found)
            sizes.append(axes / 1e3)
            left.plot(*((found.T - mean) / 1e3).T, ".", color=colour, markersize=3, label=f"{spin} rad/s")
            turns = [2 * math.pi * i / 100 for i in range(101)]
            left.plot(*zip(*((axes[0] * math.cos(t) * vectors[:, 0] + axes[1] * math.sin(t) * vectors[:, 1]) / 1e3 for t in turns)),
                      color=colour, linewidth=0.9)
        left.set(xlabel="along the track, km", ylabel="across, km", ylim=(-100, 125))  # room for the legend above the ellipses
        left.set_title("Places of landing by the motor's spin, 3σ", loc="left")
        left.legend(loc="upper center", ncols=3, columnspacing=1, handletextpad=0.2, markerscale=2)
        for i, label in enumerate(("along", "across")):
            right.loglog(spins, [size[i] for size in sizes], "o-", color=("#1d3557", "#c1121f")[i], label=f"{label} (3σ)")
        right.set_xticks(spins, [str(spin) for spin in spins])
        right.set_yticks((10, 20, 50, 100, 200, 500), ("10", "20", "50", "100", "200", "500"))
        right.minorticks_off()
        right.set(xlabel="spin of the motor, rad/s", ylabel="semi-axis of the ellipse, km")
        right.legend(loc="upper right")
        return drawn

    @figure("capsule-portraits")
    def portraits(bench):
        import matplotlib.pyplot as plt
        drawn, columns = plt.subplots(1, 2, figsize=(7.5, 3.9), constrained_layout=True)
        for axes, (name, limit) in zip(columns, LIMITS.items()):
            run = bench.run(f"capsule/{name}.yaml", 10, 0.005)
            gamma, psi = zip(*(calc_angles(sample["bodies"]["capsule"]["q"]) for sample in run["samples"]))
            # The paper's axes: its gamma is the integral of p, which by (2.3) is psi.
            axes.plot([SCALE * v for v in psi], [SCALE * v for v in gamma], color="#1d3557", linewidth=0.8)
            axes.plot(0, 0, "s", color="#1d3557", markersize=5, label="start")
            axes.plot(*limit, "+", color="#c1121f", markersize=11, markeredgewidth=2, label="limit point")
            axes.set_aspect("equal")
            axes.set_xlabel("ψ (the paper's γ), units of L0 = 0.75")
            axes.set_title(f"Figure {name[-1]}: ω = 10 1/s, μ = {2.5 if name[-1] == '6' else -2.5} 1/s²", loc="left")
            axes.legend(loc="upper right" if axes is columns[0] else "lower right")
        columns[0].set_ylabel("γ (the paper's ψ)")
        return drawn

    @figure("capsule-finite-angles")
    def finite(bench):
        import matplotlib.pyplot as plt
        drawn, axes = plt.subplots(figsize=(4.8, 4.5), constrained_layout=True)
        small = bench.run("capsule/figure7.yaml", 10, 0.005)
        gamma, psi = zip(*(calc_angles(sample["bodies"]["capsule"]["q"]) for sample in small["samples"]))
        axes.plot([SCALE * v for v in psi], [SCALE * v for v in gamma], color="0.6", linewidth=0.7, label="small angles")
        p, q = (0.75 * part for part in (math.sin(0.5), math.cos(0.5)))
        options = [word for body in ("capsule", "motor") for i, v in enumerate((p, q))
                   for word in ("--set", f"bodies.{body}.rate[{i}]={v!r}")]
        run = bench.run("capsule/figure7.yaml", 10, 0.005, *options)
        gamma, psi = zip(*(calc_angles(sample["bodies"]["capsule"]["q"]) for sample in run["samples"]))
        axes.plot(psi, gamma, color="#c1121f", linewidth=0.9, label="the whole motion, L0 = 0.75 1/s")
        axes.set_aspect("equal")
        axes.set_xlabel("ψ, rad")
        axes.set_ylabel("γ, rad")
        axes.set_title("Figure 7 is drawn for angles that are not small", loc="left")
        axes.legend()
        return drawn

    @figure("capsule-retro-burn")
    def burn(bench):
        import matplotlib.pyplot as plt
        drawn, (left, right) = plt.subplots(1, 2, figsize=(7.5, 3), constrained_layout=True)
        spins, errors = (0, 0.5, 1, 2, 3, 4, 6, 8, 10), []
        for spin in spins:
            run = bench.run("capsule/scenario.yaml", 22, 0.05, "--set", f"bodies.motor.rate[2]={spin}")
            velocity = run["samples"][-1]["bodies"]["capsule"]["v"]
            errors.append(math.degrees(math.atan2(math.hypot(*velocity[:2]), velocity[2])))
            if spin in (0, 2, 6):
                axis = [tools.rotate(sample["bodies"]["capsule"]["q"], (0, 0, 1)) for sample in run["samples"]]
                left.plot(tools.get_times(run), [math.degrees(math.acos(min(1, a[2]))) for a in axis], label=f"{spin} rad/s",
                          color={0: "#c1121f", 2: "#e09f3e", 6: "#457b9d"}[spin])
        left.set_xlabel("t, s")
        left.set_ylabel("axis off its line, deg")
        left.set_title("Retro-burn with the motor spun up to …", loc="left")
        left.legend()
        right.semilogy(spins, errors, "o-", color="#1d3557")
        right.set_xlabel("spin of the motor, rad/s")
        right.set_ylabel("direction of the velocity gained, deg off")
        right.set_title("Error of the burn against spin-up", loc="left")
        return drawn
