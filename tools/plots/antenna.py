"""Figures of antennas that open: pictures of ribs and of a pantograph ring, angles and shocks of the latches."""
import math

WEAK = {"cables": ((), "#1d3557"), "no cables": (("--set", "constants.cable=1e-6 N/m", "--set", "constants.cable_damping=0"), "#c1121f")}
HALF, POST = 0.8, 1.7  # m, as in ring.yaml
LENGTH = 2.4  # of a rib


def locate(body, point, tools):
    return [a + b for a, b in zip(body["p"], tools.rotate(body["q"], point))]


def view(place, tilt=math.radians(24)):
    """From the side and a little from above."""
    return place[0], math.cos(tilt) * place[2] + math.sin(tilt) * place[1]


def sample_at(run, time):
    return min(run["samples"], key=lambda sample: abs(sample["t"] - time))


def add(figure, tools):
    def draw_line(axes, places, shift, **style):
        shown = [view(place) for place in places]
        axes.plot([x + shift for x, _ in shown], [y for _, y in shown], solid_capstyle="round", **style)

    def draw_ribs(axes, bodies, shift):
        tips = [locate(bodies[f"rib{i}"], [LENGTH / 2, 0, 0], tools) for i in range(1, 13)]
        roots = [locate(bodies[f"rib{i}"], [-LENGTH / 2, 0, 0], tools) for i in range(1, 13)]
        draw_line(axes, [*roots, roots[0]], shift, color="0.35", linewidth=1.2)
        for root, tip in zip(roots, tips):
            draw_line(axes, [root, tip], shift, color="#1d3557", linewidth=1.1)
        for tip, other in zip(tips, tips[1:] + tips[:1]):
            taut = math.dist(tip, other) > 1.35
            draw_line(axes, [tip, other], shift, color="#2a9d8f", linewidth=1 if taut else 0.4, linestyle="-" if taut else ":")

    def draw_ring(axes, bodies, shift):
        for i in range(1, 7):
            post, slider = bodies[f"post{i}"], bodies[f"slider{i}"]
            draw_line(axes, [locate(post, [0, 0, z], tools) for z in (POST / 2, -POST / 2)], shift, color="0.55", linewidth=1)
            for name, colour in ((f"a{i}", "#1d3557"), (f"b{i}", "#2a9d8f")):
                draw_line(axes, [locate(bodies[name], [x, 0, 0], tools) for x in (-HALF, HALF)], shift, color=colour, linewidth=1.1)
            x, y = view(slider["p"])
            axes.plot(x + shift, y, "s", color="#c1121f", markersize=2.6)
        side = locate(bodies["spacecraft"], [-0.5, 0, 0], tools)
        draw_line(axes, [locate(bodies["post1"], [0, 0, 0], tools), side], shift, color="0.35", linewidth=1.2)

    @figure("antenna-opening")
    def opening(bench):
        import matplotlib.pyplot as plt
        drawn, (upper, lower) = plt.subplots(2, 1, figsize=(7.5, 4.4), constrained_layout=True)
        run = bench.run("antenna/scenario.yaml", 3, 0.01)
        for time, shift in ((0, 0), (1.0, 3.5), (1.4, 9.2), (3, 15.2)):
            draw_ribs(upper, sample_at(run, time)["bodies"], shift)
            upper.annotate(f"{time:g} s", (shift, -1.25), ha="center", fontsize=tools.LABEL, color="0.35")
        upper.set_title("Twelve ribs, and the cables between their tips (dotted: slack)", loc="left")
        run = bench.run("antenna/ring.yaml", 3, 0.01)
        for time, shift in ((0, 0), (1.0, 3.2), (1.6, 7), (3, 11.5)):
            draw_ring(lower, sample_at(run, time)["bodies"], shift)
            lower.annotate(f"{time:g} s", (shift, -2.55), ha="center", fontsize=tools.LABEL, color="0.35")
        lower.set_title("Six scissor cells on a boom; red: sliders", loc="left")
        for axes, limits in ((upper, (-1.35, 2.7)), (lower, (-2.65, 1.2))):
            axes.set_ylim(*limits)
            axes.set_aspect("equal")
            axes.set_axis_off()
        return drawn

    @figure("antenna-latches")
    def latches(bench):
        import matplotlib.pyplot as plt
        drawn, (left, right) = plt.subplots(1, 2, figsize=(7.5, 3.2), constrained_layout=True)
        nominal = bench.run("antenna/scenario.yaml", 3, 0.002)
        left.plot(tools.get_times(nominal), [4 + math.degrees(s["sensors"]["angle1"][0]) for s in nominal["samples"]], color="0.6",
                  label="all springs alike", linewidth=2.4)
        right.plot(tools.get_times(nominal), [s["elements"]["latch1"]["moment"] for s in nominal["samples"]], color="0.6", linewidth=2.4)
        for label, (options, colour) in WEAK.items():
            run = bench.run("antenna/weak-spring.yaml", 3, 0.002, *options)
            left.plot(tools.get_times(run), [4 + math.degrees(s["sensors"]["angle1"][0]) for s in run["samples"]], color=colour,
                      label=f"rib 1 weak, {label}", linewidth=1)
            right.plot(tools.get_times(run), [s["elements"]["latch1"]["moment"] for s in run["samples"]], color=colour, linewidth=1)
        left.axhline(75, color="0.5", linewidth=0.8, linestyle="--")
        left.set_xlim(0, 3)
        left.set_xlabel("time, s")
        left.set_ylabel("from the axis, deg")
        left.set_title("Rib 1", loc="left")
        left.legend(loc="lower right")
        right.set_xlim(1.5, 3)
        right.set_xlabel("time, s")
        right.set_ylabel("moment, N m")
        right.set_title("Its latch", loc="left")
        return drawn

    @figure("antenna-ring")
    def ring(bench):
        import matplotlib.pyplot as plt
        drawn, (left, middle, right) = plt.subplots(1, 3, figsize=(7.5, 2.9), constrained_layout=True)
        for name, label, colour, width in (("ring", "rigid locks", "0.6", 2.4), ("ring-elastic", "elastic locks", "#c1121f", 1)):
            run = bench.run(f"antenna/{name}.yaml", 3, 0.002)
            times = tools.get_times(run)
            left.plot(times, [1e3 * s["sensors"]["travel"][0] for s in run["samples"]], color=colour, linewidth=width, label=label)
            middle.plot(times, [math.degrees(s["bodies"]["spacecraft"]["w"][1]) for s in run["samples"]], color=colour, linewidth=width)
            force = [math.hypot(*s["reactions"]["boom"]["lambda"][:3]) for s in run["samples"]]
            right.plot(times, force, color=colour, linewidth=width)
        left.set_ylabel("travel, mm")
        left.set_title("Sliders", loc="left")
        left.legend(loc="upper left")
        middle.set_ylabel("pitch rate, deg/s")
        middle.set_title("Spacecraft", loc="left")
        right.set_ylabel("force, N")
        right.set_title("Boom", loc="left")
        for axes in (left, middle, right):
            axes.set_xlabel("time, s")
            axes.set_xlim(0 if axes is not right else 2, 3)
        return drawn
