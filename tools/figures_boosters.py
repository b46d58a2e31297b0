"""Figures of the strap-on boosters: who is where, how they turn, what the nodes bear, how close they come."""
import math

COLOURS = ("#c1121f", "#457b9d", "#e09f3e", "#2a9d5c")
CASES = (("cyclogram.yaml", (), "nominal"), ("late-valve.yaml", (), "valve 1 late"),
         ("cyclogram.yaml", ("--set", "events.nozzle:booster1.enabled=false"), "nozzle 1 dead"),
         ("uncut-tie.yaml", (), "ties 2 hold"), ("imbalance.yaml", (), "engines unequal"))
UNTIL, EVERY = 2.5, 0.005


def run_case(bench, case):
    file, options, _ = case
    return bench.run(f"boosters/{file}", UNTIL, EVERY, *options)


# Of synthesis.yaml: where it starts, and its optimum.
DESIGNS = {
    "start: 9 kN, 12 ms, 5 mm, spread 5 %": {"thrust": "9 kN", "delay": "12 ms", "stroke": "5 mm", "spread": "0.05"},
    "optimum: 6.32 kN, 60 ms, 30 mm, spread 3.8 %": {"thrust": "6323.924 N", "delay": "60 ms", "stroke": "30 mm",
                                                     "spread": "0.03822565"},
}


