#!/usr/bin/python3
"""The zone of safe position of the payload: how much room the elastic half 1 leaves on its way, by station and azimuth.

    safe_zone.py RUN.json...    of `unlatch run scenario.yaml --until 1.6 --json RUN.json --outputs OUTPUTS` with OUTPUTS as below

Every point of fairing.modes is followed: its place in the half's axes is that of the undeformed shell and the sum of the modes'
shapes. The modal coordinates are those that move the markers as the run did. In the core's axes the point has a station (from the base), an
azimuth (from the middle of the half) and a radius; the zone is the smallest radius that ever came into a cell, less half the wall.
Several runs: the smallest of all. SI, angles in degrees.
"""
import json
import math
import pathlib
import sys

import numpy as np

OUTPUTS = "body.core.position@4,body.core.attitude@4,body.half1.attitude@4,body.half1*.position@4"
FOLDER = pathlib.Path(__file__).parent
SELECT, WALL, BASE = 5, 0.01, 3.0           # modes of scenario.yaml; m; m of the base in the core's axes
STATIONS = np.arange(0, 12.01, 0.5)         # m, edges of the cells
AZIMUTHS = np.arange(-100.0, 100.1, 10.0)   # deg


def read_modes(path=FOLDER / "fairing.modes"):
    """Frequencies (Hz), points (mass, place, displacements by mode), markers {name: (place, displacements by mode)}."""
    hz, points, markers, left, marker = [], [], {}, 0, None
    for line in path.read_text().splitlines():
        words = line.split("#")[0].split()
        if not words:
            continue
        if left > 0:
            values = list(map(float, words))
            points.append((values[0], values[1:4], [values[4 + 3 * k:7 + 3 * k] for k in range(len(hz))]))
            left -= 1
        elif words[0] == "frequencies":
            hz = list(map(float, words[1:]))
        elif words[0] == "points":
            left = int(words[1])
        elif words[0] == "marker":
            marker = markers[words[1]] = (list(map(float, words[2:5])), [])
        elif marker is not None and len(marker[1]) < len(hz):
            marker[1].append(list(map(float, words[:3])))
    return hz, points, markers


class Shell:
    """A half from its undeformed centre of mass: places (n, 3) and shapes (n, 3, SELECT) of points and of markers, the shapes free of
    rigid motion and orthonormal by mass, as hil/MODES.md says."""

    def __init__(self):
        hz, points, markers = read_modes()
        mass = np.array([m for m, _, _ in points])
        places = np.array([place for _, place, _ in points])
        shapes = np.array([shape for _, _, shape in points]).transpose(0, 2, 1)
        centre = mass @ places / mass.sum()
        self.names = list(markers)
        self.places, self.marked = places - centre, np.array([place for place, _ in markers.values()]) - centre
        at = np.array([shape for _, shape in markers.values()]).transpose(0, 2, 1)
        rigid, rigid_at = self.list_rigid(self.places), self.list_rigid(self.marked)
        parts = np.linalg.solve(np.einsum("i,iak,ial->kl", mass, rigid, rigid), np.einsum("i,iak,ial->kl", mass, rigid, shapes))
        shapes, at = shapes - rigid @ parts, at - rigid_at @ parts
        scale = 1 / np.sqrt(np.einsum("i,iak,iak->k", mass, shapes, shapes))
        shapes, at = shapes * scale, at * scale
        lower = np.linalg.inv(np.linalg.cholesky(np.einsum("i,iak,ial->kl", mass, shapes, shapes)))
        turn = lower.T @ np.linalg.eigh(lower @ np.diag(np.square(hz)) @ lower.T)[1][:, :SELECT]
        self.shapes, self.at = shapes @ turn, at @ turn

    @staticmethod
    def list_rigid(places):
        """The six motions of a rigid body as shapes (n, 3, 6)."""
        x, y, z = places.T
        none, one = np.zeros(len(places)), np.ones(len(places))
        return np.array([[one, none, none, none, z, -y], [none, one, none, -z, none, x], [none, none, one, y, -x, none]]).transpose(2, 0, 1)

    def find_modal(self, moved):
        """Modal coordinates that take the markers to the places (n, 3) in the half's axes, and the largest distance left, m."""
        matrix, wanted = self.at.reshape(-1, SELECT), (moved - self.marked).ravel()
        modal = np.linalg.lstsq(matrix, wanted, rcond=None)[0]
        return modal, np.abs(matrix @ modal - wanted).max()


def rotation(q):
    w, x, y, z = q
    return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                     [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                     [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]])


def list_poses(run):
    """(t, bodies' positions, attitudes of core and half 1) of the table of outputs."""
    table = run["outputs"][0]
    names = [column["name"] for output in table["outputs"] for column in output["columns"]]
    for t, row in zip(table["t"], table["rows"]):
        values = dict(zip(names, row))
        places = {name[:-2]: np.array([values[f"{name[:-2]}.{axis}"] for axis in "xyz"]) for name in names if name.endswith(".x")}
        yield t, places, {body: rotation([values[f"{body}.q{axis}"] for axis in "wxyz"]) for body in ("core", "half1")}


def calc_zone(run, shell, elastic=True):
    """Smallest radii (stations, azimuths), nan where no point came, and what the markers leave unexplained, m."""
    zone, worst = np.full((len(STATIONS) - 1, len(AZIMUTHS) - 1), np.inf), 0.0
    for _, places, turns in list_poses(run):
        moved = np.array([(places[f"half1_{name}"] - places["half1"]) @ turns["half1"] for name in shell.names])
        modal, left = shell.find_modal(moved)
        worst = max(worst, left)
        points = shell.places + (shell.shapes @ modal if elastic else 0)
        x, y, z = ((points @ turns["half1"].T + places["half1"] - places["core"]) @ turns["core"]).T
        rows = np.digitize(z - BASE, STATIONS) - 1
        columns = np.digitize(np.degrees(np.arctan2(x, y)), AZIMUTHS) - 1
        inside = (rows >= 0) & (rows < zone.shape[0]) & (columns >= 0) & (columns < zone.shape[1])
        np.minimum.at(zone, (rows[inside], columns[inside]), np.hypot(x, y)[inside] - WALL / 2)
    return np.where(np.isinf(zone), np.nan, zone), worst


if __name__ == "__main__":
    half, zones = Shell(), []
    for name in sys.argv[1:]:
        zone, left = calc_zone(json.loads(pathlib.Path(name).read_text()), half)
        if left > 1e-6:
            sys.exit(f"{name}: the markers are {left:.1e} m off the modes of fairing.modes")
        zones.append(zone)
    if not zones:
        sys.exit(__doc__)
    smallest = np.fmin.reduce(zones)
    print("station, m   smallest radius, m   at azimuth, deg")
    for low, row in zip(STATIONS, smallest):
        if not np.isnan(row).all():
            at = AZIMUTHS[np.nanargmin(row)]
            print(f"{low:5.1f} … {low + 0.5:4.1f}   {np.nanmin(row):.3f}                {at:.0f} … {at + 10:.0f}")
