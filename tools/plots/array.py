"""Figures of the solar array: hinge angles, what hinges bear around the latches, the shock's spectrum, residual rates."""
import math

from plots import campaign

# Of synthesis.yaml: the array as it is, and the optimum.
DESIGNS = {
    "before: springs of 0.6 N m,\ncables of 150 N m/rad": {},
    "optimum: springs of 1.48, 1.17, 0.50, 0.50 N m,\ncables of 0.92 N m/rad": {
        "root": "1.480771 N m", "second": "1.166904 N m", "outer": "0.497968 N m", "cable": "0.921203 N m/rad"},
}

RATIOS = {
    "equal pulleys: springs of 1.48, 1.17, 0.50,\n0.50 N m, cables of 0.92 N m/rad": {
        "root": "1.480771 N m", "second": "1.166904 N m", "outer": "0.497968 N m", "cable": "0.921203 N m/rad"},
    "ratios 0.30, 0.76, 0.87: springs of 1.39, 0.98,\n0.76, 0.76 N m, cables of 0.59, 0.80, 0.80 N m/rad": {
        "root": "1.3880887 N m", "second": "0.9800083 N m", "outer": "0.7564906 N m", "cable": "0.8023623 N m/rad", "ratio2": "0.7588480",
        "ratio3": "0.8725585", "bus_cable": "0.5920414 N m/rad", "ratio1": "0.3"},
}

COLOURS = ("#c1121f", "#457b9d", "#e09f3e", "#2a9d5c", "#6a4c93", "#555555", "#b5838d", "#1d3557")


def calc_angles(run, panels):
    """Of each hinge over time, rad: panels turn about z alone."""
    angles = [[] for _ in range(panels)]
    for sample in run["samples"]:
        turns = [2 * math.atan2(body["q"][3], body["q"][0]) for body in sample["bodies"].values()]
        for k in range(panels):
            angles[k].append(math.remainder(turns[k + 1] - turns[k], 2 * math.pi))
    return angles


