"""unlatch in Python: load a scenario, command it, step it, read bodies, reactions, sensors and events as NumPy arrays.

    import unlatch

    with unlatch.load("boosters/scenario.yaml") as sim:
        sim.channels["throttle1"] = 0.84
        sim.run(until=0.5)
        print(sim.time, sim.bodies["core"].position, sim.joints["nose1"].reaction)

Units are SI and radians. Attitudes are quaternions w, x, y, z, body to inertial. Arrays are read-only views of the numbers
where the simulation keeps them: they show the present state after each step, without a copy. Copy what is to be kept.
The interpreter's lock is released while the library steps; one thread at a time may use a simulation.
"""

from unlatch.batch import Batch
from unlatch.errors import (DifferenceError, Error, FaultError, FileError, Mistake, MissingFileError, MissingScenarioError, OrderError,
                            RangeError, SampleWarning, ScenarioError, StateError)
from unlatch.linear import LinearModel, LoopMargins
from unlatch.simulation import (Body, Channels, Constant, Event, Finding, Item, Joint, Number, Quantity, Simulation, Verdict, load, load_text,
                                open_recording)
from unlatch.tables import Table, read_recording, read_table
from unlatch._native import get_version as _get_version

__version__: str = _get_version()
__all__ = ["Batch", "Body", "Channels", "Constant", "DifferenceError", "Error", "Event", "FaultError", "FileError", "Finding", "Item", "Joint", "LinearModel", "LoopMargins",
           "Mistake", "MissingFileError", "MissingScenarioError", "Number", "OrderError", "Quantity", "RangeError", "SampleWarning", "ScenarioError", "Simulation", "StateError", "Table", "Verdict", "load",
           "load_text", "open_recording", "read_recording", "read_table"]
