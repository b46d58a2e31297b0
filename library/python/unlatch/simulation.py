"""Simulations."""

from __future__ import annotations

import math
import os
import time as _time
from types import TracebackType
from typing import Callable, Generic, Iterator, List, Mapping, MutableMapping, NamedTuple, Optional, Sequence, Type, TypeVar, Union

import numpy as np
import numpy.typing as npt

from unlatch import _native
from unlatch.linear import LinearModel, LoopMargins

Path = Union[str, "os.PathLike[str]"]
Numbers = npt.NDArray[np.float64]
Value = TypeVar("Value")

# Kinds of items and arrays of unlatch.h.
_BODY, _JOINT, _CHANNEL, _SENSOR, _SIGNAL, _EVENT, _REQUIREMENT, _CLEARANCE, _QUANTITY, _CONSTANT, _NUMBER = range(11)
_KINDS = ("body", "joint", "channel", "sensor", "signal", "event", "requirement", "clearance", "quantity", "constant", "number")
(_POSITIONS, _ATTITUDES, _VELOCITIES, _ANGULAR_VELOCITIES, _MODAL, _JOINT_MODES, _REACTIONS, _SENSORS, _SIGNALS, _CHANNELS,
 _CLEARANCES, _RECEIVED) = range(12)
_STATUS_END = 2
_JUDGE, _NOTICE = 1, 2
_LOOK = 0.02  # s of wall time after which run() checks for signals such as Ctrl-C


class Item(NamedTuple):
    """A part of the scenario. unit: of its values, SI. minimum, maximum: of a channel; the limits of a requirement."""

    name: str
    unit: str
    text: str
    first: int
    width: int
    a: int
    b: int
    initial: float
    minimum: float
    maximum: float
    safe: float


class Event(NamedTuple):
    """An event that acted at `time` (s), in the step that began at `tick`."""

    time: float
    name: str
    subject: str
    tick: int


class Quantity(NamedTuple):
    """A quantity for requirements. unit: SI, "" for a plain number; text: its text in a requirement."""

    unit: str
    text: str


class Constant(NamedTuple):
    """A constant of the scenario, in SI; unit "" for a plain number. The override constants.NAME sets it."""

    value: float
    unit: str


class Number(NamedTuple):
    """A literal number of the scenario, in `unit` (SI, "" for a plain number). The override PATH=VALUE sets it."""

    value: float
    unit: str


class Verdict(NamedTuple):
    """The verdict on a requirement: value, limit and margin in `unit`, time of the value in s; why: the reason if not evaluated.
    uncertainty: how far it may be wrong, between steps and by their errors, in `unit`; inf: not known, since the step does not resolve what it
    depends on. at_ticks: the value is that of a tick or an event, and may be beyond it in between."""

    id: str
    unit: str
    evaluated: bool
    met: bool
    value: float
    limit: float
    margin: float
    time: float
    why: str
    uncertainty: float = 0.0
    at_ticks: bool = False


class Finding(NamedTuple):
    """A fact to know before one trusts the results. name: its kind, "contact"; subject: of the run, name of the body, element, joint;
    else the part of the scenario. of_run: noticed at a step, first at `time`, with its worst value at `worst_time`, s. unresolved:
    results that depend on its subject are no results."""

    name: str
    subject: str
    text: str
    of_run: bool
    unresolved: bool
    time: float
    worst_time: float


class Named(Mapping[str, Value], Generic[Value]):
    """Items by their names, in the scenario's order."""

    def __init__(self, names: Sequence[str], values: Sequence[Value], what: str) -> None:
        self._values = dict(zip(names, values))
        self._what = what

    def __getitem__(self, name: str) -> Value:
        try:
            return self._values[name]
        except KeyError:
            raise KeyError(f"no {self._what} '{name}'; known: {', '.join(self._values)}") from None

    def __iter__(self) -> Iterator[str]:
        return iter(self._values)

    def __len__(self) -> int:
        return len(self._values)


