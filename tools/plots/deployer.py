"""Figures of a cubesat that leaves its deployer: the deployer from the side, forces on the rails, rates, and tip-off over misalignment."""
import math

COLOURS = {"aligned": "#1d3557", "misaligned": "#c1121f"}
RUNS = (("aligned", "scenario.yaml", "spring in the middle"), ("misaligned", "misaligned.yaml", "spring 8 mm beside it"))
PLATE, HALF, SIDE, GAP, RAIL_END = 1200, 170.25, 50, 0.3, 350  # mm, as in the scenario


def add(figure, tools):
    def draw_rails(axes, scale):
        """Across y; what is narrower than the picture's lines is drawn `scale` times as wide."""
        import matplotlib.patches as patches
        for sign in (1, -1):
            inner = sign * (SIDE + scale * GAP)
            axes.add_patch(patches.Rectangle((-10, min(inner, inner + 5 * sign)), RAIL_END + 10, 5, color="0.6", linewidth=0))

    def draw_cubesat(axes, run, time, scale, **style):
        sample = min(run["samples"], key=lambda s: abs(s["t"] - time))
        stage, cubesat = sample["bodies"]["stage"], sample["bodies"]["cubesat"]
        corners = []
        for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1)):
            seen = tools.seen_from(stage, cubesat, [x * HALF / 1e3, y * SIDE / 1e3, 0])
            corners.append((1e3 * seen[0] - PLATE, y * SIDE + scale * (1e3 * seen[1] - y * SIDE)))
        axes.fill(*zip(*corners), **style)

    @figure("deployer-exit")
    def leaving(bench):
        import matplotlib.pyplot as plt
        drawn, rows = plt.subplots(2, 1, figsize=(7.5, 4.2), constrained_layout=True, sharex=True)
        scale = 20
        for axes, (name, scenario, label) in zip(rows, RUNS):
            run = bench.run(f"deployer/{scenario}", 1.1, 0.002)
            draw_rails(axes, scale)
            for time in (0.5, 0.74, 0.88):
                draw_cubesat(axes, run, time, scale, facecolor="none" if time > 0.5 else "0.93", edgecolor=COLOURS[name], linewidth=1.1)
            offset = 8 if name == "misaligned" else 0
            axes.annotate("", (0, offset), (-45, offset), arrowprops={"arrowstyle": "-|>", "color": "0.3"})
            axes.annotate("spring", (-48, offset), ha="right", va="center", fontsize=tools.LABEL, color="0.35")
            axes.annotate("rails", (345, 63), ha="right", va="bottom", fontsize=tools.LABEL, color="0.35")
            axes.set_title(label[0].upper() + label[1:], loc="left")
            axes.set_xlim(-110, 760)
            axes.set_ylim(-150, 88)
            axes.grid(False)
            axes.set_ylabel("y, mm")
        rows[-1].set_xlabel(f"x from the push plate, mm; gaps and deflections along y are drawn {scale} times as large")
        return drawn

    @figure("deployer-tipoff")
    def tipoff(bench):
        import matplotlib.pyplot as plt
        drawn, (left, middle, right) = plt.subplots(1, 3, figsize=(7.5, 3.0), constrained_layout=True)
        fine = ("--set", "step.dt=0.0001", "--set", "step.contact_substeps=4")  # blows last 2 ms
        run = bench.run("deployer/misaligned.yaml", 0.87, 0.0001, *fine)
        times = tools.get_times(run)
        for name, label, colour in (("aft1", "rear corner", "#1d3557"), ("fore2", "front corner", "#2a9d8f"), ("lip2", "end of the rail", "#e9a23b")):
            left.plot(times, [sample["elements"][name]["force"] or math.nan for sample in run["samples"]], label=label, color=colour, linewidth=0.9)
        left.set_xlim(0.5, 0.87)
        left.set_yscale("log")
        left.set_ylim(0.05, 50)
        left.set_xlabel("time, s")
        left.set_ylabel("normal force, N")
        left.set_title("Contacts, 8 mm", loc="left")
        left.legend()
        for name, scenario, label in RUNS:
            run = bench.run(f"deployer/{scenario}", 0.87, 0.0001, *fine)
            rates = [math.degrees(sample["bodies"]["cubesat"]["w"][2]) for sample in run["samples"]]
            middle.plot(tools.get_times(run), rates, label=label.replace("spring ", ""), color=COLOURS[name], linewidth=0.9)
        middle.set_xlim(0.5, 0.87)
        middle.set_xlabel("time, s")
        middle.set_ylabel("rate about z, deg/s")
        middle.set_title("Rate of the cubesat", loc="left")
        middle.legend(loc="center", bbox_to_anchor=(0.45, 0.4), title="spring", title_fontsize=tools.LABEL)
        offsets = (0, 0.5, 1, 1.5, 2, 3, 4, 5, 6, 7, 8, 9, 10)
        values = []
        for offset in offsets:
            found = bench.run("deployer/misaligned.yaml", 1, 1, "--set", f"constants.offset_y={offset / 1e3}")
            values.append(next(math.degrees(v["value"]) for v in found["verdict"] if v["id"] == "tipoff"))
        right.plot(offsets, values, "o-", color=COLOURS["misaligned"], markersize=3)
        right.axhline(5, color="0.5", linewidth=0.8, linestyle="--")
        right.annotate("required", (0.2, 5), (0, 3), textcoords="offset points", fontsize=tools.LABEL, color="0.35")
        right.set_ylim(0, None)
        right.set_xlabel("spring beside the middle, mm")
        right.set_ylabel("tip-off rate, deg/s")
        right.set_title("After the exit", loc="left")
        return drawn
