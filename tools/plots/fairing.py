"""Figures of the elastic fairing halves: modes (the paper's figure 10) beside the curved beam's, the way of the halves, the
elastic displacement of the dangerous points (figure 11), the room that is left to the payload."""
import importlib.machinery
import importlib.util
import math

MODES = "fairing/fairing.modes"
CENTRE = (0, 1.153, 5.700)  # of mass of a half, in the file's axes, m

# Of synthesis.yaml: where it starts, and its optimum.
DESIGNS = {
    "start: 140 kN/m, 0.52 m, 65 deg": {"stiffness": "140 kN/m", "stroke": "0.52 m", "release_angle": "65 deg"},
    "optimum: 50 kN/m, 0.723 m, 57.4 deg": {"stiffness": "50 kN/m", "stroke": "0.7227337 m", "release_angle": "1.0011010 rad"},
}

FLOWN = 16  # samples of campaign.yaml


def read_modes(tools):
    """Frequencies in Hz and points (mass, place, displacements by mode) of the halves' file, by the reader of tools/envelope."""
    loader = importlib.machinery.SourceFileLoader("envelope", str(tools.ROOT / "tools/envelope"))
    envelope = importlib.util.module_from_spec(importlib.util.spec_from_loader("envelope", loader))
    loader.exec_module(envelope)
    hz, rows, _ = envelope.read_modes(tools.SCENARIOS / MODES)
    return hz, [(row[0], row[1:4], row[4:].reshape(-1, 3)) for row in rows]


