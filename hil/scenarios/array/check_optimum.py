#!/usr/bin/python3
"""Checks an optimum of the array with SciPy, which knows nothing of `unlatch optimize`:

    check_optimum.py BIN [PROBLEM] [--evolve GENERATIONS] [--beside PART] [--flights N] [--seed N] [--json]

Differential evolution over the whole box (GENERATIONS of 15 designs for each variable), or, with --beside, the problem's optimum
moved by up to PART of each variable's range; from there Nelder and Mead's method with at most N flights. What is not met counts
as a penalty of 100 s for each limit by which it is missed. Needs python3-scipy; exit
code 77 without it.
"""
import argparse
import csv
import json
import pathlib
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
PENALTY = 100  # s
NEVER = 1e4    # s, of a flight that has no value of some requirement


class Flights:
    """Flights of designs in SI units, side by side in one campaign."""

    def __init__(self, program, problem, folder):
        import yaml
        self.program, self.folder, self.count = program, folder, 0
        self.problem = yaml.safe_load(problem.read_text(encoding="utf-8"))
        self.names = list(self.problem["variables"])
        self.scenario = problem.parent / self.problem["scenario"]
        listed = json.loads(subprocess.run([program, "check", problem, "--json", "-"], check=True, capture_output=True, text=True).stdout)
        self.start = [variable["value"] for variable in listed["variables"].values()]
        self.units = [variable["unit"] for variable in listed["variables"].values()]
        self.bounds = [[float(str(bound).split()[0]) for bound in variable["between"]] for variable in self.problem["variables"].values()]
        (folder / "flights.yaml").write_text(yaml.safe_dump({
            "unlatch_campaign": 1, "name": "flights", "scenario": str(self.scenario), "sampling": "csv",
            "table": "designs.csv",
            "parameters": {name: {"path": variable["path"]} for name, variable in self.problem["variables"].items()}}), encoding="utf-8")

    def fly(self, designs):
        """Returns the penalised objectives."""
        return [self.fly_one(designs[0])] if len(designs) == 1 else self.fly_all(designs)

    def fly_one(self, design):
        settings = [f"--set={self.problem['variables'][name]['path']}={float(value)!r} {unit}"
                    for name, value, unit in zip(self.names, design, self.units)]
        done = subprocess.run([self.program, "run", self.scenario, "--json", "-", *settings], capture_output=True, text=True)
        if done.returncode not in (0, 1):  # 1: a requirement that is not met
            sys.exit(done.stderr)
        run = json.loads(done.stdout)
        verdict = {entry["id"]: entry for entry in run["verdict"]}
        if any(entry.get("margin") is None for entry in run["verdict"]):
            return NEVER
        return self.judge(verdict["unfolded"]["value"], [(entry["value"], entry["margin"]) for entry in run["verdict"]])

    def fly_all(self, designs):
        self.count += 1
        with open(self.folder / "designs.csv", "w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file)
            writer.writerow(self.names)
            writer.writerows([repr(float(value)) for value in design] for design in designs)
        out = self.folder / f"flights{self.count}"
        done = subprocess.run([self.program, "campaign", self.folder / "flights.yaml", "--out", out], capture_output=True, text=True)
        if done.returncode not in (0, 1):  # 1: a requirement that is not met
            sys.exit(done.stderr)
        with open(out / "samples.csv", newline="", encoding="utf-8") as file:
            rows = [{name.partition(" [")[0]: cell for name, cell in row.items()} for row in csv.DictReader(file)]
        ids = [name.removesuffix(".margin") for name in rows[0] if name.endswith(".margin")]
        return [NEVER if any(not row[f"{name}.margin"] for name in ids) else
                self.judge(float(row["unfolded"]), [(float(row[name]), float(row[f"{name}.margin"])) for name in ids]) for row in rows]

    @staticmethod
    def judge(unfolded, requirements):
        """Penalises (value, margin) of each requirement, as a part of the limit, whatever its side."""
        return unfolded + sum(PENALTY * -margin / max(abs(value + margin), abs(value - margin))
                              for value, margin in requirements if margin < 0)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bin", type=pathlib.Path)
    parser.add_argument("problem", type=pathlib.Path, nargs="?", default=HERE / "synthesis.yaml")
    parser.add_argument("--evolve", type=int, default=70, metavar="GENERATIONS")
    parser.add_argument("--beside", type=float, metavar="PART")
    parser.add_argument("--design", type=float, nargs="*", help="of --beside; default: the problem's start")
    parser.add_argument("--flights", type=int, default=400)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    try:
        import numpy as np
        from scipy.optimize import differential_evolution, minimize
    except ImportError:
        print("check_optimum.py: SciPy is missing: apt install python3-scipy", file=sys.stderr)
        sys.exit(77)
    with tempfile.TemporaryDirectory() as folder:
        flights = Flights(options.bin / "unlatch", options.problem.resolve(), pathlib.Path(folder))
        found = {}
        if options.beside is None:
            evolved = differential_evolution(lambda x: np.array(flights.fly(x.T)), flights.bounds, maxiter=options.evolve, popsize=15,
                                             seed=options.seed, polish=False, updating="deferred", vectorized=True)
            start, found["evolution"] = evolved.x, float(evolved.fun)
        else:
            random = np.random.default_rng(options.seed)
            low, high = np.array(flights.bounds).T
            start = np.array(options.design or flights.start) + options.beside * (high - low) * random.uniform(-1, 1, len(low))
            start = np.clip(start, low, high)
            found["begin"] = flights.fly([start])[0]
        polished = minimize(lambda x: flights.fly([x])[0], start, method="Nelder-Mead", bounds=flights.bounds,
                            options={"maxfev": options.flights, "xatol": 1e-5, "fatol": 1e-7})
        found["simplex"] = float(polished.fun)
        found["design"] = dict(zip(flights.names, map(float, polished.x)))
    print(json.dumps(found) if options.json else "\n".join(f"{key}: {value}" for key, value in found.items()))


if __name__ == "__main__":
    main()
