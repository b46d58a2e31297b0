"""Figures of the sensors scenario: true and received values, the observer's error, Allan deviations of the three grades of gyros."""
import importlib.util
import math

GRADES = {"navigation": (0.002, 0.0005, 0.005, 1000), "tactical": (0.05, 0.1, 1, 300), "mems": (0.2, 2, 5, 100)}  # deg/√h, deg/h/√h, deg/h, s
COLOURS = ("#1d3557", "#2a9d8f", "#c1121f")
PERIOD, SAMPLES = 0.1, 100000


def load_judge(tools):
    spec = importlib.util.spec_from_file_location("judge", tools.SCENARIOS / "sensors/judge.py")
    judge = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(judge)
    return judge


def write_grades(tools, folder):
    """A scenario with the three gyros at rest."""
    (folder / "parts").mkdir(exist_ok=True)
    (folder / "parts/sensors.yaml").write_text((tools.SCENARIOS / "sensors/parts/sensors.yaml").read_text(encoding="utf-8"), encoding="utf-8")
    path = folder / "grades.yaml"
    gyros = "".join(f"  - {{template: gyro_{grade}, for: [{{i: _{grade}, body: craft, turn_on: 0}}]}}\n" for grade in GRADES)
    names = ", ".join(f"gyro_{grade}" for grade in GRADES)
    path.write_text(f"unlatch: 1\ninclude: parts/sensors.yaml\nname: grades\nstep: {{dt: {PERIOD}, until: {SAMPLES * PERIOD}}}\n"
                    f"bodies: {{craft: {{mass: 1, inertia: [1, 1, 1]}}}}\ninstances:\n{gyros}timing: {{groups: {{all: {{every: 1, sensors: [{names}]}}}}}}\n",
                    encoding="utf-8")
    return path


def draw_allan(axes, judge, rows):
    hour = 3600
    sizes = [1, 3, 10, 30, 100, 300, 1000, 3000, 10000]
    taus = [PERIOD * 10 ** (k / 20) for k in range(81)]
    for (grade, (arw, rrw, drift, correlation)), colour in zip(GRADES.items(), COLOURS):
        def expect(tau, arw=arw, rrw=rrw, drift=drift, correlation=correlation):
            r = tau / correlation
            markov = 2 * drift**2 / r * (1 - (3 - 4 * math.exp(-r) + math.exp(-2 * r)) / (2 * r))
            return math.sqrt((60 * arw) ** 2 / tau + (rrw / 60) ** 2 * tau / 3 + markov)
        values = [[math.degrees(row[f"received.gyro_{grade}.{axis}"]) * hour for row in rows] for axis in "xyz"]
        found = [math.sqrt(sum(judge.calc_allan(v, m) ** 2 for v in values) / 3) for m in sizes]
        axes.loglog(taus, [expect(tau) for tau in taus], color=colour, linewidth=1)
        axes.loglog([m * PERIOD for m in sizes], found, "o", color=colour, markersize=3.5, label=f"gyro_{grade}")
    axes.set(xlabel="averaging time, s", ylabel="deg/h", xlim=(PERIOD, 1000), title="Allan deviation; lines: data sheet")
    axes.legend(loc="upper right")


def add(figure, tools):
    @figure("sensors")
    def sensors(bench):
        import matplotlib.pyplot as plt
        judge = load_judge(tools)
        rows, result = judge.fly(bench.program, bench.folder / "sensors.log", outputs=judge.OUTPUTS + ",*.switch1,body.satellite.attitude")
        happened = {event["name"]: event["t"] for event in result["events"]}
        for row in rows:
            row.update({f"true.{key}": row[f"satellite.q{key}"] for key in "wxyz"})
        times = [row["t"] for row in rows]
        drawn, ((push, signals), (attitude, allan)) = plt.subplots(2, 2, figsize=(7.5, 5.4), layout="constrained")

        push.plot(times, [row["received.gyro1.z"] * 180 / math.pi for row in rows], color=COLOURS[2], linewidth=0.7, label="received")
        push.plot(times, [row["sensor.gyro1.z"] * 180 / math.pi for row in rows], color=COLOURS[0], label="true")
        push.set(xlim=(9, 16), ylim=(-0.05, 0.5), xlabel="time, s", ylabel="deg/s", title="Rate about z, gyro_tactical")
        push.legend(loc="lower right")

        for k, (name, label) in enumerate((("wire1", "break-wire"), ("switch1", "switch"))):
            for kind, colour, style in (("sensor", COLOURS[0], "-"), ("received", COLOURS[2], "--")):
                signals.plot([1e3 * (t - happened["release"]) for t in times], [row[f"{kind}.{name}"] * 0.8 + 1.2 * k for row in rows], style, color=colour,
                             drawstyle="steps-post", label={"sensor": "true", "received": "received"}[kind] if k == 0 else None)
            signals.text(5, 1.2 * k + 0.1, label, fontsize=tools.LABEL)
        signals.set(xlim=(0, 220), ylim=(-0.1, 2.6), yticks=[0, 0.8, 1.2, 2.0], yticklabels=["0", "1", "0", "1"], xlabel="time after the release, ms",
                    title="Signals, sampled each 10 ms")
        signals.legend(loc="upper left", ncols=2)

        late = round(judge.LATENCY / (times[1] - times[0]))
        fixes = [(rows[k - late]["t"], math.hypot(*judge.between(judge.read(rows[k], "received.star_tracker1"), judge.read(rows[k - late], "true"))))
                 for k in range(late, len(rows), late)]
        attitude.semilogy([t for t, _ in fixes], [math.degrees(e) for _, e in fixes], ".", color="0.6", markersize=3, label="star tracker, at the time of its image")
        observed = judge.observe(rows, happened["release"])
        attitude.semilogy([t for t, e in observed if e > 0], [math.degrees(e) for _, e in observed if e > 0], color=COLOURS[2], label="observer")
        attitude.axvline(happened["release"], color="0.75", linewidth=0.7)
        attitude.annotate("release: the gyro alone", (happened["release"], 1), (3, -3), xycoords=("data", "axes fraction"), textcoords="offset points",
                          fontsize=tools.LABEL, color="0.35", va="top")
        lost = [(t, e) for t, e in fixes if e > math.radians(1)]
        if lost:
            attitude.annotate("lost samples: the last one is held", (lost[-1][0], math.degrees(lost[-1][1])), (-6, -10), textcoords="offset points",
                              fontsize=tools.LABEL, color="0.35", ha="right", va="top")
        attitude.set(xlim=(0, 30), ylim=(5e-4, 30), xlabel="time, s", ylabel="deg", title="Error of the attitude")
        attitude.legend(loc="center right", bbox_to_anchor=(1, 0.58))

        grades, _ = judge.fly(bench.program, bench.folder / "grades.log", scenario=write_grades(tools, bench.folder), outputs="received.*", every=1)
        draw_allan(allan, judge, grades)
        return drawn