def add(figure, tools):
    @figure("boosters-separation")
    def separation(bench):
        import matplotlib.pyplot as plt
        drawn, rows = plt.subplots(3, 1, figsize=(7.5, 6.4), sharex=True, constrained_layout=True)
        for axes, case in zip(rows, (CASES[0], CASES[2], CASES[4])):
            run = run_case(bench, case)
            for i, time in enumerate((0.0, 1.3, 1.7, 2.1, 2.5)):
                sample = min(run["samples"], key=lambda s: abs(s["t"] - time))
                core = sample["bodies"]["core"]
                for k in (1, 3):
                    body = sample["bodies"][f"booster{k}"]
                    corners = [tools.seen_from(core, body, p)
                               for p in ((13.2, 0, 0), (-5.5, 1.34, 0), (-5.5, -1.34, 0), (13.2, 0, 0))]
                    axes.plot([c[0] for c in corners], [c[1] for c in corners], color=COLOURS[k - 1],
                              alpha=0.3 + 0.175 * i, linewidth=1, label=f"booster {k}" if i == 4 else None)
            for x0, x1, r in ((-19.5, 1, 1.025), (1, 26, 1.33)):
                axes.fill([x0, x1, x1, x0], [-r, -r, r, r], color="0.85", zorder=0)
            axes.set_aspect("equal")
            axes.set(xlim=(-28, 28), ylim=(-11, 11), ylabel="across, m")
            axes.set_title(f"{case[2]}: boosters 1 and 3 in the core's axes at 0, 1.3, 1.7, 2.1, 2.5 s", loc="left")
        rows[0].legend(loc="upper right")
        rows[-1].set_xlabel("along the core, m")
        return drawn

    @figure("boosters-reactions")
    def reactions(bench):
        import matplotlib.pyplot as plt
        run = run_case(bench, CASES[0])
        times = tools.get_times(run)
        drawn, rows = plt.subplots(3, 1, figsize=(7.5, 6), sharex=True, constrained_layout=True)
        rows[0].set_xlim(0, 1.5)
        for axes, row, unit in zip(rows, ("x", "z", "rot_y"), ("kN", "kN", "kN m")):
            axes.plot(times, [v / 1000 for v in tools.get_row(run, "nose1", row)], color=COLOURS[0])
            axes.set_ylabel(f"{row}, {unit}")
            tools.mark_events(axes, run, ("throttle", "verniers_off", "rudders_neutral", "ties_cut", "cutoff", "release",
                                          "contact", "liftoff"), labels=axes is rows[0])
        drawn.suptitle("What node 1 bears, core on booster: along its generatrix, across it, and the ties' moment", fontsize=10)
        rows[-1].set_xlabel("t, s")
        return drawn

    @figure("boosters-attitude")
    def attitude(bench):
        import matplotlib.pyplot as plt
        drawn, grid = plt.subplots(len(CASES), 2, figsize=(7.5, 9), sharex=True, sharey="col", constrained_layout=True)
        for row, case in zip(grid, CASES):
            run = run_case(bench, case)
            times = tools.get_times(run)
            for k in range(1, 5):
                angles, rates = [], []
                for sample in run["samples"]:
                    body, core = sample["bodies"][f"booster{k}"], sample["bodies"]["core"]
                    axis = tools.into(core["q"], tools.rotate(body["q"], (1, 0, 0)))
                    angles.append(math.degrees(math.acos(max(-1, min(1, axis[0])))))
                    rates.append(math.degrees(math.hypot(*body["w"])))
                style = dict(color=COLOURS[k - 1], label=f"booster {k}", **tools.layer(k - 1))
                row[0].plot(times, angles, **style)
                row[1].plot(times, rates, **style)
            row[0].set_title(case[2], loc="left")
            row[0].set_ylabel("deg")
            row[1].set_ylabel("deg/s")
        grid[0][0].set_title("angle to the core", loc="right")
        grid[0][1].set_title("angular rate", loc="right")
        for axes in grid[-1]:
            axes.set_xlabel("t, s")
        grid[0][0].legend()
        return drawn

    @figure("boosters-clearance")
    def clearance(bench):
        import matplotlib.pyplot as plt
        drawn, axes = plt.subplots(figsize=(7.5, 3), constrained_layout=True)
        for i, case in enumerate(CASES):
            run = run_case(bench, case)
            found = {pair["pair"][1]: pair for pair in run["clearance"] if pair["pair"][0] == "core"}
            for k in range(1, 5):
                pair = found[f"booster{k}"]
                axes.bar(i + 0.2 * (k - 2.5), pair["min"], 0.18, color=COLOURS[k - 1],
                         label=f"booster {k}" if i == 0 else None)
                axes.annotate(f"{pair['t']:.2f} s", (i + 0.2 * (k - 2.5), pair["min"]), rotation=90, ha="center",
                              va="bottom", fontsize=tools.LABEL, xytext=(0, 2), textcoords="offset points")
        axes.set_axisbelow(True)
        axes.set_xticks(range(len(CASES)), [case[2] for case in CASES])
        axes.set_ylim(0, axes.get_ylim()[1] * 1.4)
        axes.set_ylabel("least distance to the core, m")
        axes.set_title("How close the boosters come to the core after the ties are cut, and when", loc="left")
        axes.legend(ncols=4)
        return drawn

    @figure("boosters-recontact")
    def recontact(bench):
        import matplotlib.pyplot as plt
        drawn, (left, right) = plt.subplots(1, 2, figsize=(7.5, 3), constrained_layout=True)
        cases = (("cyclogram.yaml", ("--set", "events.contact:booster1.enabled=false"), "without contact: it flies through", "0.55"),
                 ("recontact.yaml", (), "with contact", COLOURS[0]))
        for file, options, label, colour in cases:
            for axes, first, last, every, scale in ((left, 2.2, 3.35, 0.01, 100), (right, 2.54, 2.6, 0.0005, 1000)):
                run = bench.run(f"boosters/{file}", 3.35 if axes is left else 2.6, every, *options)
                shown = [(sample["t"], scale * sample["clearance"][0]) for sample in run["samples"] if first <= sample["t"] <= last + 1e-9]
                axes.plot(*zip(*shown), color=colour, label=label)
        for axes, unit in ((left, "cm"), (right, "mm")):
            axes.axhline(0, color="0.3", linewidth=0.8)
            axes.set_xlabel("time, s")
            axes.set_ylabel(f"core to booster 1, {unit}")
        left.legend(loc="upper left")
        left.set_title("A booster whose nozzle stays shut", loc="left")
        right.set_title("The strike, 18 ms", loc="left")
        return drawn

    @figure("boosters-synthesis")
    def synthesis(bench):
        import matplotlib.pyplot as plt
        drawn, columns = plt.subplots(1, 2, figsize=(7.5, 3.4), sharey=True, constrained_layout=True)
        for axes, (title, values) in zip(columns, DESIGNS.items()):
            options = [text for name, value in values.items() for text in ("--set", f"constants.{name}={value}")]
            run = bench.call("run", tools.SCENARIOS / "boosters/design.yaml", "--outputs", "clearance.core.*", "--json", "-",
                             *options)
            table = run["outputs"][0]
            for k in (1, 3):
                axes.plot(table["t"], [row[k - 1] for row in table["rows"]], color=COLOURS[k - 1], label=f"boosters {k}, {k + 1}",
                          **tools.layer(k, 4))
            axes.plot([2.5], [4], marker="^", color="0.2", linestyle="none", label="at least 4 m", clip_on=False, zorder=5)
            axes.axvline(1.45, color="0.6", linewidth=0.8, linestyle="--", label="lifted off by 1.45 s")
            axes.set_xlim(0, 2.5)
            axes.set_ylim(0, 5)
            axes.set_xlabel("t, s")
            axes.set_title(title, loc="left", fontsize=tools.LABEL + 1)
            liftoffs = ", ".join(f"{event['t']:.3f}" for event in run["events"]
                                 if event["name"] == "liftoff" and event["subject"] in ("booster1", "booster3"))
            axes.annotate(f"liftoffs {liftoffs} s", (0.03, 0.5), xycoords="axes fraction", fontsize=tools.LABEL)
        columns[0].set_ylabel("distance to the core, m")
        columns[0].legend(loc="upper left")
        return drawn
