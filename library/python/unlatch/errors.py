"""Exceptions, with the place of a mistake."""

from __future__ import annotations

from typing import List, NamedTuple, Sequence, Tuple


class Mistake(NamedTuple):
    """One mistake: the fault, its correction, and its place."""

    text: str
    file: str
    line: int
    column: int
    key: str


class Error(Exception):
    """A failed call of the library. file, line, column and key are those of the first mistake; 0 and "" if it has none."""

    def __init__(self, mistakes: Sequence[Mistake]) -> None:
        super().__init__("\n".join(mistake.text for mistake in mistakes))
        self.mistakes = list(mistakes)

    def __reduce__(self) -> Tuple[type, Tuple[List[Mistake]]]:
        return type(self), (self.mistakes,)

    @property
    def file(self) -> str:
        """Of the first mistake, as given; "" if it does not concern a file."""
        return self.mistakes[0].file if self.mistakes else ""

    @property
    def line(self) -> int:
        """Of the first mistake, from 1; 0: the file as a whole."""
        return self.mistakes[0].line if self.mistakes else 0

    @property
    def column(self) -> int:
        """Of the first mistake, from 1; 0: the line as a whole."""
        return self.mistakes[0].column if self.mistakes else 0

    @property
    def key(self) -> str:
        """Of the first mistake in the scenario: "bodies.core.mass"; "" if it does not concern one."""
        return self.mistakes[0].key if self.mistakes else ""


class ScenarioError(Error, ValueError):
    """Mistakes in a scenario or its overrides, all of them in `mistakes`."""


class FileError(Error, OSError):
    """A file that cannot be read or written, or has the wrong contents."""

    def __str__(self) -> str:
        return "\n".join(mistake.text for mistake in self.mistakes)


class MissingFileError(FileError, FileNotFoundError):
    """A file that does not exist."""


class MissingScenarioError(ScenarioError, FileNotFoundError):
    """A scenario file, or one that it includes, that does not exist."""

    def __str__(self) -> str:
        return "\n".join(mistake.text for mistake in self.mistakes)


class SampleWarning(UserWarning):
    """Samples of a batch that have no results: Batch.run() names them."""


class RangeError(Error, ValueError):
    """A value, index or tick outside its range."""


class FaultError(Error):
    """A step that cannot be made; the simulation keeps its last good state."""


class OrderError(Error):
    """A call that is not possible now: closed, in use by another thread, recording, replaying, or loaded without judge=True."""


class StateError(Error, ValueError):
    """Bytes that are no state of this model."""


class DifferenceError(Error):
    """A replay differs from its recording."""


_KINDS = {-2: OrderError, -3: OrderError, -4: ScenarioError, -5: FileError, -6: RangeError, -7: FaultError, -8: OrderError,
          -9: StateError, -10: DifferenceError}


def make(status: int, mistakes: Sequence[tuple[str, str, int, int, str]]) -> Error:
    """Returns the exception of a status of the C library."""
    kind = _KINDS.get(status, Error)
    listed = [Mistake(*mistake) for mistake in mistakes]
    first = listed[0].text if listed else ""
    if kind is ScenarioError and "there is no such file" in first:
        kind = MissingScenarioError
    if kind is FileError and "No such file or directory" in first:
        kind = MissingFileError
    return kind(listed)
