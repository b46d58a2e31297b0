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
        drawn, plot = plt.subplots(figsize=(7.5, 3.8), layout="constrained")
        plot.set_aspect("equal")
        plot.axis("off")
        body = [(-2.4, -0.5), (1.4, -0.5), (2.4, 0), (1.4, 0.5), (-2.4, 0.5)]
        plot.fill(*zip(*body), facecolor="0.93", edgecolor="0.4")

        def arrow(start, end, text, color, place):
            plot.annotate("", end, start, arrowprops={"arrowstyle": "-|>", "color": color, "linewidth": 1.6, "shrinkA": 0, "shrinkB": 0})
            plot.annotate(text, end, place, textcoords="offset points", color=color, fontsize=tools.LABEL + 1, ha="center", va="center")

        arrow((0, 0), (3.9, 0), "x  forwards   u, cx; p, cl about it", "C0", (82, 0))
        arrow((0, 0), (-1.15, -1.0), "y  to the right   v, cy; q, cm about it", "C0", (-40, -10))
        arrow((0, 0), (0, -2.0), "z  down   w, cz; r, cn about it", "C0", (0, -11))
        for turn, (x, y), start in ((0, (3.0, 0), 35), (1, (-0.78, -0.68), 160), (2, (0, -1.5), 10)):
            wide, high = ((0.13, 0.36), (0.36, 0.3), (0.42, 0.13))[turn]
            angles = [math.radians(start + 5 * k) for k in range(54)]
            path = [(x + wide * math.cos(a), y + high * math.sin(a)) for a in angles]
            plot.plot(*zip(*path), color="C2", linewidth=1.2)
            plot.annotate("", path[-1], path[-4], arrowprops={"arrowstyle": "-|>", "color": "C2", "linewidth": 1.2})
        angle = math.radians(24)
        tip = (2.4 * math.cos(angle) * 1.15, -2.4 * math.sin(angle) * 1.15)
        arrow((0, 0), tip, "velocity through the air, V", "C3", (62, -6))
        arc = [math.radians(-24 * k / 20) for k in range(21)]
        plot.plot([1.7 * math.cos(a) for a in arc], [1.7 * math.sin(a) for a in arc], "C3", linewidth=1)
        plot.text(1.82, -0.36, "α > 0", color="C3", fontsize=tools.LABEL + 1)
        arrow((0, 0), (-2.9 * math.cos(angle), 2.9 * math.sin(angle)), "drag > 0", "C1", (-6, 9))
        plot.plot(0, 0, "ko", markersize=4)
        plot.annotate("reference point", (0, 0), (6, 12), textcoords="offset points", fontsize=tools.LABEL)
        plot.text(-3.9, -2.35, "seen from the right side; y points out of the page. Moments and rates are positive by the right hand: "
                  "cl > 0 right side down, cm > 0 nose up, cn > 0 nose right.", fontsize=tools.LABEL)
        plot.set(xlim=(-4.2, 7.2), ylim=(-2.5, 1.5))
        return drawn
