"""The figure of a campaign: distribution of what a requirement limits, the first-order indices of its inputs, times of the events."""
import csv

BLUE, RED = "#1d3557", "#c1121f"
BARS = 8  # of the tornado


def read_column(folder, name):
    with open(folder / "samples.csv", newline="", encoding="utf-8") as table:
        return sorted(float(value) for row in csv.DictReader(table) for key, value in row.items() if key.split(" [")[0] == name and value)


def describe(probability):
    return f"{100 * probability:.2g} %"


def draw_distribution(axes, summary, folder, ids, labels, colours, what, unit, factor):
    """Steps, the limit of requirements that have the same, and of the one that fails most often 95 % intervals of its quantiles."""
    requirements = [next(entry for entry in summary["requirements"] if entry["id"] == name) for name in ids]
    worst = max(requirements, key=lambda entry: entry["failed"])
    for name, label, colour in zip(ids, labels, colours):
        column = next(column for column in summary["columns"] if column["name"] == name)
        values = [factor * value for value in read_column(folder, name)]
        axes.step(values, [(k + 1) / len(values) for k in range(len(values))], where="post", color=colour, label=label)
        if name == worst["id"]:
            for p, (least, greatest) in column["intervals"].items():
                axes.plot([factor * least, factor * greatest], [float(p)] * 2, color=colour, linewidth=5, alpha=0.4, solid_capstyle="butt")
    for key in ("at_least", "at_most"):
        if requirements[0][key] is not None:
            axes.axvline(factor * requirements[0][key], color=RED, linewidth=1, linestyle="--")
    low, high = worst["probability"]
    text = f"{worst['id']}: {worst['failed']} of {summary['samples']} fail, " + (f"below {describe(high)}" if worst["failed"] == 0 else f"{describe(low)} … {describe(high)}")
    axes.set_title(text, loc="left")
    axes.set_xlabel(f"{what}, {unit}; dashed: the limit")
    axes.set_ylabel("part of the samples")
    axes.set_ylim(-0.02, 1.02)
    if any(labels):
        axes.legend(loc="upper left")


def draw_drivers(axes, tools, summary, name):
    """First-order indices on a fixed scale, with their intervals, and the line below which an input without influence stays."""
    sensitivity = next(column for column in summary["columns"] if column["name"] == name)["sensitivity"]
    entries = zip([entry["name"] for entry in summary["inputs"]], sensitivity["first_order"], sensitivity["spearman"])
    bars = sorted((entry for entry in entries if entry[1]["index"] is not None), key=lambda entry: -entry[1]["index"])[:BARS][::-1]
    for k, (_, first, rank) in enumerate(bars):
        axes.barh(k, max(0, first["index"]), color=BLUE if rank > 0 else "#e09f3e", height=0.6)
        axes.plot(first["interval"], [k, k], color="0.2", linewidth=1)
        axes.annotate(f"{first['index']:.2f}", (max(0, first["index"], first["interval"][1]), k), (3, 0), textcoords="offset points", va="center", fontsize=tools.LABEL)
    axes.axvline(sensitivity["significant"], color=RED, linewidth=0.8, linestyle=":")
    axes.set_yticks(range(len(bars)), [name for name, _, _ in bars])
    axes.set_xlim(0, 1.15)
    axes.tick_params(axis="y", labelsize=tools.LABEL)
    axes.grid(axis="y", visible=False)
    axes.set_axisbelow(True)
    axes.set_xlabel("first-order index; dotted: significant")
    axes.set_title(f"What decides {name}", loc="left")


def draw_events(axes, tools, summary, only):
    events = [column for column in summary["columns"] if column["kind"] == "event" and column["count"] > 0 and column["name"].startswith(tuple(f"event.{name}" for name in only))]
    events.sort(key=lambda column: -column["quantiles"]["0.5"])
    for k, column in enumerate(events):
        quantiles = column["quantiles"]
        axes.plot([column["min"], column["max"]], [k, k], color="0.5", linewidth=1)
        axes.plot([quantiles["0.05"], quantiles["0.95"]], [k, k], color="#457b9d", linewidth=5, solid_capstyle="butt")
        axes.plot([quantiles["0.5"]], [k], "o", color=RED, markersize=3.5)
    axes.set_yticks(range(len(events)), [column["name"].removeprefix("event.") for column in events], fontsize=tools.LABEL)
    axes.set_ylim(-0.6, len(events) - 0.4)
    axes.grid(axis="y", visible=False)
    axes.set_xlabel("t, s")
    axes.set_title("Events: all (thin), 5 % to 95 % (thick), median", loc="left")


def draw(bench, tools, file, ids, what, unit, factor=1, labels=("",), colours=(BLUE,), driven=None, events=("",), rows=8):
    """`ids`: requirements of one limit; `driven`: the column of the tornado, without it the first; `events`: beginnings of the names shown."""
    import matplotlib.pyplot as plt
    folder = bench.folder / file.replace("/", "-")
    summary = bench.call("campaign", tools.SCENARIOS / file, "--out", folder, "--json", "-")
    drawn, grid = plt.subplot_mosaic([["distribution", "drivers"], ["events", "events"]], figsize=(7.5, 3.9 + 0.17 * rows),
                                     height_ratios=[3, 0.2 * rows + 0.3], constrained_layout=True)
    draw_distribution(grid["distribution"], summary, folder, ids, labels, colours, what, unit, factor)
    draw_drivers(grid["drivers"], tools, summary, driven or ids[0])
    draw_events(grid["events"], tools, summary, events)
    return drawn
