"""Batches: many samples of one scenario, on all processors."""

from __future__ import annotations

import operator
import os
import threading
import warnings
from types import TracebackType
from typing import Dict, List, Mapping, Optional, Type

import numpy as np
import numpy.typing as npt

from unlatch import _native
from unlatch.errors import SampleWarning
from unlatch.simulation import _EVENT, _REQUIREMENT, Item, Numbers, Path, _write_overrides

_STATUS, _TICKS, _HASHES, _EVENTS, _VALUES, _MARGINS, _BODIES = range(7)


class Batch:
    """Samples of a scenario, each with its own overrides; a context manager.

        with unlatch.Batch("boosters/reference.yaml", judge=True) as batch:
            for mass in np.linspace(95e3, 105e3, 11):
                batch.add({"bodies.core.mass": mass})
            batch.run()
            print(batch.margins["distance1"])

    With `judge` requirements are judged, and samples that the step does not resolve are found. Results are views by sample;
    adding samples while views are held raises BufferError."""

    def __init__(self, path: Path, overrides: Optional[Mapping[str, object]] = None, *, judge: bool = False) -> None:
        self._native = _native.Batch(os.fspath(path), _write_overrides(overrides), judge)
        self._requirements = [Item(*item) for item in self._native.list(_REQUIREMENT)]
        self._events = [Item(*item) for item in self._native.list(_EVENT)]

    def __enter__(self) -> Batch:
        return self

    def __exit__(self, kind: Optional[Type[BaseException]], error: Optional[BaseException], trace: Optional[TracebackType]) -> None:
        self.close()

    def close(self) -> None:
        """Frees the batch; the memory of results stays as long as arrays refer to it."""
        self._native.close()

    def add(self, overrides: Optional[Mapping[str, object]] = None) -> None:
        """Adds a sample."""
        self._native.add(_write_overrides(overrides))

    def run(self, until: float = 0, threads: int = 0) -> None:
        """Runs all samples that have not been run, to `until` s (0: the end that the scenario gives). threads 0: one on each processor.
        After Ctrl-C another call continues. A SampleWarning names the samples without results: faulted, invalid or unresolved.
        Without `judge` nothing looks at what the step resolves, and no sample is unresolved."""
        until, threads = float(until), operator.index(threads)
        failure: List[BaseException] = []
        done = threading.Event()

        def work() -> None:
            try:
                self._native.run(until, threads)
            except BaseException as error:  # is raised below
                failure.append(error)
            finally:
                done.set()

        # Signals are handled by the main thread, so it must not wait inside the library. Nor in Thread.join(): where Ctrl-C interrupts
        # that, Python 3.11 takes the thread for ended while it works on (bpo-45274).
        threading.Thread(target=work).start()
        try:
            while not done.wait(0.05):
                pass
        except BaseException:
            self._native.interrupt()
            while not done.is_set():
                try:
                    done.wait(0.05)
                except KeyboardInterrupt:  # pressed again: the samples in flight end by themselves
                    pass
            raise
        if failure:
            raise failure[0]
        lost = np.flatnonzero(~self.ok)
        if len(lost):
            named = "; ".join(f"sample {i}: {self.why(int(i))}" for i in lost[:3])
            more = f"; and {len(lost) - 3} more" if len(lost) > 3 else ""
            warnings.warn(f"{len(lost)} of {len(self.ok)} samples have no results: {named}{more}", SampleWarning, stacklevel=2)

    @property
    def ok(self) -> npt.NDArray[np.bool_]:
        """Samples that ran to their end and, with `judge`, were resolved by the step; shape (samples,)."""
        return np.asarray(self._native.get_array(_STATUS) == 0)

    @property
    def ticks(self) -> npt.NDArray[np.int64]:
        """Ticks made by each sample."""
        return self._native.get_array(_TICKS)

    @property
    def hashes(self) -> List[str]:
        """Hash of the last state of each sample."""
        return [f"{int(value) & 0xFFFFFFFFFFFFFFFF:016x}" for value in self._native.get_array(_HASHES)]

    @property
    def event_times(self) -> Dict[str, Numbers]:
        """Time at which each event acted first, s, by "name:subject"; NaN: never."""
        return self._by_column([e.name + (":" + e.text if e.text else "") for e in self._events], _EVENTS)

    @property
    def values(self) -> Dict[str, Numbers]:
        """Value of each requirement, in its unit; NaN: not evaluated. Needs judge=True."""
        return self._by_column([r.name for r in self._requirements], _VALUES)

    @property
    def margins(self) -> Dict[str, Numbers]:
        """Margin of each requirement, in its unit; below 0: not met. Needs judge=True."""
        return self._by_column([r.name for r in self._requirements], _MARGINS)

    @property
    def final_bodies(self) -> Numbers:
        """Final states; shape (samples, bodies, 13): position (m), attitude, velocity (m/s), angular velocity (rad/s)."""
        numbers = self._native.get_array(_BODIES)
        return numbers.reshape(len(numbers), -1, 13)

    def why(self, sample: int) -> str:
        """Reason of a sample's failure; "" if it did not fail."""
        return self._native.get_text(sample)

    def _by_column(self, names: List[str], which: int) -> Dict[str, Numbers]:
        numbers = self._native.get_array(which)
        if numbers.ndim == 1:
            numbers = numbers.reshape(-1, 1)
        return {name: numbers[:, i] for i, name in enumerate(names)}
