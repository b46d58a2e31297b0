"""The linear model of a simulation about its present state."""
from typing import List, NamedTuple

import numpy as np
import numpy.typing as npt

Matrix = npt.NDArray[np.float64]


class LinearModel(NamedTuple):
    """dx/dt = A x + B u, y = C x + D u about the state at `time`, s. x: deviations of the free coordinates of the present modes, then of
    their speeds; u: of all channels; y: of all sensors' values, then of all quantities. *_error: estimated errors of the entries."""

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
