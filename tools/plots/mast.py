"""Figures of a pantograph boom: pictures while it deploys, its length, the pull of the cable and the load of its first hinge."""

HALF, UNITS = 0.5, 20  # m
COLOURS = ("#1d3557", "#2a9d8f", "#c1121f")


def locate(body, point, tools):
    return [a + b for a, b in zip(body["p"], tools.rotate(body["q"], point))]


def add(figure, tools):
    @figure("mast-deployment")
    def deployment(bench):
        import matplotlib.pyplot as plt
        drawn, axes = plt.subplots(figsize=(7.5, 4.2), constrained_layout=True)
        run = bench.run("mast/scenario.yaml", 8, 0.01)
        for row, time in enumerate((0, 4, 5.5, 6.5, 7.3)):
            sample = min(run["samples"], key=lambda one: abs(one["t"] - time))
            bodies = sample["bodies"]
            for i in range(1, UNITS + 1):
                for name, colour in ((f"a{i}", COLOURS[0]), (f"b{i}", COLOURS[1])):
                    ends = [locate(bodies[name], [x, 0, 0], tools) for x in (-HALF, HALF)]
                    axes.plot([end[0] for end in ends], [end[1] - 1.9 * row for end in ends], color=colour, linewidth=0.9, solid_capstyle="round")
            root, foot = bodies["bus"]["p"], bodies["foot"]["p"]
            axes.plot([root[0], foot[0]], [root[1] - 1.9 * row, foot[1] - 1.9 * row], color=COLOURS[2], linewidth=1.2)
            axes.annotate(f"{time:g} s", (-0.6, 0.4 - 1.9 * row), ha="right", fontsize=tools.LABEL, color="0.35")
        axes.set_aspect("equal")
        axes.set_xlim(-2, 16)
        axes.set_yticks([])
        axes.set_xlabel("x, m")
        axes.set_title("Twenty units of two bars; red: the cable between the feet", loc="left")
        return drawn

    @figure("mast-lock")
    def lock(bench):
        import matplotlib.pyplot as plt
        drawn, (left, right) = plt.subplots(1, 2, figsize=(7.5, 2.9), constrained_layout=True)
        run = bench.run("mast/scenario.yaml", 8, 0.005)
        times = tools.get_times(run)
        left.plot(times, [s["bodies"]["a20"]["p"][0] - s["bodies"]["bus"]["p"][0] for s in run["samples"]], color=COLOURS[0])
        left.set_ylabel("m")
        left.set_title("From the root to the middle of the last unit", loc="left")
        right.plot(times, [-s["elements"]["winch"]["force"] for s in run["samples"]], color=COLOURS[2])
        right.set_ylabel("N")
        right.set_title("Pull of the cable", loc="left")
        for axes in (left, right):
            axes.set_xlabel("time, s")
        return drawn