def add(figure, tools):
    if not (tools.SCENARIOS / MODES).exists():
        return

    @figure("fairing-modes")
    def modes(bench):
        import matplotlib.pyplot as plt
        from matplotlib.tri import Triangulation
        hz, points = read_modes(tools)
        beams = {1: "R1", 4: "R2", 5: "R3"}  # as `unlatch modes shell` matches them
        places = [place for _, place, _ in points]
        # The shell is unrolled, so that adjacent points are adjacent in the plane.
        net = Triangulation([2 * math.atan2(place[1], place[0]) for place in places], [place[2] for place in places]).triangles
        net = [three for three in net if max(math.dist(places[a], places[b]) for a, b in zip(three, three[[1, 2, 0]])) < 1]
        drawn = plt.figure(figsize=(7.5, 3.4))
        for k in range(5):
            axes = drawn.add_axes((0.2 * k - 0.05, 0.0, 0.3, 1.0), projection="3d")
            scale = 1.0 / max(math.hypot(*shape[k]) for _, _, shape in points)
            moved = [[a + scale * b for a, b in zip(place, shape[k])] for _, place, shape in points]
            size = [scale * math.hypot(*shape[k]) for _, _, shape in points]
            shell = axes.plot_trisurf(*zip(*moved), triangles=net, cmap="viridis", shade=False, linewidth=0.1)
            shell.set_array([sum(size[i] for i in corners) / 3 for corners in net])
            shell.set(clim=(0, 1), edgecolor="face", rasterized=True, clip_on=False)
            for side in (2, -2):
                axes.plot([side, side, 0], [0, 0, 0], [0, 8, 14], color="0.6", linewidth=0.7, linestyle=":", clip_on=False)
            axes.set(xlim=(-3, 3), ylim=(-1, 3), zlim=(0, 14))
            axes.set_box_aspect((6, 4, 14), zoom=1.12)
            axes.view_init(16, -62)
            axes.set_axis_off()
            axes.patch.set_visible(False)  # it would cover the neighbour
            drawn.text(0.2 * k + 0.1, 0.95, f"{k + 1}: {hz[k]:.2f} Hz{', ' + beams[k + 1] if k + 1 in beams else ''}",
                       ha="center", fontsize=9)
        scale = drawn.add_axes((0.4, 0.1, 0.2, 0.02))
        bar = drawn.colorbar(shell, cax=scale, orientation="horizontal", ticks=(0, 0.5, 1))
        bar.set_label("displacement, of the largest", fontsize=8)
        bar.ax.tick_params(labelsize=6)
        return drawn

    @figure("fairing-zone")
    def zone(bench):
        import matplotlib.pyplot as plt
        options = ("--of", "half1", "--seen-from", "core", "--origin", "0,0,3", "--stations", "0:12:0.5", "--azimuths", "36", "--wall", "0.01",
                   "--every", "4", "--until", "1.6")
        nominal = bench.sweep("fairing/scenario.yaml", *options)
        dispersed = bench.sweep("fairing/campaign.yaml", *options, "--samples", f"0:{FLOWN}")
        dead = bench.sweep("fairing/scenario.yaml", *options, "--set", "elements.push1_left.enabled=false")
        stations = nominal["stations"]
        drawn, (left, right) = plt.subplots(1, 2, figsize=(7.5, 4.4), sharey=True, constrained_layout=True)
        lost = [[math.nan if a is None or b is None else 1e3 * (a - b) for a, b in zip(*rows)] for rows in zip(nominal["stiff"], dispersed["radius"])]
        image = left.pcolormesh([90 - math.degrees(a) for a in nominal["azimuths"]], stations, lost, cmap="viridis_r", vmin=0)
        drawn.colorbar(image, ax=left, label="room lost to a stiff half's, mm", location="bottom")
        left.set(xlabel="azimuth from the middle of half 1, deg", ylabel="station from the base, m", xlim=(-100, 100), xticks=(-90, -45, 0, 45, 90))
        left.set_title(f"Half 1, {FLOWN} dispersed flights", loc="left")
        left.grid(False)
        for label, grid, colour in (("stiff", nominal["stiff"], "0.55"), ("elastic", nominal["radius"], "#457b9d"),
                                    (f"worst of {FLOWN} dispersed", dispersed["radius"], "#e09f3e"), ("one pusher dead", dead["radius"], "#c1121f")):
            least = [min((value for value in row if value is not None), default=math.nan) for row in grid]
            right.step([*least, least[-1]], stations, where="post", color=colour, label=label)
        right.plot([1.6, 1.6, 0], [0.3, 8, 8], color="0.2", linestyle="--", label="payload")
        right.set(xlabel="smallest radius, m", xlim=(0.8, 2.05), ylim=(0, 10))
        right.legend(loc="lower left")  # left of the payload's line
        return drawn

    @figure("fairing-unzip")
    def unzip(bench):
        import matplotlib.pyplot as plt
        drawn, (left, right) = plt.subplots(1, 2, figsize=(7.5, 3.3), constrained_layout=True)
        flights = [("at once", "scenario.yaml", (), "0.2", "-")]
        flights += [(f"{speed} m/s" if end == "base" else None, "unzip.yaml", ("--set", f"constants.speed={speed} m/s", "--set", f"constants.begin={begin}"), colour, style)
                    for speed, colour in ((1000, "#457b9d"), (400, "#2a9d5c"), (200, "#e09f3e"), (100, "#c1121f"))
                    for end, begin, style in (("base", "0 m", "-"), ("nose", "13.97 m", "--")) if (speed, end) != (1000, "nose")]  # that one is the other
        for label, file, options, colour, style in flights:
            run = bench.call("run", tools.SCENARIOS / "fairing" / file, "--outputs",
                             "clearance.core.half1_base_left@10,joint.hinge1.angle@10", "--json", "-", *options)
            table = run["outputs"][0]
            names = [column["name"] for output in table["outputs"] for column in output["columns"]]
            columns = dict(zip(names, zip(*table["rows"])))
            angle, gap = columns["hinge1.angle.x"], columns["clearance.core.half1_base_left"]
            released = min((event["t"] for event in run["events"] if event["name"] == "release"), default=math.inf)
            until = sum(t <= released for t in table["t"])
            left.plot(table["t"][:until], [abs(math.degrees(v)) for v in angle[:until]], color=colour, linestyle=style, label=label)
            right.plot(table["t"][:until], gap[:until], color=colour, linestyle=style, label=label)
        left.axhline(60, color="0.6", linewidth=0.8, linestyle="--")
        left.set(xlabel="t, s", ylabel="hinge of half 1, deg", xlim=(0, 3))
        left.set_title("Solid: the joint opens from the base", loc="left")
        right.set(xlabel="t, s", ylabel="base edge to payload, m", xlim=(0, 1.5), ylim=(0.2, 0.8))
        right.plot([], [], color="0.5", linestyle="--", label="from the nose")
        right.set_title("Edge at the base", loc="left")
        right.legend(loc="upper center", ncol=3)
        return drawn

    @figure("fairing-arc")
    def arc(bench):
        import matplotlib.pyplot as plt
        models = bench.call("modes", "arc", "--radius", 2, "--thickness", 0.01, "--json", "-")["models"]
        drawn, columns = plt.subplots(1, 3, figsize=(7.5, 2.8), sharey=True, constrained_layout=True)
        for k, axes in enumerate(columns):
            for model, style, name in zip(models, ("--", "-"), ("(3.4)", "exact arc")):
                mode = model["modes"][k]
                count = len(mode["radial"])
                turns = [math.pi * i / (count - 1) for i in range(count)]
                tangential = mode["tangential"] or [0] * count
                sign = 1 if mode["radial"][0] > 0 else -1
                x = [(2 + 0.5 * sign * w) * math.cos(t) - 0.5 * sign * u * math.sin(t)
                     for t, w, u in zip(turns, mode["radial"], tangential)]
                y = [(2 + 0.5 * sign * w) * math.sin(t) + 0.5 * sign * u * math.cos(t)
                     for t, w, u in zip(turns, mode["radial"], tangential)]
                axes.plot(x, y, style, color="#c1121f" if style == "-" else "#457b9d", label=f"{name}: {mode['hz']:.2f} Hz")
            axes.plot([2 * math.cos(t) for t in turns], [2 * math.sin(t) for t in turns], color="0.7", linewidth=0.8)
            axes.set(xlim=(-2.75, 2.75), ylim=(-0.2, 2.5), xlabel="x, m", aspect="equal")
            axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.35))
            axes.set_title(f"R{k + 1}", loc="left")
        columns[0].set_ylabel("y, m")
        return drawn

    @figure("fairing-ascent")
    def ascent(bench):
        import matplotlib.pyplot as plt
        drawn, (left, middle, right) = plt.subplots(1, 3, figsize=(7.5, 2.9), constrained_layout=True)
        for label, options, colour in (("without air", ("--set", "constants.area=1e-9 m2"), "#1d3557"), ("in air", (), "#c1121f")):
            run = bench.run("fairing/ascent.yaml", 3, 0.02, *options)
            times, bodies = tools.get_times(run), [sample["bodies"] for sample in run["samples"]]
            noses, bases = ([tools.seen_from(b["core"], b[f"half1_{marker}"], [0, 0, 0]) for b in bodies] for marker in ("nose", "base_left"))
            leans = [tools.into(b["core"]["q"], tools.rotate(b["half1"]["q"], [0, 0, 1])) for b in bodies]
            release = min(event["t"] for event in run["events"] if event["name"] == "release")
            left.plot(times, [math.degrees(math.atan2(lean[1], lean[2])) for lean in leans], color=colour, label=f"{label}: {release:.3f} s")
            middle.plot([n[1] for n in noses], [n[2] - 3 for n in noses], color=colour)
            right.plot(times, [math.hypot(b[0], b[1]) - 1.6 for b in bases], color=colour)
        left.axhline(60, color="0.6", linewidth=0.8, linestyle="--")
        left.set(xlabel="t, s", ylabel="half 1, deg; dashed: release", ylim=(0, 155))
        left.set_title("Opening", loc="left")
        left.legend(loc="upper left")
        middle.set(xlabel="from the core's axis, m", ylabel="from the base, m")
        middle.set_title("Path of the nose", loc="left")
        right.set(xlabel="t, s", ylabel="from the payload's cylinder, m", xlim=(0, 1.6), ylim=(0, 0.8))
        right.set_title("Edge at the base", loc="left")
        return drawn

    points = (("base", "#c1121f"), ("middle", "#e09f3e"), ("top", "#457b9d"))

    @figure("fairing-displacement")
    def displacement(bench):
        import matplotlib.pyplot as plt
        run = bench.run("fairing/scenario.yaml", 3, 0.002)
        times = tools.get_times(run)
        drawn, rows = plt.subplots(2, 1, figsize=(7.5, 4.6), sharex=True, constrained_layout=True)
        for name, colour in points:
            places = [tools.seen_from(sample["bodies"]["half1"], sample["bodies"][f"half1_{name}_left"], (0, 0, 0))
                      for sample in run["samples"]]
            for axes, axis in zip(rows, (0, 1)):  # the run begins undeformed
                axes.plot(times, [1000 * (place[axis] - places[0][axis]) for place in places], color=colour, label=name)
        for axes, text in zip(rows, ("outwards (x), mm", "with the pushers (y), mm")):
            axes.set_ylabel(text)
            axes.set_xlim(0, 3)
            tools.mark_events(axes, run, ("pushed", "release"), labels=axes is rows[0])
        rows[0].legend(ncols=3, loc="upper right")
        drawn.suptitle("Elastic displacement of the free edge of half 1 at its base, middle and top (figure 11)", fontsize=10)
        rows[1].set_xlabel("t, s")
        return drawn

    def calc_gap(sample, name):
        """From the payload, a cylinder in the core's axes, to the skin at a marker of half 1."""
        x, y, z = tools.seen_from(sample["bodies"]["core"], sample["bodies"][name], (0, 0, 0))
        return math.hypot(max(0, math.hypot(x, y) - 1.6), max(0, 3.3 - z, z - 11))

    @figure("fairing-separation")
    def separation(bench):
        import matplotlib.pyplot as plt
        scenario = "fairing/scenario.yaml"
        run = bench.run(scenario, 3, 0.002)
        release = next(event["t"] for event in run["events"] if event["name"] == "release")
        drawn, (way, gap) = plt.subplots(2, 1, figsize=(7.5, 6.6), height_ratios=(1, 0.85), constrained_layout=True)
        way.fill([-1.6, 1.6, 1.6, -1.6], [3.3, 3.3, 11, 11], color="0.8", zorder=0)
        way.annotate("payload", (0, 10.6), ha="center", va="top", fontsize=8, color="0.3")
        for time in (0.0, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0):
            sample = min(run["samples"], key=lambda s: abs(s["t"] - time))
            for half in (1, 2):
                outline = [tools.seen_from(sample["bodies"]["core"], sample["bodies"][f"half{half}_{name}"], (0, 0, 0))
                           for name in ("nose", "top_left", "middle_left", "base_left", "hinge")]
                # Start of the cone opposite to the free edges: it has no marker, so it is drawn as rigid.
                back = [b - a for a, b in zip(CENTRE, (0, 2, 8))]
                outline.append(tools.seen_from(sample["bodies"]["core"], sample["bodies"][f"half{half}"], back))
                colour = "#457b9d" if time < release else "#e09f3e"
                y, z = ([p[axis] for p in outline + outline[:1]] for axis in (1, 2))
                way.fill(y, z, color=colour, linewidth=0, alpha=0.35)
                way.plot(y, z, color=colour, linewidth=0.8)
            if time > 0:
                place = tools.seen_from(sample["bodies"]["core"], sample["bodies"]["half1_nose"], (0, 0, 0))
                way.annotate(f"{time:g} s", place[1:], xytext=(3, 3), textcoords="offset points", fontsize=8)
        way.set(aspect="equal", xlabel="y, m", ylabel="z, m")
        way.set_title("From the side, in the core's axes: the halves every 0.5 s, on their hinges (blue) and free (ochre)", loc="left")
        rigid = bench.run(scenario, 3, 0.002, *(word for half in (1, 2) for word in
                                                ("--set", f"bodies.half{half}.flexible.select=[8]")))
        for each, style in ((run, "-"), (rigid, "--")):
            for name, colour in points:
                gap.plot(tools.get_times(each), [calc_gap(sample, f"half1_{name}_left") for sample in each["samples"]], style,
                         color=colour, label=name if style == "-" else f"{name}, stiff")
        gap.set(xlim=(0, 1.2), ylim=(0.2, 1.2), xlabel="t, s", ylabel="distance, m")
        gap.legend(ncols=2, loc="upper left")
        gap.set_title("Distance of half 1's free edge from the payload, elastic and stiff (its eighth mode alone)", loc="left")
        return drawn

    @figure("fairing-optimize")
    def optimum(bench):
        import matplotlib.pyplot as plt
        drawn, columns = plt.subplots(1, 2, figsize=(7.5, 3.4), sharey=True, constrained_layout=True)
        edges = ("base", "middle", "top")
        for axes, (title, values) in zip(columns, DESIGNS.items()):
            options = [text for name, value in values.items() for text in ("--set", f"constants.{name}={value}")]
            run = bench.call("run", tools.SCENARIOS / "fairing/design.yaml", "--outputs",
                             ",".join(f"clearance.core.half1_{edge}_left" for edge in edges), "--json", "-", *options)
            table = run["outputs"][0]
            release = next(event["t"] for event in run["events"] if event["name"] == "release")
            for k, (edge, colour) in enumerate(zip(edges, ("#c1121f", "#e09f3e", "#457b9d"))):
                axes.plot(table["t"], [row[k] for row in table["rows"]], color=colour, label=edge)
            axes.plot([0, release], [0.22, 0.22], color="0.3", linewidth=0.8, linestyle="--", label="zone")
            axes.plot([release, 3], [0.6, 0.6], color="0.3", linewidth=0.8, linestyle="--")
            axes.axvline(release, color="0.7", linewidth=0.8)
            axes.annotate(f"release {release:.3f} s", (release, 1.4), xytext=(-3, 0), textcoords="offset points", rotation=90,
                          fontsize=tools.LABEL, ha="right", va="top")
            axes.set(xlim=(0, 3), ylim=(0, 1.5), xlabel="t, s")
            axes.set_title(title, loc="left", fontsize=tools.LABEL + 1)
        columns[0].set_ylabel("edge of half 1 to the payload, m")
        columns[0].legend(loc="lower left", ncols=4)
        return drawn