class Body:
    """A body. Arrays are views of its present state."""

    def __init__(self, native: _native.Simulation, name: str, index: int) -> None:
        self.name = name
        #: position of its origin, inertial frame, m; shape (3,)
        self.position: Numbers = native.get_array(_POSITIONS, 0)[index]
        #: attitude, quaternion w, x, y, z, body to inertial; shape (4,)
        self.attitude: Numbers = native.get_array(_ATTITUDES, 0)[index]
        #: velocity of its origin, inertial axes, m/s; shape (3,)
        self.velocity: Numbers = native.get_array(_VELOCITIES, 0)[index]
        #: angular velocity, body axes, rad/s; shape (3,)
        self.angular_velocity: Numbers = native.get_array(_ANGULAR_VELOCITIES, 0)[index]
        #: modal coordinates of a flexible body; shape (modes,), empty for a rigid one
        self.modal_coordinates: Numbers = native.get_array(_MODAL, index).reshape(-1)

    def __repr__(self) -> str:
        return f"Body({self.name!r}, position={self.position} m)"


class Joint:
    """A joint."""

    def __init__(self, native: _native.Simulation, item: Item, index: int) -> None:
        self.name = item.name
        #: names of its modes
        self.modes: List[str] = [native.get_mode_name(index, mode) for mode in range(item.width)]
        self._mode = native.get_array(_JOINT_MODES, 0)[index:index + 1]
        #: reaction on the follower: rows x, y, z, rot_x, rot_y, rot_z, N and N m, 0 for rows that do not hold; a view, shape (6,)
        self.reaction: Numbers = native.get_array(_REACTIONS, index)[0]

    @property
    def mode(self) -> str:
        """Name of the present mode."""
        return self.modes[int(self._mode[0])]

    def __repr__(self) -> str:
        return f"Joint({self.name!r}, mode={self.mode!r})"


class Channels(MutableMapping[str, float]):
    """Commands by their names: reading returns the commanded value, setting it takes effect from the next step on.

    A value outside the channel's range raises RangeError."""

    def __init__(self, native: _native.Simulation, items: Sequence[Item]) -> None:
        self._native = native
        self._index = {item.name: i for i, item in enumerate(items)}
        #: all values in the scenario's order; a view
        self.values_array: Numbers = native.get_array(_CHANNELS, 0)

    def find(self, name: str) -> int:
        """Number of the channel. KeyError lists the known names."""
        try:
            return self._index[name]
        except KeyError:
            raise KeyError(f"no channel '{name}'; known: {', '.join(self._index)}") from None

    def __getitem__(self, name: str) -> float:
        return float(self.values_array[self.find(name)])

    def __setitem__(self, name: str, value: float) -> None:
        self._native.set_channel(self.find(name), value)

    def __delitem__(self, name: str) -> None:
        raise TypeError("a channel cannot be deleted")

    def __iter__(self) -> Iterator[str]:
        return iter(self._index)

    def __len__(self) -> int:
        return len(self._index)


