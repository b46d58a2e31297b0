"""Figures of the strap-on boosters: who is where, how they turn, what the nodes bear, how close they come, who holds the core."""
import cmath
import importlib.util
import math

from plots import campaign

COLOURS = ("#c1121f", "#457b9d", "#e09f3e", "#2a9d5c")
CASES = (("cyclogram.yaml", (), "nominal"), ("late-valve.yaml", (), "valve 1 late"),
         ("cyclogram.yaml", ("--set", "events.nozzle:booster1.enabled=false"), "nozzle 1 dead"),
         ("uncut-tie.yaml", (), "ties 2 hold"), ("imbalance.yaml", (), "engines unequal"))
UNTIL, EVERY = 2.5, 0.005


def run_case(bench, case):
    file, options, _ = case
    return bench.run(f"boosters/{file}", UNTIL, EVERY, *options)


# Of synthesis.yaml: where it starts, and its optimum.
DESIGNS = {
    "start: 9 kN, 12 ms, 5 mm, spread 5 %": {"thrust": "9 kN", "delay": "12 ms", "stroke": "5 mm", "spread": "0.05"},
    "optimum: 6.32 kN, 60 ms, 30 mm, spread 3.8 %": {"thrust": "6323.924 N", "delay": "60 ms", "stroke": "30 mm",
                                                     "spread": "0.03822565"},
}


NOZZLES = (("both open", ()), ("fuel shut", ("fuel_nozzle",)), ("oxidizer shut", ("nozzle",)), ("both shut", ("nozzle", "fuel_nozzle")))


def load_script(tools, name):
    spec = importlib.util.spec_from_file_location(name, tools.SCENARIOS / f"boosters/{name}.py")
    script = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(script)
    return script


def fly(bench, tools, name):
    """The columns of a flight with the reference flight software in the loop, by name, each 10 ms."""
    log = bench.folder / f"{name}.log"
    bench.call("hil", tools.SCENARIOS / f"boosters/{name}.yaml", "--transport", "inproc", "--pace", "lockstep", "--set",
               "flight_software.timeout=30", "--json", "-", "--log", log)
    run = bench.call("replay", log, "--outputs", "body.core.*@10,command.swing*@10", "--json", "-")
    table = run["outputs"][0]
    names = [column["name"] for output in table["outputs"] for column in output["columns"]]
    return run, table["t"], dict(zip(names, zip(*table["rows"])))


def plot_bode(columns, loop, colour, lines):
    frequencies = [10**(-1 + 0.005 * i) for i in range(660)]
    values = [loop.calc_open_loop(w) for w in frequencies]
    phases, last = [], -math.pi
    for value in values:  # unwound
        phase = cmath.phase(value)
        last = phase + 2 * math.pi * round((last - phase) / (2 * math.pi))
        phases.append(math.degrees(last))
    columns[0].semilogx(frequencies, [20 * math.log10(abs(v)) for v in values], lines, color=colour, label=loop.name)
    columns[1].semilogx(frequencies, phases, lines, color=colour)