def add(figure, tools):
    @figure("array-angles")
    def angles(bench):
        import matplotlib.pyplot as plt
        drawn, columns = plt.subplots(3, 1, figsize=(7.5, 7), sharex=True, sharey=True, constrained_layout=True)
        for axes, file, title in zip(columns, ("scenario", "elastic", "elastic-cables"),
                                     ("cables, rigid latches", "no cables, elastic latches", "elastic cables and latches")):
            run = bench.run(f"array/{file}.yaml", 10, 0.01)
            for k, values in enumerate(calc_angles(run, 4)):
                axes.plot(tools.get_times(run), [math.degrees(v) for v in values], color=COLOURS[k],
                          label=f"hinge {k + 1}", **tools.layer(k))
            axes.set_xlim(0, 10)
            tools.mark_events(axes, run, ("latch",), labels=False)
            axes.set_title(f"{title}; a line at each latch", loc="left")
            axes.set_ylabel("hinge angle, deg")
        columns[-1].set_xlabel("t, s")
        columns[0].legend()
        return drawn

    @figure("array-reference")
    def reference(bench):
        import matplotlib.pyplot as plt
        run = bench.run("array/reference.yaml", 20, 0.01)
        times = tools.get_times(run)
        drawn, rows = plt.subplots(2, 1, figsize=(7.5, 4.6), sharex=True, constrained_layout=True)
        for k in (1, 2):
            force = [math.hypot(*(v for v in sample["reactions"][f"hinge{k}"]["lambda"][:3])) for sample in run["samples"]]
            rows[0].plot(times, force, color=COLOURS[k - 1], label=f"hinge {k}")
        for name, colour in (("bus", "0.3"), ("panel1", COLOURS[0]), ("panel2", COLOURS[1])):
            rows[1].plot(times, [math.degrees(sample["bodies"][name]["w"][2]) for sample in run["samples"]], color=colour,
                         label=name, linewidth=0.9)
        rows[0].set_xlim(0, 20)
        for axes in rows:
            tools.mark_events(axes, run, ("latch1", "latch2"), labels=axes is rows[0])
            axes.legend()
        rows[0].set_ylabel("force in the hinge, N")
        rows[1].set_ylabel("rate about z, deg/s")
        rows[1].set_xlabel("t, s")
        drawn.suptitle("Two panels with elastic latches, the reference case", fontsize=10)
        return drawn

    @figure("array-latch-shock")
    def shock(bench):
        import numpy
        import matplotlib.pyplot as plt
        every = 0.005
        run = bench.run("array/elastic.yaml", 20, every)
        times = numpy.array(tools.get_times(run))
        last = max(event["t"] for event in run["events"])
        drawn, (left, right) = plt.subplots(2, 1, figsize=(7.5, 5.6), constrained_layout=True)
        for k in range(1, 5):
            force = numpy.array(tools.get_row(run, f"hinge{k}", "y"))
            left.plot(times, force, color=COLOURS[k - 1], linewidth=0.7, label=f"hinge {k}")
            after = force[times >= last] * numpy.hanning((times >= last).sum())
            spectrum = 4 * numpy.abs(numpy.fft.rfft(after)) / len(after)  # amplitudes; a Hann window halves them
            right.semilogy(numpy.fft.rfftfreq(len(after), every), spectrum, color=COLOURS[k - 1], linewidth=0.9)
        left.set_xlim(3, 12)
        tools.mark_events(left, run, ("latch",), labels=False)
        left.set_title("Shear in the hinges of four panels with elastic latches; a line at each latch", loc="left")
        left.set_xlabel("t, s")
        left.set_ylabel("N")
        left.legend()
        right.set_xlim(0, 8)
        right.set_ylim(1e-4, None)
        right.set_title("Amplitudes after the last latch", loc="left")
        right.set_xlabel("Hz")
        right.set_ylabel("N")
        return drawn

    @figure("array-panels")
    def panels(bench):
        import matplotlib.pyplot as plt
        drawn, (left, right) = plt.subplots(2, 1, figsize=(7.5, 5.6), constrained_layout=True)
        counts, last, losses, peaks = (2, 4, 8, 16), [], [], []
        for n in counts:
            until = 4 * n + 20
            run = bench.run(bench.array(n, "--until", str(until)), until, 0.1)
            last.append(max(event["t"] for event in run["events"] if event["name"] == "latch"))
            losses.append(-sum(audit["energy_jump"] for audit in run["audit"]))
            rates = [math.degrees(sample["bodies"]["bus"]["w"][2]) for sample in run["samples"]]
            peaks.append(max(map(abs, rates)))
            left.plot(tools.get_times(run), rates, color=COLOURS[counts.index(n)], label=f"{n} panels")
        left.set_title("Rate of the bus while panels with cables unfold; rigid latches", loc="left")
        left.set_xlabel("t, s")
        left.set_ylabel("deg/s")
        left.set_xlim(0, 30)
        left.legend()
        right.plot(counts, last, "o-", color=COLOURS[0], label="last latch, s")
        right.plot(counts, losses, "s--", color=COLOURS[1], label="energy lost in latches, J")
        right.plot(counts, peaks, "^:", color=COLOURS[3], label="largest rate of the bus, deg/s")
        right.set_xscale("log", base=2)
        right.set_xticks(counts, counts)
        right.set_xlabel("panels")
        right.legend()
        return drawn

    @figure("array-campaign")
    def dispersion(bench):
        return campaign.draw(bench, tools, "array/campaign.yaml", ["hinge"], "greatest force in the bus' hinge", "N", rows=2)

    @figure("array-optimize")
    def optimum(bench):
        return draw_designs(bench, "array/design.yaml", DESIGNS)

    @figure("array-ratios")
    def ratios(bench):
        return draw_designs(bench, "array/ratios.yaml", RATIOS)

    def draw_designs(bench, scenario, designs):
        import matplotlib.pyplot as plt
        drawn, rows = plt.subplots(2, 2, figsize=(7.5, 5.2), sharex=True, sharey="row", constrained_layout=True)
        hinges = range(1, 5)
        selected = [f"joint.hinge{k}.angle" for k in hinges] + [f"element.latch{k}.moment" for k in hinges]
        for column, (title, values) in enumerate(designs.items()):
            options = [text for name, value in values.items() for text in ("--set", f"constants.{name}={value}")]
            run = bench.call("run", tools.SCENARIOS / scenario, "--outputs", ",".join(selected), "--json", "-", *options)
            table, (angles, moments) = run["outputs"][0], rows[:, column]
            columns = list(zip(*table["rows"]))  # x, y, z of each angle, then the moments
            latched = {event["subject"]: event["t"] for event in run["events"] if event["name"] == "latch"}
            for k in hinges:
                angles.plot(table["t"], [math.degrees(v) for v in columns[3 * k - 1]], color=COLOURS[k - 1],
                            label=f"hinge {k}", **tools.layer(k - 1))
                moments.plot(table["t"], [v if t >= latched[f"panel{k}"] else math.nan
                                          for t, v in zip(table["t"], columns[11 + k])],
                             color=COLOURS[k - 1], linewidth=0.8)
            for limit in (-75, 75):
                moments.axhline(limit, color="0.3", linewidth=0.8, linestyle="--")
            for axes in (angles, moments):
                axes.set_xlim(3, 9)
                tools.mark_events(axes, run, ("latch",), labels=False)
            angles.set_title(title, loc="left", fontsize=tools.LABEL + 1)
            moments.set_xlabel("t, s")
        rows[0][0].set_ylabel("hinge angle, deg")
        rows[1][0].set_ylabel("moment of the latch, N m")
        rows[1][0].set_ylim(-100, 100)
        rows[0][0].legend(loc="lower right", ncols=2)
        drawn.suptitle("Four panels unfold: a line at each latch, dashed the shock that a latch may bear", fontsize=10)
        return drawn
