"""The linear model of a simulation about its present state."""
from typing import List, NamedTuple

import numpy as np
import numpy.typing as npt

Matrix = npt.NDArray[np.float64]


class LinearModel(NamedTuple):
    """dx/dt = A x + B u, y = C x + D u about the state at `time`, s. x: deviations of the free coordinates of the present modes, then of
    their speeds; u: of all channels; y: of all sensors' values, then of all quantities. *_error: estimated errors of the entries.
    poles: of A, 1/s, by their size. gains: the steady-state gains D - C A^-1 B, outputs by inputs; inf where the
    input moves the output without end, by a motion of a pole at 0. poles_error: estimated, 1/s, of each pole: one whose size is
    not above it is not distinct from 0."""

    time: float
    states: List[str]
    state_units: List[str]
    inputs: List[str]
    input_units: List[str]
    outputs: List[str]
    output_units: List[str]
    A: Matrix
    B: Matrix
    C: Matrix
    D: Matrix
    A_error: Matrix
    B_error: Matrix
    C_error: Matrix
    D_error: Matrix
    poles: List[complex]
    gains: Matrix
    gains_error: Matrix
    poles_error: List[float]


class LoopMargins(NamedTuple):
    """Margins of a loop, each the least over all crossings, with its frequency, rad/s; NaN without such a crossing. stable: of the closed
    loop. gain: factor above 1 that the loop's gain may grow by; drop: factor below 1 that it may fall to; phase: rad; delay: s, beside
    the loop's own."""

    stable: bool
    gain: float
    gain_frequency: float
    drop: float
    drop_frequency: float
    phase: float
    phase_frequency: float
    delay: float
    delay_frequency: float