class Simulation:
    """One run of a scenario. Made by load(), load_text() and open_recording(); a context manager that closes itself."""

    def __init__(self, native: _native.Simulation) -> None:
        self._native = native
        #: one tick; raises FaultError if it cannot be made, StopIteration at the end of a recording
        self.step: Callable[[], None] = native.step
        #: name of the scenario; its step and the end of its run, s
        self.name, self.dt, self.until = native.get_scenario()
        self._items = [[Item(*item) for item in native.list(kind)] for kind in range(_NUMBER + 1)]
        bodies, joints = self._items[_BODY], self._items[_JOINT]
        #: bodies by name
        self.bodies = Named([b.name for b in bodies], [Body(native, b.name, i) for i, b in enumerate(bodies)], "body")
        #: joints by name
        self.joints = Named([j.name for j in joints], [Joint(native, j, i) for i, j in enumerate(joints)], "joint")
        #: commands by name
        self.channels = Channels(native, self._items[_CHANNEL])
        values = native.get_array(_SENSORS, 0)
        sensors = self._items[_SENSOR]
        #: sensors by name: views of their values as last sampled, with the sensors' errors and held between samples, in the unit of the sensor
        self.sensors = Named([s.name for s in sensors], [values[s.first:s.first + s.width] for s in sensors], "sensor")
        received = native.get_array(_RECEIVED, 0)
        #: the same as flight software received them, where a session is replayed: faults distort them, States are dropped or late
        self.received = Named([s.name for s in sensors] if len(received) > 0 else [],
                              [received[s.first:s.first + s.width] for s in sensors] if len(received) > 0 else [], "received sensor")
        signals = native.get_array(_SIGNALS, 0)
        #: signals by name: views of one value
        self.signals = Named([s.name for s in self._items[_SIGNAL]], [signals[i:i + 1] for i in range(len(signals))], "signal")

        quantities, constants = self._items[_QUANTITY], self._items[_CONSTANT]
        #: quantities for requirements, by name: "reaction.nose1.x"
        self.quantities = Named([q.name for q in quantities], [Quantity(q.unit, q.text) for q in quantities], "quantity")
        #: the scenario's own constants by name
        self.constants = Named([c.name for c in constants], [Constant(c.initial, c.unit) for c in constants], "constant")
        numbers = self._items[_NUMBER]
        #: literal numbers of the scenario, by the path of their override: "bodies.core.mass"
        self.numbers = Named([n.name for n in numbers], [Number(n.initial, n.unit) for n in numbers], "number")

    def get_unit(self, kind: str, name: str) -> str:
        """Unit of the values of "channel", "sensor", "requirement", "clearance", "quantity", "constant" or "number" `name`; "" if it has none."""
        items = self._items[_KINDS.index(kind)]
        return Named([item.name for item in items], [item.unit for item in items], kind)[name]

    def __enter__(self) -> Simulation:
        return self

    def __exit__(self, kind: Optional[Type[BaseException]], error: Optional[BaseException], trace: Optional[TracebackType]) -> None:
        self.close()

    def close(self) -> None:
        """Ends a recording and frees the simulation; its memory stays as long as arrays refer to it."""
        self._native.close()

    def __repr__(self) -> str:
        if self._native.is_closed():
            return f"Simulation({self.name!r}, closed)"
        return f"Simulation({self.name!r}, t={self.time:g} s)"

    # --- Lists

    @property
    def channel_items(self) -> List[Item]:
        """Names, units and ranges of the channels."""
        return list(self._items[_CHANNEL])

    @property
    def sensor_items(self) -> List[Item]:
        """Names and units of the sensors."""
        return list(self._items[_SENSOR])

    @property
    def requirement_items(self) -> List[Item]:
        """Names, units and limits of the requirements."""
        return list(self._items[_REQUIREMENT])

    # --- Steps

    def run(self, until: Optional[float] = None, *, ticks: Optional[int] = None, stop_at_events: bool = False) -> int:
        """Steps to the time `until` (s; default: the end that the scenario gives), or `ticks` ticks; returns the ticks made.

        Ends earlier after a tick with events if stop_at_events, and at the end of a recording. Signals such as Ctrl-C are
        handled meanwhile; the simulation may continue after a KeyboardInterrupt."""
        if ticks is None:
            end = self.until if until is None else until
            if not math.isfinite(end):
                raise ValueError("until is not finite")
            ticks = round(end / self.dt) - self.tick
        elif until is not None:
            raise ValueError("give until or ticks, not both")
        if ticks < 0:
            raise ValueError("that time is over; load the scenario anew, or reset()")
        made, chunk = 0, 64
        while made < ticks:
            began = _time.perf_counter()
            status, done = self._native.advance(min(chunk, ticks - made), stop_at_events)
            made += done
            if status != 0:
                break
            if _time.perf_counter() - began < _LOOK / 2:
                chunk *= 2
        return made

    @property
    def tick(self) -> int:
        """Number of the present state, 0 at the start."""
        return self._native.get_tick()

    @property
    def time(self) -> float:
        """Time of the present state, s."""
        return self._native.get_time()

    @property
    def hash(self) -> str:
        """Hash of every bit of the present state, as `unlatch run` prints it."""
        return f"{self._native.get_hash():016x}"

    # --- Results

    @property
    def events(self) -> List[Event]:
        """Events so far, in the order in which they acted."""
        kinds = self._items[_EVENT]
        return [Event(time, kinds[event].name, kinds[event].text, tick) for time, tick, event in self._native.get_events(0)[0]]

    @property
    def lost_events(self) -> int:
        """Events beyond event_capacity, which are not in `events`."""
        return int(self._native.get_events(0)[1])

    @property
    def verdicts(self) -> List[Verdict]:
        """Verdicts on the requirements so far. OrderError without load(..., judge=True)."""
        return [Verdict(item.name, item.unit, *verdict)
                for item, verdict in zip(self._items[_REQUIREMENT], self._native.judge())]

    @property
    def findings(self) -> List[Finding]:
        """Findings about the scenario, as `unlatch check` prints them, and with load(..., judge=True) or notice=True those about the
        run so far. The first call may take as long as some hundred steps."""
        return [Finding(*finding) for finding in self._native.get_findings()]

    def linearize(self) -> LinearModel:
        """Linearises about the present state; the state does not change. Raises FaultError where a pivot vanishes."""
        return LinearModel(*self._native.linearize())

    def calc_margins(self, loop: str, period: float = 0, delay: float = 0) -> LoopMargins:
        """Margins of negative feedback around the latest linearize(): loop "torque=12*sensor.angle+30*sensor.gyro.z", sampled and held each
        `period` (s, 0: continuous), `delay` late (s). OrderError before linearize(); Error for a loop that cannot be read or names what the model has not."""
        return LoopMargins(*self._native.calc_margins(loop, period, delay))

    @property
    def clearances(self) -> Named[Numbers]:
        """Distances of the watched pairs, "core – booster1", m: views of one value. OrderError without judge=True."""
        values = self._native.get_array(_CLEARANCES, 0)
        return Named([item.name for item in self._items[_CLEARANCE]], [values[i:i + 1] for i in range(len(values))], "pair")

    # --- States and recordings

    def save(self) -> bytes:
        """Returns all data that determine the further run."""
        return self._native.save()

    def restore(self, state: bytes) -> None:
        """Restores a saved state of this scenario. Events and verdicts begin anew there."""
        self._native.restore(state)

    def reset(self) -> None:
        """Returns to the state at which it was loaded."""
        self._native.reset()

    def start_recording(self, path: Path) -> None:
        """Records from now on, for `unlatch replay`, `report`, `export`, and open_recording()."""
        self._native.start_recording(os.fspath(path))

    def stop_recording(self) -> None:
        """Completes the recording. FileError if it could not be written."""
        self._native.stop_recording()


