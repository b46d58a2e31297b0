"""Tables: results of campaigns, exported recordings, recordings."""

from __future__ import annotations

import csv
import json
import os
import re
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any, Dict, Iterator, List, Mapping, Optional, Sequence, Tuple

import numpy as np
import numpy.typing as npt

from unlatch.errors import FileError, Mistake, MissingFileError
from unlatch.simulation import Path, Simulation, open_recording

if TYPE_CHECKING:
    import pandas  # type: ignore[import]

Column = npt.NDArray[Any]
_HEADING = re.compile(r"(.*?)(?: \[([^\[\]]*)\])?")  # "core.vx [m/s]"


class Table(Mapping[str, Column]):
    """Columns by their names, without units: NumPy arrays of one length. Numbers are float64, NaN where there is none; whole
    numbers int64; everything else text."""

    def __init__(self, columns: Mapping[str, Column], units: Mapping[str, str], *, manifest: Optional[Dict[str, Any]] = None) -> None:
        self._columns = dict(columns)
        #: unit of each column, SI; "" if it has none
        self.units: Dict[str, str] = {name: units.get(name, "") for name in columns}
        #: of a campaign's folder: what decides its samples (manifest.json); else empty
        self.manifest: Dict[str, Any] = manifest or {}

    def __getitem__(self, name: str) -> Column:
        try:
            return self._columns[name]
        except KeyError:
            raise KeyError(f"no column '{name}'; known: {', '.join(self._columns)}") from None

    def __iter__(self) -> Iterator[str]:
        return iter(self._columns)

    def __len__(self) -> int:
        return len(self._columns)

    @property
    def rows(self) -> int:
        """Number of rows."""
        return len(next(iter(self._columns.values()))) if self._columns else 0

    def to_pandas(self) -> "pandas.DataFrame":
        """The same as a DataFrame; attrs["units"] has the units. Needs pandas."""
        import pandas

        frame = pandas.DataFrame(self._columns)
        frame.attrs["units"] = dict(self.units)
        return frame

    def __repr__(self) -> str:
        return f"Table({len(self)} columns, {self.rows} rows)"


def read_table(path: Path) -> Table:
    """Reads a table: the folder of a campaign (`unlatch campaign FILE --out FOLDER`), its samples.csv, or what
    `unlatch export --format csv` wrote; a file *.parquet where pandas has a reader of that format (pyarrow). Raises FileError."""
    path = FilePath(path)
    if path.is_dir():
        return _read_campaign(path)
    if path.suffix == ".parquet":
        return _read_parquet(path)
    return _read_csv(path)


def read_recording(path: Path, every: int = 1) -> Table:
    """Steps through a recording (*.log) and tabulates it at every `every`-th tick and the last: tick, t, for each body NAME.x …
    (as `unlatch export` calls them), channels and sensors (as sim.sensors: with their errors, held between samples); of a session the sensors also as flight software received them.
    Raises FileError, and DifferenceError where it does not replay."""
    if every < 1:
        raise ValueError("every is 1 or more, in ticks")
    with open_recording(path) as sim:
        names, units, views = _list_views(sim)
        rows: List[npt.NDArray[np.float64]] = []
        ticks: List[int] = []
        while True:
            ticks.append(sim.tick)
            rows.append(np.concatenate(views))
            if sim.run(ticks=every) == 0:
                break
        numbers = np.array(rows)
        columns: Dict[str, Column] = {"tick": np.array(ticks, dtype=np.int64), "t": np.array(ticks) * sim.dt}
        columns.update({name: numbers[:, i] for i, name in enumerate(names)})
        return Table(columns, {"t": "s", **units})


_PARTS = (("position", ("x", "y", "z"), "m"), ("attitude", ("qw", "qx", "qy", "qz"), ""), ("velocity", ("vx", "vy", "vz"), "m/s"),
          ("angular_velocity", ("wx", "wy", "wz"), "rad/s"))


