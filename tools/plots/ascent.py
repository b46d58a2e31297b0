"""Figures of the strap-on separation in air, beside the same without it."""
import math

from plots import campaign

CASES = (("ascent-vacuum", (), "without air", "#1d3557"), ("ascent", (), "Mach 5 at 45 km", "#c1121f"),
         ("ascent", ("--set", "tables.push.scale=0"), "without the core's shock", "#f4a261"))


def add(figure, tools):
    @figure("boosters-ascent")
    def ascent(bench):
        import matplotlib.pyplot as plt
        drawn, (left, middle, right) = plt.subplots(1, 3, figsize=(7.5, 2.8), constrained_layout=True)
        for name, options, label, colour in CASES:
            run = bench.run(f"boosters/{name}.yaml", 2, 0.01, *options)
            times = tools.get_times(run)
            pairs = [(sample["bodies"]["core"], sample["bodies"]["booster1"]) for sample in run["samples"]]
            centres = [tools.seen_from(core, booster, [0, 0, 0]) for core, booster in pairs]
            noses = [tools.seen_from(core, booster, [13.2, 0, 0]) for core, booster in pairs]
            left.plot([c[0] for c in centres], [c[1] for c in centres], color=colour, label=label)
            middle.plot(times, [math.degrees(math.asin((n[1] - c[1]) / 13.2)) for n, c in zip(noses, centres)], color=colour)
            right.plot(times, [n[1] for n in noses], color=colour)
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

    @figure("boosters-air")
    def air(bench):
        return campaign.draw(bench, tools, "boosters/campaign-air.yaml", ["away1", "away2", "away3", "away4"], "centre from the core's axis at 2 s", "m",
                             labels=("booster 1, above", "booster 2", "booster 3, below", "booster 4"), colours=("#1d3557", "#457b9d", "#e09f3e", "#9b5de5"), rows=16)
