#!/usr/bin/python3
"""Tight-tolerance references of dispersed booster separations: hil/scenarios/boosters/campaign.yaml, independent of unlatch's mechanics.

The values of the first samples come from a table of `unlatch campaign`; the motion is that of boosters_reference.py (dense KKT
matrix, DOP853 at rtol 1e-12), with masses, tail-offs, nozzles, delays and the core's thrust of each sample.

    unlatch campaign hil/scenarios/boosters/campaign.yaml --samples 0:40 --out DIR
    separations_reference.py DIR/samples.csv    writes tests/data/boosters_separations.json; needs python3-scipy; some minutes
"""
import copy
import csv
import json
import sys

import numpy as np

import boosters_reference as reference

NOMINAL = copy.deepcopy(reference.P)
UNTIL = 2.0  # s, of hil/scenarios/boosters/reference.yaml


class Separation(reference.Boosters):
    """The boosters on their noses alone from the beginning, as in reference.yaml. `values`: the inputs of a sample."""

    def __init__(self, values):
        reference.P = copy.deepcopy(NOMINAL)
        for k, booster in enumerate(reference.P["boosters"]):
            booster["m"] = values[f"mass:{k + 1}"]
            booster["nozzle_force"] = values[f"nozzle:{k + 1}"]
        axis = np.array([values[f"core_axis.{part}"] for part in "xyz"])
        self.thrust_of_core = values["core_thrust"] * axis
        super().__init__({"tails": [(values[f"thrust:{k}"], values[f"decay:{k}"]) for k in range(1, 5)], "until": UNTIL,
                          "delay": {k: values[f"nozzle_delay:{k + 1}"] for k in range(4)}})
        self.samples = [0.0]

    def calc_core_load(self):
        return self.thrust_of_core, np.cross(reference.P["core"]["thrust_point"], self.thrust_of_core)

    def list_times(self):
        return set()  # no cyclogram


def read_inputs(path):
    """The inputs of each sample by name, without units, SI."""
    with open(path, newline="", encoding="utf-8") as file:
        for row in csv.DictReader(file):
            yield int(row["sample"]), {name.split(" [")[0]: value for name, value in row.items()}


def main():
    names = [f"{name}:{k}" for name in ("thrust", "decay", "mass", "nozzle", "nozzle_delay") for k in range(1, 5)]
    names += ["core_axis.x", "core_axis.y", "core_axis.z", "core_thrust"]
    lines = []
    for sample, texts in read_inputs(sys.argv[1]):
        values = {name: float(texts[name]) for name in names}
        events, _ = Separation(values).run()
        times = {f"{name}:booster{k}": t for t, name, k in sorted(events, key=lambda event: (event[1], event[2]))}
        lines.append(json.dumps({"sample": sample, "inputs": values, "events": times}))
        print(sample, {name: f"{t:.6f}" for name, t in times.items()}, flush=True)
    about = json.dumps("tests/references/separations_reference.py: dense KKT, DOP853 at rtol 1e-12, of samples of "
                       "hil/scenarios/boosters/campaign.yaml. SI")
    (reference.DATA / "boosters_separations.json").write_text(f'{{"about": {about},\n"separations": [\n' + ",\n".join(lines) + "\n]}\n")


if __name__ == "__main__":
    main()