def _list_views(sim: Simulation) -> Tuple[List[str], Dict[str, str], List[npt.NDArray[np.float64]]]:
    names: List[str] = []
    units: Dict[str, str] = {}
    views: List[npt.NDArray[np.float64]] = []

    def add(group: str, column: str, unit: str) -> None:
        while column in units:  # a sensor `x` beside a body `sensor`: as exports name it
            column = f"{group}.{column}"
        names.append(column)
        units[column] = unit

    for name, body in sim.bodies.items():
        for part, letters, unit in _PARTS:
            views.append(getattr(body, part))
            for letter in letters:
                add("body", f"{name}.{letter}", unit)
    for kind, sensors in (("sensor", sim.sensors), ("received", sim.received)):
        for name, value in sensors.items():
            views.append(value)
            letters = {1: ("",), 3: (".x", ".y", ".z"), 4: (".w", ".x", ".y", ".z")}.get(
                len(value), (".x", ".y", ".z", ".rot_x", ".rot_y", ".rot_z"))
            for letter in letters[:len(value)]:
                add(kind, f"{kind}.{name}{letter}", sim.get_unit("sensor", name))
    for name in sim.channels:
        add("command", f"channel.{name}", sim.get_unit("channel", name))
    views.append(sim.channels.values_array)
    return names, units, views


def _read_campaign(folder: FilePath) -> Table:
    try:
        manifest = json.loads((folder / "manifest.json").read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise _make_error(folder, f"is no folder of a campaign: {error}") from error
    if not (folder / "samples.csv").exists():
        raise _make_error(folder, "has no samples.csv yet; the campaign writes it at its end (unlatch campaign --resume)")
    table = _read_csv(folder / "samples.csv")
    return Table({name: table[name] for name in table}, table.units, manifest=manifest)


def _read_csv(path: FilePath) -> Table:
    try:
        with open(path, newline="", encoding="utf-8") as file:
            lines = csv.reader(file)
            headings: List[str] = next(lines, [])
            rows = list(lines)
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise _make_read_error(path, error) from error
    if not headings or any(len(row) != len(headings) for row in rows):
        raise _make_error(path, "is no table: its lines have not all the columns of the first one")
    _refuse_equal(path, headings)
    cells = list(zip(*rows)) if rows else [()] * len(headings)
    return _build(path, headings, [_convert(column) for column in cells])


def _read_parquet(path: FilePath) -> Table:
    try:
        import pandas

        frame = pandas.read_parquet(path)
    except ImportError as error:
        raise _make_error(path, "needs pandas and pyarrow; a campaign's folder has the same table as samples.csv") from error
    except (OSError, ValueError) as error:
        raise _make_read_error(path, error) from error
    headings = [str(name) for name in frame.columns]
    _refuse_equal(path, headings)
    return _build(path, headings, [frame.iloc[:, i].to_numpy() for i in range(len(headings))])


def _refuse_equal(path: FilePath, names: Sequence[str]) -> None:
    seen = set()
    for name in names:
        if name in seen:
            raise _make_error(path, f"has more than one column '{name}': names of columns must differ")
        seen.add(name)


def _build(path: FilePath, headings: Sequence[str], columns: Sequence[Column]) -> Table:
    parts = [_HEADING.fullmatch(heading) for heading in headings]
    names = [str(part[1]) if part else heading for part, heading in zip(parts, headings)]
    _refuse_equal(path, names)
    return Table(dict(zip(names, columns)), {name: str(part[2] or "") if part else "" for part, name in zip(parts, names)})


def _convert(cells: Sequence[str]) -> Column:
    """Converts to whole numbers, numbers (an empty cell is NaN), or text: the first kind that fits all cells."""
    try:
        return np.array([int(cell) for cell in cells], dtype=np.int64)
    except (ValueError, OverflowError):
        pass
    try:
        return np.array([float(cell) if cell else np.nan for cell in cells], dtype=np.float64)
    except ValueError:
        return np.array(cells)


def _make_read_error(path: FilePath, error: Exception) -> FileError:
    if isinstance(error, FileNotFoundError):
        return MissingFileError([Mistake(f"{os.fspath(path)}: there is no such file", os.fspath(path), 0, 0, "")])
    return _make_error(path, f"cannot be read: {error}")


def _make_error(path: FilePath, what: str) -> FileError:
    return FileError([Mistake(f"{os.fspath(path)} {what}", os.fspath(path), 0, 0, "")])
