"""Figure of the launcher: its climb, what it meets on the way, its attitude beside the program."""
import math

PROGRAM = ((0, 84), (20, 76), (45, 60), (70, 47), (110, 33), (180, 20), (240, 12))  # s, deg: the knots of the scenario's table


def add(figure, tools):
    @figure("launcher-ascent")
    def ascent(bench):
        import matplotlib.pyplot as plt
        run = bench.run("launcher/scenario.yaml", 220, 0.5)
        times, found = tools.get_times(run), [sample["quantities"] for sample in run["samples"]]
        burnout = next(event["t"] for event in run["events"] if event["name"] == "burnout")
        drawn, (left, middle, right) = plt.subplots(1, 3, figsize=(7.5, 2.8), constrained_layout=True)
        left.plot(times, [q["altitude"] / 1e3 for q in found], color="#1d3557", label="altitude, km")
        left.plot(times, [math.hypot(q["north"], q["east"], q["down"]) / 20 for q in found], color="#e09f3e", label="speed, 20 m/s")
        left.legend(loc="upper left")
        left.set_title("Climb", loc="left")
        middle.plot(times, [q["pressure"] / 1e3 for q in found], color="#c1121f", label="dynamic pressure, kPa")
        middle.plot(times, [q["mach"] for q in found], color="#457b9d", label="Mach number")
        middle.legend(loc="upper right")
        middle.set_ylim(0, 42)
        middle.set_title("Air", loc="left")
        right.plot(times, [math.degrees(q["pitch"]) for q in found], color="#1d3557", label="pitch")
        right.plot([t for t, _ in PROGRAM[:-1]], [a for _, a in PROGRAM[:-1]], "o", color="#c1121f", markersize=3, label="its program")
        right.plot(times, [math.degrees(10 * q["alpha"]) for q in found], color="#e09f3e", label="10 x angle of attack")
        right.legend(loc="upper right")
        right.set_title("Attitude, deg", loc="left")
        for axes in (left, middle, right):
            axes.axvline(burnout, color="0.75", linewidth=0.7, zorder=0)
            axes.set_xlabel("time, s; line: staging")
        return drawn