def load(path: Path, overrides: Optional[Mapping[str, object]] = None, *, judge: bool = False, notice: bool = False,
         event_capacity: int = 4096) -> Simulation:
    """Loads a scenario. overrides: {"bodies.core.mass": "99 t"}, as --set takes them. judge: requirements are judged and clearances
    computed at each step, which costs several times the step. notice: what the step does not resolve is noticed, see `findings`; judge
    does so too. event_capacity: number of stored events. Raises ScenarioError."""
    return Simulation(_native.load(os.fspath(path), _write_overrides(overrides), _get_flags(judge, notice), event_capacity))


def load_text(text: str, name: str = "<text>", overrides: Optional[Mapping[str, object]] = None, *, judge: bool = False,
              notice: bool = False, event_capacity: int = 4096) -> Simulation:
    """Loads a scenario from a text. name: name of the text in messages."""
    return Simulation(_native.load_text(text, name, _write_overrides(overrides), _get_flags(judge, notice), event_capacity))


def open_recording(path: Path, *, judge: bool = False, notice: bool = False, event_capacity: int = 4096) -> Simulation:
    """Opens a recording (*.log) of `unlatch hil`, `unlatch run` or start_recording(). Its steps take the recorded commands and are
    compared with the recorded hashes; step() raises StopIteration at the end, run() returns."""
    return Simulation(_native.open_recording(os.fspath(path), _get_flags(judge, notice), event_capacity))


def _get_flags(judge: bool, notice: bool) -> int:
    return (_JUDGE if judge else 0) | (_NOTICE if notice else 0)


def _write_overrides(overrides: Optional[Mapping[str, object]]) -> List[str]:
    if overrides is None:
        return []
    if not isinstance(overrides, Mapping):
        raise TypeError(f"overrides are a mapping of paths to values, not {type(overrides).__name__}")
    return [f"{path}={_write(value)}" for path, value in overrides.items()]


def _write(value: object) -> str:
    if isinstance(value, (bool, np.bool_)):
        return "true" if value else "false"
    if isinstance(value, (float, np.floating)):
        return repr(float(value))
    if isinstance(value, np.integer):
        return str(int(value))
    if isinstance(value, (list, tuple, np.ndarray)):
        return "[" + ", ".join(_write(part) for part in value) + "]"
    return str(value)
