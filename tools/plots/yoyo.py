"""Figures of a yo-yo despin: the cords as they unwind, the spin and the pull over time."""
import math

RADIUS, BALL, FIRE, WOUND = 0.4, 0.03, 0.2, 3.1921 / 0.4
COLOURS = ("#1d3557", "#c1121f")


def add(figure, tools):
    def draw_cord(axes, sample, number, colour):
        """Arc and tangent, seen along the spin from a frame that does not turn."""
        satellite, tip = sample["bodies"]["satellite"], sample["bodies"][f"tip{number}"]
        x, y = (tip["p"][k] - satellite["p"][k] for k in (0, 1))
        leaves = math.atan2(y, x) + math.acos(min(1, RADIUS / math.hypot(x, y)))
        wound = sample["elements"][f"cord{number}"]["wound"]
        angles = [leaves + wound * i / 200 for i in range(200, -1, -1)]  # wound against the spin: the anchor is ahead
        axes.plot([RADIUS * math.cos(a) for a in angles] + [x], [RADIUS * math.sin(a) for a in angles] + [y], color=colour, linewidth=1.1)
        axes.plot(x, y, "o", color=colour, markersize=4)
        axes.plot(RADIUS * math.cos(angles[0]), RADIUS * math.sin(angles[0]), "s", color=colour, markersize=3)

    @figure("yoyo-unwinding")
    def unwinding(bench):
        import matplotlib.patches as patches
        import matplotlib.pyplot as plt
        drawn, columns = plt.subplots(1, 3, figsize=(7.5, 2.9), constrained_layout=True, sharey=True)
        run = bench.run("yoyo/scenario.yaml", 0.9, 0.001)
        for axes, time in zip(columns, (0.2, 0.45, 0.845)):
            sample = min(run["samples"], key=lambda s: abs(s["t"] - time))
            axes.add_patch(patches.Circle((0, 0), RADIUS, facecolor="0.93", edgecolor="0.6", linewidth=0.8))
            for number, colour in ((1, COLOURS[0]), (2, COLOURS[1])):
                draw_cord(axes, sample, number, colour)
            rate = sample["bodies"]["satellite"]["w"][2] * 30 / math.pi
            axes.set_title(f"{time - FIRE:.3f} s after the release: {rate:.0f} rpm", loc="left", fontsize=tools.LABEL)
            axes.set_aspect("equal")
            axes.set_xlim(-3.5, 3.5)
            axes.set_ylim(-3.5, 3.5)
            axes.set_xlabel("x, m")
        columns[0].set_ylabel("y, m")
        return drawn

    @figure("yoyo-despin")
    def despin(bench):
        import matplotlib.pyplot as plt
        drawn, (left, middle, right) = plt.subplots(1, 3, figsize=(7.5, 3.0), constrained_layout=True)
        runs = {name: bench.run(f"yoyo/{name}.yaml", 1.1, 0.001) for name in ("scenario", "late")}
        labels = {"scenario": "both at once", "late": "one 60 ms late"}
        for (name, run), colour in zip(runs.items(), COLOURS):
            times = [t - FIRE for t in tools.get_times(run)]
            left.plot(times, [s["bodies"]["satellite"]["w"][2] * 30 / math.pi for s in run["samples"]], color=colour, label=labels[name])
            across = [math.hypot(*s["bodies"]["satellite"]["w"][:2]) * 30 / math.pi for s in run["samples"]]
            right.plot(times, across, color=colour, label=labels[name])
        c, spin = 1 + 16 / (1.6 * RADIUS**2), 4 * math.pi
        angles = [spin * 0.02 * i for i in range(33)]
        left.plot([a / spin for a in angles if a < WOUND], [120 * (c - a * a) / (c + a * a) for a in angles if a < WOUND], ".", color="0.55", markersize=3,
                  label="closed form, masses\non the surface")
        left.set_ylabel("spin, rpm")
        left.set_title("Spin", loc="left")
        left.legend(loc="lower left", bbox_to_anchor=(0, 0.05))
        run, times = runs["late"], [t - FIRE for t in tools.get_times(runs["late"])]
        for number, colour, label in ((1, "#2a9d8f", "first"), (2, "#e9a23b", "late")):
            middle.plot(times, [-s["elements"][f"cord{number}"]["force"] for s in run["samples"]], color=colour, linewidth=0.9, label=label)
        middle.plot([t - FIRE for t in tools.get_times(runs["scenario"])], [-s["elements"]["cord1"]["force"] for s in runs["scenario"]["samples"]],
                    color=COLOURS[0], linewidth=0.9, label="both at once")
        middle.set_ylabel("N")
        middle.set_title("Pull of a cord", loc="left")
        middle.set_ylim(top=780)
        middle.legend(loc="upper left")
        right.set_ylabel("rpm")
        right.set_title("Rate across the spin", loc="left")
        right.set_ylim(top=2.5)
        right.legend(loc="upper left")
        for axes in (left, middle, right):
            axes.set_xlim(-0.05, 0.85)
            axes.set_xlabel("time from the release, s")
        return drawn
