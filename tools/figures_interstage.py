"""Figure of two stages that part: forces of pushers and umbilical, and the gap between nozzle and skirt."""


def add(figure, tools):
    @figure("interstage-separation")
    def separation(bench):
        import matplotlib.pyplot as plt
        drawn, (left, right) = plt.subplots(1, 2, figsize=(7.5, 3.2), constrained_layout=True)
        run = bench.run("interstage/scenario.yaml", 0.82, 0.0005)
        times = [sample["t"] for sample in run["samples"]]
        for name, label, style in (("pusher1", "pushers 1 to 5, each", {"color": "#1d3557"}), ("pusher6", "pusher 6, weak", {"color": "#c1121f"}),
                                   ("umbilical", "umbilical, pulling", {"color": "#2a9d8f"})):
            forces = [abs(sample["elements"][name]["force"]) / 1e3 for sample in run["samples"]]
            left.plot(times, forces, label=label, **style)
        left.set_xlim(0.59, 0.82)
        left.set_ylim(0, None)
        left.set_xlabel("time, s")
        left.set_ylabel("force, kN")
        left.set_title("Bolts break from 0.600 s to 0.604 s", loc="left")
        left.legend()
        for name, label, color in (("scenario", "pusher 6 weak", "#1d3557"), ("two-dead", "pushers 5 and 6 dead", "#c1121f")):
            run = bench.run(f"interstage/{name}.yaml", 2.6, 0.005)
            travel = [sample["bodies"]["upper"]["p"][0] - sample["bodies"]["lower"]["p"][0] - 7.2 for sample in run["samples"]]
            gap = [sample["clearance"][0] for sample in run["samples"]]
            shown = [(x, 100 * y) for x, y in zip(travel, gap) if x < 2.3]
            right.plot(*zip(*shown), label=label, color=color)
            for event in run["events"]:
                if event["name"] == "touch":
                    x = next(x for x, sample in zip(travel, run["samples"]) if sample["t"] >= event["t"])
                    right.plot(x, 0, "o", color=color, markersize=4)
                    right.annotate(f"touches at {event['t']:.2f} s", (x, 0), (12, -2), textcoords="offset points", ha="left", fontsize=tools.LABEL)
        right.axhline(30, color="0.5", linewidth=0.8, linestyle="--")
        right.annotate("requirement R1", (1.1, 30), (0, 3), textcoords="offset points", ha="center", fontsize=tools.LABEL, color="0.35")
        right.set_xlabel("travel of the upper stage, m")
        right.set_ylabel("nozzle to skirt, cm")
        right.set_title("Gap while the nozzle leaves the skirt", loc="left")
        right.legend(loc="lower left")
        return drawn
