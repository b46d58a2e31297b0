"""Figures of the elastic fairing halves: modes (the paper's figure 10) beside the curved beam's, the way of the halves, the
elastic displacement of the dangerous points (figure 11)."""
import math

MODES = "fairing/fairing.modes"


def read_modes(path):
    """Frequencies in Hz and points (mass, place, displacements by mode) of a modes file."""
    hz, points, left = [], [], 0
    for line in path.read_text().splitlines():
        words = line.split("#")[0].split()
        if left > 0 and words:
            values = list(map(float, words))
            points.append((values[0], values[1:4], [values[4 + 3 * k:7 + 3 * k] for k in range(len(hz))]))
            left -= 1
        elif words[:1] == ["frequencies"]:
            hz = list(map(float, words[1:]))
        elif words[:1] == ["points"]:
            left = int(words[1])
    return hz, points


def add(figure, tools):
    if not (tools.SCENARIOS / MODES).exists():
        return

    @figure("fairing-modes")
    def modes(bench):
        import matplotlib.pyplot as plt
        hz, points = read_modes(tools.SCENARIOS / MODES)
        drawn = plt.figure(figsize=(10, 4.2), constrained_layout=True)
        for k in range(4):
            axes = drawn.add_subplot(1, 4, k + 1, projection="3d")
            scale = 1.2 / max(math.hypot(*shape[k]) for _, _, shape in points)
            moved = [[a + scale * b for a, b in zip(place, shape[k])] for _, place, shape in points]
            size = [math.hypot(*shape[k]) * scale for _, _, shape in points]
            axes.scatter(*zip(*moved), c=size, s=1.5, cmap="viridis")
            axes.set_box_aspect((4, 4, 14))
            axes.view_init(12, -60)
            axes.set_axis_off()
            axes.set_title(f"{k + 1}: {hz[k]:.2f} Hz")
        return drawn

    @figure("fairing-arc")
    def arc(bench):
        import matplotlib.pyplot as plt
        models = bench.call("modes", "arc", "--radius", 2, "--thickness", 0.01, "--json", "-")["models"]
        drawn, columns = plt.subplots(1, 3, figsize=(10, 3), constrained_layout=True)
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
            axes.set_aspect("equal")
            axes.legend(fontsize=7, loc="lower center")
            axes.set_title(f"R{k + 1}", loc="left")
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
            tools.mark_events(axes, run, ("pushed", "release"))
        rows[0].legend(fontsize=7, ncols=3)
        rows[0].set_title("Elastic displacement of the free edge of half 1 at its base, middle and top (figure 11)", loc="left")
        rows[1].set_xlabel("t, s")
        return drawn

    @figure("fairing-separation")
    def separation(bench):
        import matplotlib.pyplot as plt
        run = bench.run("fairing/scenario.yaml", 3, 0.002)
        drawn, axes = plt.subplots(figsize=(7.5, 4), constrained_layout=True)
        axes.fill([-1.6, 1.6, 1.6, -1.6], [0.3, 0.3, 8, 8], color="0.85", zorder=0)
        for half, colour in ((1, "#c1121f"), (2, "#457b9d")):
            for i, time in enumerate((0.0, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0)):
                sample = min(run["samples"], key=lambda s: abs(s["t"] - time))
                outline = [sample["bodies"][f"half{half}_{name}"]["p"]
                           for name in ("hinge", "base_left", "middle_left", "top_left", "nose")]
                axes.plot([p[1] for p in outline], [p[2] for p in outline], color=colour, alpha=0.3 + 0.1 * i)
        axes.set_aspect("equal")
        axes.set_xlabel("y, m")
        axes.set_ylabel("z, m")
        axes.set_title("Hinges, free edges and noses of the halves every 0.5 s; the payload", loc="left")
        return drawn