def add(figure, tools):
    @figure("boosters-nozzles")
    def nozzles(bench):
        import matplotlib.pyplot as plt
        drawn, (left, right) = plt.subplots(1, 2, figsize=(7.5, 3.2), constrained_layout=True)
        for k, (label, shut) in enumerate(NOZZLES):
            options = [text for event in shut for text in ("--set", f"events.{event}:booster1.enabled=false")]
            run = bench.run("boosters/both-nozzles.yaml", UNTIL, EVERY, *options)
            style = dict(color=COLOURS[(1, 3, 2, 0)[k]], label=label, **tools.layer(k))
            left.plot(tools.get_times(run), [sample["clearance"][0] for sample in run["samples"]], **style)
            angles = []
            for sample in run["samples"]:
                core, body = sample["bodies"]["core"], sample["bodies"]["booster1"]
                x, y, _ = tools.into(core["q"], tools.rotate(body["q"], (1, 0, 0)))
                angles.append(math.degrees(math.atan2(y, x)))
            right.plot(tools.get_times(run), angles, **style)
        left.set(xlim=(1, 2.5), ylim=(0, 3), xlabel="t, s", ylabel="core to booster 1, m")
        right.set(xlim=(1, 2.5), xlabel="t, s", ylabel="nose of booster 1 outwards, deg")
        left.set_title("Nozzles of booster 1", loc="left")
        left.legend()
        return drawn

    @figure("boosters-attitude-loop")
    def attitude_loop(bench):
        import matplotlib.pyplot as plt
        drawn, grid = plt.subplots(3, 2, figsize=(7.5, 7.6), constrained_layout=True)
        for column, (name, title) in zip(range(2), (("open-loop", "open loop"), ("attitude-loop", "closed loop"))):
            run, times, values = fly(bench, tools, name)
            for i, axis in enumerate("xyz"):
                grid[0][column].plot(times, [math.degrees(2 * v) for v in values[f"core.q{axis}"]], color=COLOURS[i], label=f"about {axis}")
            grid[0][column].set_title(f"{title}: turn of the core", loc="left")
            grid[0][column].set_ylabel("deg")
            if column == 1:
                for k in range(4):
                    grid[1][0].plot(times, [math.degrees(v) for v in values[f"channel.swing{k + 1}"]], color=COLOURS[k], label=f"chamber {k + 1}")
                for i, axis in enumerate("xyz"):
                    grid[1][1].plot(times, [math.degrees(v) for v in values[f"core.w{axis}"]], color=COLOURS[i], label=f"about {axis}")
        grid[1][0].set_title("closed loop: swing of the verniers", loc="left")
        grid[1][1].set_title("closed loop: rate of the core", loc="left")
        grid[1][0].set_ylabel("deg")
        grid[1][1].set_ylabel("deg/s")
        for axes in (*grid[0], *grid[1]):
            axes.set(xlabel="t, s", xlim=(0, 8))
            axes.axvspan(1.27, 1.35, color="0.9", zorder=0)
        grid[0][0].legend()
        grid[1][0].set_ylim(-5.5, 9)  # room for the legend above the curves
        grid[1][0].legend(loc="upper right", ncols=2)
        loops = load_script(tools, "loop_margins").list_loops()
        for loop in loops:
            plot_bode(grid[2], loop, COLOURS[1] if loop.name.startswith("y") else COLOURS[0], "-" if "alone" in loop.name else "--")
        margins = loops[0].calc_margins()
        grid[2][0].plot([margins["gain_at"]] * 2, [-20 * math.log10(margins["gain"]), 0], color="0.2", linewidth=2)
        grid[2][0].annotate(f"{20 * math.log10(margins['gain']):.0f} dB", (margins["gain_at"], 3), ha="center", fontsize=tools.LABEL)
        grid[2][1].plot([margins["phase_at"]] * 2, [-180, -180 + math.degrees(margins["phase"])], color="0.2", linewidth=2)
        grid[2][1].annotate(f"{math.degrees(margins['phase']):.0f} deg", (margins["phase_at"] * 1.2, -172), fontsize=tools.LABEL)
        grid[2][0].axhline(0, color="0.5", linewidth=0.8)
        grid[2][1].axhline(-180, color="0.5", linewidth=0.8)
        grid[2][0].set(ylabel="open loop, dB", xlabel="1/s", ylim=(-50, 60))
        grid[2][1].set(ylabel="phase, deg", xlabel="1/s", ylim=(-270, -90))
        grid[2][0].legend(fontsize=tools.LABEL - 1)
        return drawn

    @figure("boosters-assumptions")
    def assumptions(bench):
        import matplotlib.pyplot as plt
        drawn, axes = plt.subplots(figsize=(7.5, 3.2), constrained_layout=True)
        base = run_case(bench, CASES[0])
        for k, (file, label) in enumerate((("no-assumptions", "both"), ("variable-mass", "core and boosters burn"), ("central-field", "central field"))):
            run = bench.run(f"boosters/{file}.yaml", UNTIL, EVERY)
            gaps = []
            for one, other in zip(base["samples"], run["samples"]):
                places = [tools.seen_from(sample["bodies"]["core"], sample["bodies"]["booster1"], (0, 0, 0)) for sample in (one, other)]
                gaps.append(max(math.dist(*places), 1e-9))
            axes.semilogy(tools.get_times(run), gaps, color=(COLOURS[3], COLOURS[0], COLOURS[1])[k], label=label, **tools.layer(2 * k, 3))
        axes.set(xlim=(0, UNTIL), ylim=(1e-8, 1), xlabel="t, s", ylabel="difference of place, m")
        axes.set_title("Booster 1 seen from the core, against constant masses in a uniform field", loc="left")
        tools.mark_events(axes, base, ("ties_cut", "cutoff", "release", "liftoff"), labels=False)
        axes.legend()
        return drawn

    @figure("boosters-separation")
    def separation(bench):
        import matplotlib.pyplot as plt
        drawn, rows = plt.subplots(3, 1, figsize=(7.5, 6.4), sharex=True, constrained_layout=True)
        for axes, case in zip(rows, (CASES[0], CASES[2], CASES[4])):
            run = run_case(bench, case)
            for i, time in enumerate((0.0, 1.3, 1.7, 2.1, 2.5)):
                sample = min(run["samples"], key=lambda s: abs(s["t"] - time))
                core = sample["bodies"]["core"]
                for k in (1, 3):
                    body = sample["bodies"][f"booster{k}"]
                    corners = [tools.seen_from(core, body, p)
                               for p in ((13.2, 0, 0), (-5.5, 1.34, 0), (-5.5, -1.34, 0), (13.2, 0, 0))]
                    axes.plot([c[0] for c in corners], [c[1] for c in corners], color=COLOURS[k - 1],
                              alpha=0.3 + 0.175 * i, linewidth=1, label=f"booster {k}" if i == 4 else None)
            for x0, x1, r in ((-19.5, 1, 1.025), (1, 26, 1.33)):
                axes.fill([x0, x1, x1, x0], [-r, -r, r, r], color="0.85", zorder=0)
            axes.set_aspect("equal")
            axes.set(xlim=(-28, 28), ylim=(-11, 11), ylabel="across, m")
            axes.set_title(f"{case[2]}: boosters 1 and 3 in the core's axes at 0, 1.3, 1.7, 2.1, 2.5 s", loc="left")
        rows[0].legend(loc="upper right")
        rows[-1].set_xlabel("along the core, m")
        return drawn

    @figure("boosters-reactions")
    def reactions(bench):
        import matplotlib.pyplot as plt
        run = run_case(bench, CASES[0])
        times = tools.get_times(run)
        drawn, rows = plt.subplots(3, 1, figsize=(7.5, 6), sharex=True, constrained_layout=True)
        rows[0].set_xlim(0, 1.5)
        for axes, row, unit in zip(rows, ("x", "z", "rot_y"), ("kN", "kN", "kN m")):
            axes.plot(times, [v / 1000 for v in tools.get_row(run, "nose1", row)], color=COLOURS[0])
            axes.set_ylabel(f"{row}, {unit}")
            tools.mark_events(axes, run, ("throttle", "verniers_off", "rudders_neutral", "ties_cut", "cutoff", "release",
                                          "contact", "liftoff"), labels=axes is rows[0])
        drawn.suptitle("What node 1 bears, core on booster: along its generatrix, across it, and the ties' moment", fontsize=10)
        rows[-1].set_xlabel("t, s")
        return drawn

    @figure("boosters-attitude")
    def attitude(bench):
        import matplotlib.pyplot as plt
        drawn, grid = plt.subplots(len(CASES), 2, figsize=(7.5, 9), sharex=True, sharey="col", constrained_layout=True)
        for row, case in zip(grid, CASES):
            run = run_case(bench, case)
            times = tools.get_times(run)
            for k in range(1, 5):
                angles, rates = [], []
                for sample in run["samples"]:
                    body, core = sample["bodies"][f"booster{k}"], sample["bodies"]["core"]
                    axis = tools.into(core["q"], tools.rotate(body["q"], (1, 0, 0)))
                    angles.append(math.degrees(math.acos(max(-1, min(1, axis[0])))))
                    rates.append(math.degrees(math.hypot(*body["w"])))
                style = dict(color=COLOURS[k - 1], label=f"booster {k}", **tools.layer(k - 1))
                row[0].plot(times, angles, **style)
                row[1].plot(times, rates, **style)
            row[0].set_title(case[2], loc="left")
            row[0].set_ylabel("deg")
            row[1].set_ylabel("deg/s")
        grid[0][0].set_title("angle to the core", loc="right")
        grid[0][1].set_title("angular rate", loc="right")
        for axes in grid[-1]:
            axes.set_xlabel("t, s")
        grid[0][0].legend()
        return drawn

    @figure("boosters-clearance")
    def clearance(bench):
        import matplotlib.pyplot as plt
        drawn, axes = plt.subplots(figsize=(7.5, 3), constrained_layout=True)
        for i, case in enumerate(CASES):
            run = run_case(bench, case)
            found = {pair["pair"][1]: pair for pair in run["clearance"] if pair["pair"][0] == "core"}
            for k in range(1, 5):
                pair = found[f"booster{k}"]
                axes.bar(i + 0.2 * (k - 2.5), pair["min"], 0.18, color=COLOURS[k - 1],
                         label=f"booster {k}" if i == 0 else None)
                axes.annotate(f"{pair['t']:.2f} s", (i + 0.2 * (k - 2.5), pair["min"]), rotation=90, ha="center",
                              va="bottom", fontsize=tools.LABEL, xytext=(0, 2), textcoords="offset points")
        axes.set_axisbelow(True)
        axes.set_xticks(range(len(CASES)), [case[2] for case in CASES])
        axes.set_ylim(0, axes.get_ylim()[1] * 1.4)
        axes.set_ylabel("least distance to the core, m")
        axes.set_title("How close the boosters come to the core after the ties are cut, and when", loc="left")
        axes.legend(ncols=4)
        return drawn

    @figure("boosters-recontact")
    def recontact(bench):
        import matplotlib.pyplot as plt
        drawn, (left, right) = plt.subplots(1, 2, figsize=(7.5, 3), constrained_layout=True)
        cases = (("cyclogram.yaml", ("--set", "events.contact:booster1.enabled=false"), "without contact: it flies through", "0.55"),
                 ("recontact.yaml", (), "with contact", COLOURS[0]))
        for file, options, label, colour in cases:
            for axes, first, last, every, scale in ((left, 2.2, 3.35, 0.01, 100), (right, 2.54, 2.6, 0.0005, 1000)):
                run = bench.run(f"boosters/{file}", 3.35 if axes is left else 2.6, every, *options)
                shown = [(sample["t"], scale * sample["clearance"][0]) for sample in run["samples"] if first <= sample["t"] <= last + 1e-9]
                axes.plot(*zip(*shown), color=colour, label=label)
        for axes, unit in ((left, "cm"), (right, "mm")):
            axes.axhline(0, color="0.3", linewidth=0.8)
            axes.set_xlabel("time, s")
            axes.set_ylabel(f"core to booster 1, {unit}")
        left.legend(loc="upper left")
        left.set_title("A booster whose nozzle stays shut", loc="left")
        right.set_title("The strike, 18 ms", loc="left")
        return drawn

    @figure("boosters-optimize")
    def optimum(bench):
        import matplotlib.pyplot as plt
        drawn, columns = plt.subplots(1, 2, figsize=(7.5, 3.4), sharey=True, constrained_layout=True)
        for axes, (title, values) in zip(columns, DESIGNS.items()):
            options = [text for name, value in values.items() for text in ("--set", f"constants.{name}={value}")]
            run = bench.call("run", tools.SCENARIOS / "boosters/design.yaml", "--outputs", "clearance.core.*", "--json", "-",
                             *options)
            table = run["outputs"][0]
            for k in (1, 3):
                axes.plot(table["t"], [row[k - 1] for row in table["rows"]], color=COLOURS[k - 1], label=f"boosters {k}, {k + 1}",
                          **tools.layer(k, 4))
            axes.plot([2.5], [4], marker="^", color="0.2", linestyle="none", label="at least 4 m", clip_on=False, zorder=5)
            axes.axvline(1.45, color="0.6", linewidth=0.8, linestyle="--", label="lifted off by 1.45 s")
            axes.set_xlim(0, 2.5)
            axes.set_ylim(0, 5)
            axes.set_xlabel("t, s")
            axes.set_title(title, loc="left", fontsize=tools.LABEL + 1)
            liftoffs = ", ".join(f"{event['t']:.3f}" for event in run["events"]
                                 if event["name"] == "liftoff" and event["subject"] in ("booster1", "booster3"))
            axes.annotate(f"liftoffs {liftoffs} s", (0.03, 0.5), xycoords="axes fraction", fontsize=tools.LABEL)
        columns[0].set_ylabel("distance to the core, m")
        columns[0].legend(loc="upper left")
        return drawn

    @figure("boosters-front")
    def front(bench):
        import matplotlib.pyplot as plt
        check = load_script(tools, "check_front")
        found = check.compare(bench.program, bench.folder, (25, 3, 41))
        drawn, axes = plt.subplots(figsize=(7.5, 3.6), constrained_layout=True)
        axes.plot(*zip(*((nozzle / 1e3, 100 * unlike) for nozzle, unlike in found["grid"])), ".", color="0.75", markersize=4,
                  label=f"the {found['met']} of {found['designs']} designs of a grid that meet all")
        for points, style, label in ((found["scanned"], {"marker": "s", "color": "#457b9d", "markersize": 7}, "the best of the grid"),
                                     (found["front"], {"marker": "o", "color": "#c1121f", "markersize": 4}, "Pareto front of the search")):
            axes.plot(*zip(*((nozzle / 1e3, 100 * unlike) for nozzle, unlike in points)), linestyle="none", label=label, **style)
        axes.set(xlim=(4.8, 7), ylim=(0, 28), xlabel="nozzle thrust, kN", ylabel="spread of the tail-offs, %")
        axes.legend(loc="upper left", ncols=3, columnspacing=1, handletextpad=0.2)
        return drawn

    @figure("boosters-campaign")
    def dispersion(bench):
        ids = [f"leaves{k}" for k in range(1, 5)]
        return campaign.draw(bench, tools, "boosters/campaign.yaml", ids, "boosters lift off", "s", labels=[f"booster {k}" for k in range(1, 5)],
                             colours=COLOURS, driven="leaves3", events=("release", "contact", "nozzle", "liftoff"), rows=16)

    @figure("boosters-rare")
    def rare(bench):
        import csv

        import matplotlib.pyplot as plt
        file = tools.SCENARIOS / "boosters/campaign-rare.yaml"
        found = bench.call("campaign", file, "--out", bench.folder / "rare", "--json", "-")["rare"]
        limit = found["limit"]
        plain = bench.folder / "plain.yaml"  # as many independent samples
        plain.write_text("\n".join(line for line in file.read_text().splitlines()
                                   if not line.startswith(("sampling:", "subset:", "samples:")))
                         .replace("reference.yaml", str(file.parent / "reference.yaml")) + f"\nsamples: {found['levels_run'][-1]['last']}\n")
        bench.call("campaign", plain, "--out", bench.folder / "plain", "--json", "-")
        with open(bench.folder / "plain/samples.csv", newline="", encoding="utf-8") as table:
            times = sorted(float(row[f"{found['column']} [s]"] or "inf") for row in csv.DictReader(table))
        drawn, axes = plt.subplots(figsize=(7.5, 3.4), constrained_layout=True)
        axes.step(times, [1 - k / len(times) for k in range(len(times))], where="post", color="0.6", label=f"{len(times)} independent samples")
        axes.plot([limit - margin for margin, _ in found["curve"]], [p for _, p in found["curve"]], color=COLOURS[0],
                  label=f"subset simulation, {len(times)} samples")
        before = 1
        for level in found["levels_run"]:
            before *= level["probability"]
            axes.plot([limit - level["threshold"]], [before], marker="o", markersize=4, color=COLOURS[1], linestyle="none",
                      label="levels" if level is found["levels_run"][0] else None)
        axes.plot([limit, limit], found["interval"], color=COLOURS[1], linewidth=3, alpha=0.5, label="95 %")
        axes.set_yscale("log")
        axes.set_xlabel("booster 1 leaves later than, s")
        axes.set_ylabel("probability")
        axes.legend(loc="lower left")
        return drawn
