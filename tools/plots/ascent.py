"""Figures of the strap-on separation in air, beside the same in vacuum."""
import math

CASES = (("reference", "vacuum", "#1d3557"), ("ascent", "Mach 5 at 45 km", "#c1121f"))


def add(figure, tools):
    @figure("boosters-ascent")
    def ascent(bench):
        import matplotlib.pyplot as plt
        drawn, (left, middle, right) = plt.subplots(1, 3, figsize=(7.5, 2.8), constrained_layout=True)
        for name, label, colour in CASES:
            run = bench.run(f"boosters/{name}.yaml", 2, 0.01)
            times = tools.get_times(run)
            bodies = [sample["bodies"] for sample in run["samples"]]
            left.plot([b["booster1"]["p"][0] - b["core"]["p"][0] for b in bodies], [b["booster1"]["p"][1] - b["core"]["p"][1] for b in bodies],
                      color=colour, label=label)
            middle.plot(times, [math.degrees(2 * math.atan2(b["booster1"]["q"][3], b["booster1"]["q"][0])) for b in bodies], color=colour)
            right.plot(times, [b["booster1"]["p"][1] - b["core"]["p"][1] + 13.2 * math.sin(2 * math.atan2(b["booster1"]["q"][3], b["booster1"]["q"][0]))
                               for b in bodies], color=colour)
        left.set_title("Centre of booster 1", loc="left")
        left.set_xlabel("along the core, m")
        left.set_ylabel("from its axis, m")
        left.legend(loc="lower left")
        middle.set_title("Lean of booster 1", loc="left")
        middle.set_ylabel("deg, outwards")
        right.set_title("Nose of booster 1", loc="left")
        right.set_ylabel("from the core's axis, m")
        for axes in (middle, right):
            axes.set_xlabel("time, s")
        return drawn
