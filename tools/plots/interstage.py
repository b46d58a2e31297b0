"""Figures of two stages that part: forces of pushers and umbilical, the gap between nozzle and skirt; a duct of triangles in the skirt; dispersed bolts and pushers."""
from plots import campaign


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

    @figure("interstage-campaign")
    def dispersion(bench):
        return campaign.draw(bench, tools, "interstage/campaign.yaml", ["R1"], "least gap of nozzle and skirt", "cm", factor=100,
                             events=("stroke_end", "taut", "part"), rows=8)

    @figure("interstage-duct")
    def duct(bench):
        import pathlib
        import matplotlib.pyplot as plt
        drawn, (left, right) = plt.subplots(1, 2, figsize=(7.5, 3.2), constrained_layout=True)
        lines = (pathlib.Path(__file__).parent.parent / "hil/scenarios/interstage/duct.obj").read_text().splitlines()
        corners = [[float(word) / 1000 for word in line.split()[1:]] for line in lines if line.startswith("v ")]
        for line in lines:
            if line.startswith("f "):
                face = [corners[int(word) - 1] for word in line.split()[1:]]
                left.plot([p[0] + 4 for p in face + face[:1]], [p[1] for p in face + face[:1]], color="#e76f51", linewidth=0.4)
        for side in (-1, 1):
            left.plot([1.6, 4], [1.32 * side] * 2, color="#1d3557", linewidth=2)
        left.plot([2, 3.9, 3.9, 2, 2], [0.9, 0.25, -0.25, -0.9, 0.9], color="0.35")
        for x, y, text in ((1.75, 1.42, "skirt"), (2.2, 0, "nozzle"), (2.6, 1.12, "duct")):
            left.annotate(text, (x, y), fontsize=tools.LABEL)
        left.set_ylim(-1.5, 1.65)
        left.set_aspect("equal")
        left.set_xlabel("along the axis of the lower stage, m")
        left.set_ylabel("across it, through the duct, m")
        left.set_title("Mated, with the duct's facets", loc="left")
        run = bench.run("interstage/duct.yaml", 2.6, 0.005)
        travel = [sample["bodies"]["upper"]["p"][0] - sample["bodies"]["lower"]["p"][0] - 7.2 for sample in run["samples"]]
        for pair, label, color in ((0, "nozzle (exact)", "#1d3557"), (1, "duct (triangles)", "#e76f51")):
            shown = [(x, 100 * sample["clearance"][pair]) for x, sample in zip(travel, run["samples"]) if x < 2.3]
            right.plot(*zip(*shown), label=label, color=color)
        for height, text in ((30, "R1, nozzle"), (10, "R6, duct")):
            right.axhline(height, color="0.5", linewidth=0.8, linestyle="--")
            right.annotate(text, (2.2, height), (0, 3), textcoords="offset points", ha="right", fontsize=tools.LABEL, color="0.35")
        right.set_ylim(0, None)
        right.set_xlabel("travel of the upper stage, m")
        right.set_ylabel("gap to the skirt, cm")
        right.set_title("Gaps while the stages part", loc="left")
        right.legend(loc="upper left")
        return drawn
