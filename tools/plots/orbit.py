"""Figures of the orbit scenario, and of the signs of aerodynamic coefficients."""
import math


def add(figure, tools):
    @figure("orbit-relative")
    def relative(bench):
        import matplotlib.pyplot as plt
        until, every = 5440, 10
        run = bench.run("orbit/scenario.yaml", until, every, "--set", "environment.planet.j2=0")
        with_j2 = bench.run("orbit/scenario.yaml", until, every)
        drag = bench.run("orbit/drag.yaml", until, every)
        drawn, (left, right) = plt.subplots(1, 2, figsize=(7.5, 3.6), layout="constrained")
        for found, label, k in ((run, "central field", 0), (with_j2, "with J2", 1), (drag, "with J2, drag of the stage", 2)):
            values = [sample["quantities"] for sample in found["samples"]]
            left.plot([v["along"] / 1000 for v in values], [v["radial"] / 1000 for v in values], label=label, **tools.layer(k, 3))
        times, values = tools.get_times(run), [sample["quantities"] for sample in run["samples"]]
        first = next(i for i, t in enumerate(times) if t >= 10)
        start, t0 = values[first], times[first]
        n = math.sqrt(3.986004418e14 / 6678137.0**3)
        for key, style in (("radial", "C0"), ("along", "C1")):
            errors = []
            for t, v in zip(times[first:], values[first:]):
                x0, y0, u0, w0 = start["radial"], start["along"], start["radial_speed"], start["along_speed"]
                s, c, a = math.sin(n * (t - t0)), math.cos(n * (t - t0)), n * (t - t0)
                model = {"radial": (4 - 3 * c) * x0 + s / n * u0 + 2 / n * (1 - c) * w0,
                         "along": 6 * (s - a) * x0 + y0 - 2 / n * (1 - c) * u0 + (4 * s - 3 * a) / n * w0}
                errors.append(v[key] - model[key])
            right.plot([t / 60 for t in times[first:]], errors, style, label=key)
        left.plot(0, 0, "k+")
        left.annotate("stage", (0, 0), (4, 4), textcoords="offset points", fontsize=tools.LABEL)
        left.set(xlabel="along the orbit, km", ylabel="radially, km", title="The satellite, seen from the stage")
        left.legend()
        right.set(xlabel="time, min", ylabel="m", title="Less Clohessy–Wiltshire, central field")
        right.legend()
        return drawn

    @figure("aerodynamics-axes")
    def axes(_):
        import matplotlib.pyplot as plt
        drawn = plt.figure(figsize=(7.5, 3.5))
        plot = drawn.add_axes((0, 0, 1, 1))
        plot.axis("off")
        plot.set(xlim=(-4.6, 6.1), ylim=(-3.05, 1.95))
        plot.set_aspect("equal")
        plot.fill(*zip((-3, -0.55), (1.6, -0.55), (2.8, 0), (1.6, 0.55), (-3, 0.55)), facecolor="0.94", edgecolor="0.5", linewidth=0.8)

        def arrow(end, color, text, place, align):
            plot.annotate("", end, (0, 0), arrowprops={"arrowstyle": "-|>", "color": color, "linewidth": 1.6, "shrinkA": 0, "shrinkB": 0})
            plot.text(*place, text, color=color, fontsize=tools.LABEL + 1, ha=align, va="center")

        arrow((3.9, 0), "C0", "x forwards\nu, cx; p and cl about it", (4.05, 0.05), "left")
        arrow((-1.5, -1.2), "C0", "y to the right (towards you)\nv, cy; q and cm about it", (-1.65, -1.45), "right")
        arrow((0, -2.1), "C0", "z down\nw, cz; r and cn about it", (0, -2.5), "center")
        for (x, y), (wide, high), first, sense in (((3.3, 0), (0.13, 0.36), 200, 5), ((-1.1, -0.88), (0.26, 0.34), 120, 5), ((0, -1.7), (0.42, 0.13), -10, -5)):
            path = [(x + wide * math.cos(math.radians(first + sense * k)), y + high * math.sin(math.radians(first + sense * k))) for k in range(54)]
            plot.plot(*zip(*path), color="C2", linewidth=1.1)
            plot.annotate("", path[-1], path[-5], arrowprops={"arrowstyle": "-|>", "color": "C2", "linewidth": 1.1, "shrinkA": 0, "shrinkB": 0})
        angle = math.radians(22)
        arrow((3.3 * math.cos(angle), -3.3 * math.sin(angle)), "C3", "V: velocity through the air", (3.2, -1.35), "left")
        arrow((-3.4 * math.cos(angle), 3.4 * math.sin(angle)), "C1", "drag", (-3.3, 1.45), "center")
        arc = [angle * k / 20 for k in range(21)]
        plot.plot([2.2 * math.cos(a) for a in arc], [-2.2 * math.sin(a) for a in arc], "C3", linewidth=1)
        plot.text(2.35, -0.42, "α", color="C3", fontsize=tools.LABEL + 3, ha="left", va="center")
        plot.plot(0, 0, "ko", markersize=4)
        plot.text(0.1, 0.28, "reference point", fontsize=tools.LABEL, ha="left", va="center")
        plot.text(-4.5, 1.78, "Everything is positive as drawn. Moments and rates follow the right hand: "
                  "cl right side down, cm nose up, cn nose to the right.", fontsize=tools.LABEL, va="center")
        return drawn
