"""Figures of propellant slosh: both liquids after a pulse, with smooth walls and with baffles."""
import math

COLOURS = ("#1d3557", "#c1121f")


def get_angle(body):
    return 2 * math.atan2(body["q"][3], body["q"][0])


def add(figure, tools):
    @figure("slosh")
    def slosh(bench):
        import matplotlib.pyplot as plt
        drawn, (left, middle, right) = plt.subplots(1, 3, figsize=(7.5, 2.7), constrained_layout=True)
        for zeta, colour, label in (("0.5 %", COLOURS[0], "smooth walls, 0.5 %"), ("5 %", COLOURS[1], "baffles, 5 %")):
            run = bench.run("slosh/scenario.yaml", 10, 0.02, "--set", f"constants.zeta={zeta}")
            times = tools.get_times(run)
            bodies = [sample["bodies"] for sample in run["samples"]]
            left.plot(times, [math.degrees(get_angle(b["slosh1"]) - get_angle(b["stage"])) for b in bodies], color=colour, label=label)
            middle.plot(times, [1e3 * (math.cos(get_angle(b["stage"])) * (b["slosh2"]["p"][1] - b["stage"]["p"][1])
                                       - math.sin(get_angle(b["stage"])) * (b["slosh2"]["p"][0] - b["stage"]["p"][0])) for b in bodies], color=colour)
            right.plot(times, [math.degrees(b["stage"]["w"][2]) for b in bodies], color=colour)
        left.set_title("Oxidizer: angle of the pendulum", loc="left")
        left.set_ylabel("deg")
        left.set_ylim(top=4)
        left.legend(loc="upper right")
        middle.set_title("Fuel: path of the mass", loc="left")
        middle.set_ylabel("mm")
        right.set_title("Rate of the stage", loc="left")
        right.set_ylabel("deg/s")
        for axes in (left, middle, right):
            axes.set_xlabel("time, s")
            axes.set_xlim(0, 10)
        return drawn
