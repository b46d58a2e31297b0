#!/usr/bin/env python3
"""FMUs: a test importer calls every function of FMI 2.0 and 3.0, in the right and in the wrong order.

    fmu_test.py BIN_FOLDER SOURCE_FOLDER [unittest options]
"""
import ctypes
import locale
import math
import os
import re
import subprocess
import sys
import xml.etree.ElementTree as ElementTree
import zipfile
from concurrent.futures import ThreadPoolExecutor
from ctypes import byref, c_bool, c_char_p, c_double, c_int, c_size_t, c_uint32, c_uint8, c_void_p
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from fmi_rules import list_faults  # noqa: E402
from processes import BIN, BOOSTERS, FLIGHT, REFERENCE, SANITIZED, SCENARIOS, UNLATCH, ProcessTest, main  # noqa: E402

if SANITIZED:
    sys.exit(77)  # Python itself would need the sanitizer
sys.path.insert(0, str(BIN.parent / "python"))
import unlatch  # noqa: E402

if "UNLATCH_LOCALE" in os.environ:
    locale.setlocale(locale.LC_ALL, os.environ["UNLATCH_LOCALE"])  # of the host: comma_locale.sh

OK, WARNING, ERROR = 0, 1, 3
PROBE = """unlatch: 1
name: probe
step: {dt: 0.001, until: 0.5}
constants: {load: 100 kg, push: 5 kN}
bodies:
  probe: {mass: load, inertia: [10, 20, 25]}
channels:
  throttle: {initial: 0, range: [0, 1], safe: 0}
elements:
  engine: {type: thrust, body: probe, direction: [1, 0, 0], profile: push, channel: throttle}
"""
# An impulse of 4 N s within a millisecond, at a step of 5 ms.
PULSE = """unlatch: 1
name: pulse
step: {dt: 5 ms, until: 2 s}
bodies:
  lid: {mass: 4 kg, inertia: [1, 1, 1]}
elements:
  pyro: {type: force, body: lid, frame: world, direction: [1, 0, 0], profile: {table: {times: [0, 1.0011, 1.0012, 1.0013, 1.0014, 1.0015, 1.0016, 1.0017, 1.0018, 1.0019, 1.002, 1.0021, 2], values: [0, 0, 1.6 kN, 3.2 kN, 4.8 kN, 6.4 kN, 8 kN, 6.4 kN, 4.8 kN, 3.2 kN, 1.6 kN, 0, 0]}}}
"""
LOG = ctypes.CFUNCTYPE(None, c_void_p, c_int, c_char_p, c_char_p)
SEQUENCE = {100: ("throttle", 0.84), 250: ("verniers", 0), 300: ("rudder", 0), 450: ("cut_ties", 1), 500: ("cutoff", 1)}
TYPES = "Float32 Int8 UInt8 Int16 UInt16 Int32 UInt32 Int64 UInt64 Boolean String Binary"
ALL = {
    3: [f"{access}{kind}" for access in ("Get", "Set") for kind in (TYPES + " Float64 Clock").split()] + """GetVersion SetDebugLogging
    InstantiateModelExchange InstantiateCoSimulation InstantiateScheduledExecution FreeInstance EnterInitializationMode ExitInitializationMode
    EnterEventMode Terminate Reset GetNumberOfVariableDependencies GetVariableDependencies GetFMUState SetFMUState FreeFMUState
    SerializedFMUStateSize SerializeFMUState DeserializeFMUState GetDirectionalDerivative GetAdjointDerivative EnterConfigurationMode
    ExitConfigurationMode GetIntervalDecimal GetIntervalFraction GetShiftDecimal GetShiftFraction SetIntervalDecimal SetIntervalFraction
    SetShiftDecimal SetShiftFraction EvaluateDiscreteStates UpdateDiscreteStates EnterContinuousTimeMode CompletedIntegratorStep SetTime
    SetContinuousStates GetContinuousStateDerivatives GetEventIndicators GetContinuousStates GetNominalsOfContinuousStates
    GetNumberOfEventIndicators GetNumberOfContinuousStates EnterStepMode GetOutputDerivatives DoStep ActivateModelPartition""".split(),
    2: """GetTypesPlatform GetVersion SetDebugLogging Instantiate FreeInstance SetupExperiment EnterInitializationMode ExitInitializationMode
    Terminate Reset GetReal GetInteger GetBoolean GetString SetReal SetInteger SetBoolean SetString GetFMUstate SetFMUstate FreeFMUstate
    SerializedFMUstateSize SerializeFMUstate DeSerializeFMUstate GetDirectionalDerivative SetRealInputDerivatives GetRealOutputDerivatives
    DoStep CancelStep GetStatus GetRealStatus GetIntegerStatus GetBooleanStatus GetStringStatus""".split()}


class Callbacks(ctypes.Structure):
    _fields_ = [(name, c_void_p) for name in ("logger", "allocate", "release", "step_finished", "environment")]


class Fmu:
    """An instance of an unpacked FMU, of either version."""

    def __init__(self, folder, version, token=None, event_mode=False, early_return=False, scheme="file:"):
        self.version = version
        self.description = ElementTree.parse(folder / "modelDescription.xml").getroot()
        variables = self.description.find("ModelVariables")
        self.references = {variable.get("name"): int(variable.get("valueReference")) for variable in variables}
        identifier = self.description.find("CoSimulation").get("modelIdentifier")
        platform = next((folder / "binaries").iterdir())
        self.library = ctypes.CDLL(str(platform / f"{identifier}.so"))
        token = token or self.description.get("instantiationToken" if version == 3 else "guid")
        self.messages = []
        self.log = LOG(lambda environment, status, category, message: self.messages.append(message.decode()))
        if version == 3:
            make = self.library.fmi3InstantiateCoSimulation
            make.restype, make.argtypes = c_void_p, [c_char_p, c_char_p, c_char_p, c_bool, c_bool, c_bool, c_bool, c_void_p, c_size_t,
                                                     c_void_p, LOG, c_void_p]
            self.instance = make(b"one", token.encode(), f"{folder}/resources/".encode(), False, True, event_mode, early_return, None, 0, None,
                                 self.log, None)
        else:
            make = self.library.fmi2Instantiate
            make.restype, make.argtypes = c_void_p, [c_char_p, c_int, c_char_p, c_char_p, c_void_p, c_int, c_int]
            self.callbacks = Callbacks()
            uri = (folder / "resources").as_uri().replace("file:", scheme).encode()
            self.instance = make(b"one", 1, token.encode(), uri, byref(self.callbacks), 0, 0)

    def call(self, name, *arguments):
        function = getattr(self.library, f"fmi{self.version}{name}")
        return function(c_void_p(self.instance), *arguments)

    def begin(self, start=0.0):
        if self.version == 3:
            entered = self.call("EnterInitializationMode", c_bool(False), c_double(0), c_double(start), c_bool(False), c_double(0))
        else:
            entered = self.call("SetupExperiment", c_int(0), c_double(0), c_double(start), c_int(0), c_double(0)) or \
                self.call("EnterInitializationMode")
        return entered or self.call("ExitInitializationMode")

    def access(self, name, reference, value=0.0):
        """Returns (status, value)."""
        references, values = (c_uint32 * 1)(reference), (c_double * 1)(value)
        kind = "Float64" if self.version == 3 else "Real"
        more = [c_size_t(1)] if self.version == 3 else []
        return self.call(name + kind, references, c_size_t(1), values, *more), values[0]

    def get(self, name):
        status, value = self.access("Get", self.references[name])
        assert status == OK, self.messages
        return value

    def set(self, name, value):
        return self.access("Set", self.references[name], value)[0]

    def step(self, time, size):
        """Returns (status, event needed, early, last time)."""
        if self.version == 2:
            return self.call("DoStep", c_double(time), c_double(size), c_int(1)), False, False, time + size
        event, terminate, early, last = c_bool(), c_bool(), c_bool(), c_double()
        status = self.call("DoStep", c_double(time), c_double(size), c_bool(True), byref(event), byref(terminate), byref(early), byref(last))
        return status, event.value, early.value, last.value

    def state_name(self, name):
        return name if self.version == 3 else name.replace("FMUState", "FMUstate").replace("Deserialize", "DeSerialize")

    def save(self):
        """Returns (state, its bytes)."""
        state, size = c_void_p(), c_size_t()
        assert self.call(self.state_name("GetFMUState"), byref(state)) == OK
        assert self.call(self.state_name("SerializedFMUStateSize"), state, byref(size)) == OK
        data = (c_uint8 * size.value)()
        assert self.call(self.state_name("SerializeFMUState"), state, data, size) == OK
        return state, bytes(data)

    def free(self):
        if self.instance:
            free = getattr(self.library, f"fmi{self.version}FreeInstance")
            free.restype = None
            free(c_void_p(self.instance))


class FmuTest(ProcessTest):
    def unpack(self, version, scenario=BOOSTERS, *more):
        folder = self.folder / f"fmu {version} {Path(scenario).stem}"  # a blank in the path, as on users' machines
        if not folder.exists():
            file = self.folder / f"{version}.fmu"
            self.run_ok(UNLATCH, "export", scenario, "--fmu", file, "--fmi", version, *more)
            with zipfile.ZipFile(file) as archive:
                self.assertIsNone(archive.testzip())
                archive.extractall(folder)
        return folder

    def open(self, version, scenario=BOOSTERS, **options):
        fmu = Fmu(self.unpack(version, scenario), version, **options)
        self.addCleanup(fmu.free)
        return fmu

    def read_hash(self, fmu, scenario):
        """A state of an FMU contains one of the C library, its parameters, its mode; `scenario` has all of them."""
        state, data = fmu.save()
        self.assertEqual(fmu.call(fmu.state_name("FreeFMUState"), byref(state)), OK)
        parameters = [v for v in fmu.description.find("ModelVariables").iter() if v.get("causality") == "parameter"]
        with unlatch.load(scenario) as sim:
            sim.restore(data[:len(data) - 1 - 8 * len(parameters)])
            return sim.hash

    def test_every_pair_of_shapes_has_a_distance_of_its_own_name(self):
        scenario = self.folder / "pairs.yaml"
        ball = "mass: 1, inertia: [1, 1, 1]"
        scenario.write_text(f"""unlatch: 1
name: pairs
step: {{dt: 1 ms, until: 0.05}}
bodies:
  a: {{{ball}, shape: [{{name: s, sphere: {{radius: 0.5}}}}, {{name: t, sphere: {{centre: [0, 0, 3], radius: 0.5}}}}]}}
  b: {{{ball}, position: [0.75, 0, 0], shape: [{{sphere: {{radius: 0.5}}}}]}}
clearance: [[a.s, b], [a.t, b], [a, b]]
""")
        for version in (2, 3):
            fmu = self.open(version, scenario)
            variables = list(fmu.description.find("ModelVariables"))
            self.assertEqual(len({v.get("name") for v in variables}), len(variables))
            self.assertIn("signed distance of a.s – b", {v.get("description") for v in variables if v.get("name") == "clearances.a.s.b"}.pop())
            self.assertEqual(fmu.begin(), OK)
            self.assertEqual(fmu.step(0.0, 0.001)[0], OK)
            self.assertEqual([round(fmu.get(f"clearances.{pair}"), 9) for pair in ("a.s.b", "a.b")], [-0.25, -0.25])
            self.assertAlmostEqual(fmu.get("clearances.a.t.b"), math.hypot(3, 0.75) - 1)

    def separate(self, version):
        session = self.run_json(UNLATCH, "hil", BOOSTERS, "--transport", "inproc", "--pace", "lockstep", "--until", "2", code=None)
        fmu = self.open(version)
        self.assertEqual(fmu.begin(), OK)
        contact = {}
        for tick in range(2000):
            name, value = SEQUENCE.get(tick, ("", 0))
            for variable in fmu.references:
                if name and re.fullmatch(rf"channels\.{name}[1-4]?", variable):
                    self.assertEqual(fmu.set(variable, value), OK)
            for i in "1234":
                if i not in contact and fmu.get(f"sensors.kr{i}") > 0.5:
                    contact[i] = tick
                if tick == contact.get(i, tick) + 12:
                    self.assertEqual(fmu.set(f"channels.nozzle{i}", 1), OK)
            self.assertEqual(fmu.step(tick * 0.001, 0.001)[0], OK, fmu.messages)
        self.assertEqual(len(contact), 4)
        self.assertEqual(fmu.get("time"), 2.0)
        self.assertGreater(fmu.get("clearances.core.booster1"), 0.1)
        self.assertEqual(self.read_hash(fmu, BOOSTERS), session["hash"])
        self.assertEqual(fmu.call("Terminate"), OK)

    def test_fmi_3_separates_the_boosters_to_the_hash_of_a_session(self):
        self.separate(3)

    def test_fmi_2_separates_the_boosters_to_the_hash_of_a_session(self):
        self.separate(2)

    def test_a_run_has_the_hash_of_unlatch_run_at_any_communication_step(self):
        wanted = self.run_json(UNLATCH, "run", REFERENCE, "--until", "0.9", code=None)["hash"]
        for version, step in ((3, 0.9), (3, 0.03), (2, 0.1)):
            fmu = self.open(version, REFERENCE)
            self.assertEqual(fmu.begin(), OK)
            time = 0.0
            for _ in range(round(0.9 / step)):
                self.assertEqual(fmu.step(time, step)[0], OK, fmu.messages)
                time += step  # a running sum, as in importers
            self.assertEqual(self.read_hash(fmu, REFERENCE), wanted)

    def test_every_function_of_the_standards_is_there(self):
        for version, names in ALL.items():
            fmu = self.open(version)
            for name in names:
                self.assertTrue(hasattr(fmu.library, f"fmi{version}{name}"), name)
            version_of = getattr(fmu.library, f"fmi{version}GetVersion")
            version_of.restype = c_char_p
            self.assertEqual(version_of(), f"{version}.0".encode())
        exported = {name for name in self.run_ok("nm", "-D", "--defined-only", next((self.unpack(3) / "binaries").glob("*/unlatch_*.so")))
                    .stdout.split() if name.startswith("fmi")}
        self.assertEqual(exported, {f"fmi{version}{name}" for version, names in ALL.items() for name in names})

    def test_a_step_returns_early_at_events_if_the_importer_wants_it(self):
        fmu = self.open(3, REFERENCE, event_mode=True, early_return=True)
        self.assertEqual(fmu.begin(), OK)
        self.assertEqual(fmu.call("EnterStepMode"), OK)
        status, event, early, last = fmu.step(0.0, 0.9)
        self.assertEqual((status, event, early), (OK, True, True))
        with unlatch.load(REFERENCE) as sim:
            sim.run(until=0.9, stop_at_events=True)
            self.assertEqual(last, sim.time)
            self.assertEqual(self.read_hash(fmu, REFERENCE), sim.hash)
        self.assertEqual(fmu.call("EnterEventMode"), OK)
        flags, next_time = [c_bool(True) for _ in range(5)], c_double()
        self.assertEqual(fmu.call("UpdateDiscreteStates", *map(byref, flags), byref(next_time)), OK)
        self.assertFalse(any(flag.value for flag in flags))
        self.assertEqual(fmu.step(last, 0.001)[0], ERROR)  # not in event mode
        self.assertEqual(fmu.call("EnterStepMode"), OK)
        self.assertEqual(fmu.step(last, 0.001)[0], OK)

    def test_states_are_kept_serialized_and_taken_up_again(self):
        for version in (3, 2):
            fmu = self.open(version, REFERENCE)
            self.assertEqual(fmu.begin(), OK)
            self.assertEqual(fmu.step(0.0, 0.3)[0], OK)
            state, data = fmu.save()
            self.assertEqual(fmu.step(0.3, 0.2)[0], OK)
            ended = self.read_hash(fmu, REFERENCE)
            self.assertEqual(fmu.call(fmu.state_name("SetFMUState"), state), OK)
            self.assertEqual(fmu.get("time"), 0.3)
            self.assertEqual(fmu.step(0.3, 0.2)[0], OK)
            self.assertEqual(self.read_hash(fmu, REFERENCE), ended)
            self.assertEqual(fmu.call(fmu.state_name("FreeFMUState"), byref(state)), OK)
            self.assertIsNone(state.value)
            other, again = self.open(version, REFERENCE), c_void_p()
            self.assertEqual(other.call(fmu.state_name("DeserializeFMUState"), data, c_size_t(len(data)), byref(again)), OK)
            self.assertEqual(other.call(fmu.state_name("SetFMUState"), again), OK)
            self.assertEqual(other.step(0.3, 0.2)[0], OK)
            self.assertEqual(self.read_hash(other, REFERENCE), ended)
            damaged = data[:40] + bytes([data[40] ^ 1]) + data[41:]
            self.assertEqual(other.call(fmu.state_name("DeserializeFMUState"), damaged, c_size_t(len(damaged)), byref(again)), OK)
            self.assertEqual(other.call(fmu.state_name("SetFMUState"), again), ERROR)
            self.assertEqual(self.read_hash(other, REFERENCE), ended)
            self.assertEqual(other.call(fmu.state_name("FreeFMUState"), byref(again)), OK)
            self.assertEqual(other.call("Reset"), OK)
            self.assertEqual((other.get("time"), other.begin()), (0.0, OK))

    def test_wrong_order_and_wrong_values_are_errors_and_change_nothing(self):
        for version in (3, 2):
            fmu = self.open(version)
            self.assertEqual(fmu.step(0.0, 0.001)[0], ERROR)  # before initialization
            self.assertEqual(fmu.call("ExitInitializationMode"), ERROR)
            self.assertEqual(fmu.call("Terminate"), ERROR)
            self.assertEqual(fmu.begin(start=1.0), ERROR)
            self.assertEqual(fmu.begin(), OK)
            self.assertEqual(fmu.begin(), ERROR)
            before = self.read_hash(fmu, BOOSTERS)
            for time, size in ((0.0, 0.0005), (0.001, 0.001), (0.0, -0.001), (0.0, math.nan), (math.nan, 0.001), (0.0, math.inf)):
                self.assertEqual(fmu.step(time, size)[0], ERROR, (time, size))
            for value in (2.0, -0.1, math.nan, math.inf):
                self.assertEqual(fmu.set("channels.throttle1", value), ERROR)
            self.assertEqual(fmu.set("sensors.kr1", 1.0), ERROR)  # an output
            self.assertEqual(fmu.access("Get", 10**6)[0], ERROR)
            self.assertEqual(fmu.access("Set", 10**6)[0], ERROR)
            self.assertEqual(fmu.get("channels.throttle1"), 1.0)
            self.assertEqual(self.read_hash(fmu, BOOSTERS), before)
            self.assertEqual(fmu.call("Terminate"), OK)
            self.assertEqual(fmu.step(0.0, 0.001)[0], ERROR)
            self.assertEqual(fmu.set("channels.throttle1", 0.5), ERROR)
            kept, fmu.instance = fmu.instance, 4711  # no instance
            self.assertEqual(fmu.step(0.0, 0.001)[0], ERROR)
            self.assertEqual(fmu.call("Reset"), ERROR)
            fmu.instance = kept
            self.assertIsNone(self.open(version, token="{another}").instance)
        fmu = self.open(3)
        self.assertEqual(fmu.call("EnterEventMode"), ERROR)
        self.assertTrue(any("event mode" in message for message in fmu.messages), fmu.messages)
        self.assertEqual(fmu.call("GetInt32", None, c_size_t(0), None, c_size_t(0)), OK)
        self.assertEqual(fmu.call("GetInt32", (c_uint32 * 1)(1), c_size_t(1), (c_int * 1)(), c_size_t(1)), ERROR)
        self.assertEqual(fmu.call("SetTime", c_double(1)), ERROR)

    def test_the_description_keeps_the_rules_of_the_standards(self):
        for version in (3, 2):
            root = ElementTree.parse(self.unpack(version) / "modelDescription.xml").getroot()
            self.assertEqual((root.tag, root.get("fmiVersion")), ("fmiModelDescription", f"{version}.0"))
            order = ["CoSimulation", "UnitDefinitions", "DefaultExperiment", "ModelVariables", "ModelStructure"]
            self.assertEqual([child.tag for child in root], order)
            self.assertRegex(root.find("CoSimulation").get("modelIdentifier"), r"^[A-Za-z_]\w*$")
            variables = list(root.find("ModelVariables"))
            names = [v.get("name") for v in variables]
            references = [v.get("valueReference") for v in variables]
            self.assertEqual((len(set(names)), len(set(references))), (len(names), len(references)))
            units = {unit.get("name") for unit in root.find("UnitDefinitions")}
            kinds = {}
            for place, variable in enumerate(variables):
                number = variable if version == 3 else variable[0]
                self.assertEqual(number.tag, "Float64" if version == 3 else "Real")
                self.assertIn(number.get("unit", "m"), units, variable.get("name"))
                self.assertEqual(variable.get("variability"), "fixed" if variable.get("causality") == "parameter" else "continuous")
                kinds.setdefault(variable.get("causality"), []).append((place, variable))
                if variable.get("causality") == "input":  # has a start in its range
                    self.assertTrue(float(number.get("min")) <= float(number.get("start")) <= float(number.get("max")))
                elif variable.get("causality") == "parameter":
                    self.assertTrue(math.isfinite(float(number.get("start"))))
                else:
                    self.assertIsNone(number.get("start"))
            self.assertEqual([variable.get("name") for _, variable in kinds["independent"]], ["time"])
            self.assertEqual(len(kinds["input"]), 21)
            self.assertEqual(set(kinds), {"independent", "input", "output", "parameter"})
            structure = root.find("ModelStructure")
            for kind in ("Output", "InitialUnknown"):
                if version == 3:
                    listed = [output.get("valueReference") for output in structure.findall(kind)]
                    self.assertEqual(listed, [variable.get("valueReference") for _, variable in kinds["output"]])
                else:
                    listed = [int(unknown.get("index")) for unknown in structure.find(f"{kind}s")]
                    self.assertEqual(listed, [place + 1 for place, _ in kinds["output"]])

    def test_fmus_of_all_shipped_scenarios_keep_the_standards_rules(self):
        scenarios = sorted(SCENARIOS.glob("*/scenario.yaml"))
        self.assertGreater(len(scenarios), 7)

        def check(case):
            scenario, version = case
            file = self.folder / f"{scenario.parent.name}-{scenario.stem}-{version}.fmu"
            self.run_ok(UNLATCH, "export", scenario, "--fmu", file, "--fmi", version)
            with zipfile.ZipFile(file) as archive:
                root = ElementTree.fromstring(archive.read("modelDescription.xml"))
            file.unlink()
            return [f"{scenario.parent.name}/{scenario.stem}, FMI {version}: {fault}" for fault in list_faults(root, version)]

        with ThreadPoolExecutor(2) as pool:
            faults = sum(pool.map(check, [(scenario, version) for scenario in scenarios for version in (2, 3)]), [])
        self.assertEqual(faults, [])

    def test_constants_and_written_numbers_of_the_scenario_are_parameters_with_units(self):
        for version in (3, 2):
            fmu = self.open(version)
            listed = {variable.get("name"): variable if version == 3 else variable[0] for variable in fmu.description.find("ModelVariables")
                      if variable.get("causality") == "parameter"}
            with unlatch.load(BOOSTERS) as sim:
                self.assertEqual({name: (float(v.get("start")), v.get("unit", "")) for name, v in listed.items()},
                                 {**{f"constants.{name}": tuple(constant) for name, constant in sim.constants.items()},
                                  **{path: tuple(number) for path, number in sim.numbers.items()
                                     if path not in ("unlatch", "step.dt", "step.until")}})
            self.assertEqual(fmu.get("bodies.core.mass"), 98500)
            self.assertEqual(fmu.get("constants.node_radius"), 1.32)
            self.assertEqual(fmu.set("constants.node_radius", 1.4), ERROR)  # the joints would be apart
            self.assertEqual(fmu.get("constants.node_radius"), 1.32)

    def test_a_number_without_a_name_is_set_by_its_path(self):
        scenario = self.folder / "probe.yaml"
        scenario.write_text(PROBE, encoding="utf-8")
        with unlatch.load(scenario, {"bodies.probe.inertia[2]": "26", "channels.throttle.initial": "0.5"}) as sim:
            sim.run(until=0.4)
            wanted = sim.bodies["probe"].position[0]
        for version in (3, 2):
            fmu = self.open(version, scenario)
            self.assertNotIn("bodies.probe.mass", fmu.references)  # constants.load is
            self.assertEqual(fmu.set("bodies.probe.inertia[2]", 26), OK, fmu.messages)
            self.assertEqual(fmu.set("bodies.probe.inertia[2]", 100), ERROR)  # beyond the triangle inequality
            if version == 3:  # the importer of version 2 above has no log
                self.assertIn("inertia", fmu.messages[-1])
            self.assertEqual(fmu.set("channels.throttle.initial", 0.5), OK, fmu.messages)
            self.assertEqual(fmu.begin(), OK, fmu.messages)
            self.assertEqual(fmu.step(0.0, 0.4)[0], OK)
            self.assertEqual((fmu.get("bodies.probe.inertia[2]"), fmu.get("bodies.probe.position.x")), (26, wanted))

    # Scale and offset of a table, a constant of an expression and the channel of the table; quantities of flight as sensors.
    def test_tables_expressions_and_air_have_the_bits_of_the_program(self):
        scenario, changes = self.folder / "dart.yaml", {"tables.pitching.scale": 1.25, "tables.pitching.offset": 0.01, "constants.fineness": 1.75}
        scenario.write_text(FLIGHT, encoding="utf-8")
        options = [option for name, value in changes.items() for option in ("--set", f"{name}={value}")]
        wanted = self.run_json(UNLATCH, "run", scenario, "--outputs", "sensor.*@400", *options)
        with unlatch.load(scenario, changes) as sim:
            sim.run(until=1)
            sim.channels["gain"] = 0.5
            sim.run(until=2)
            commanded = sim.hash, sim.sensors["alpha"][0]
            place = list(sim.bodies["dart"].position)
        for version in (3, 2):
            fmu = self.open(version, scenario)
            for name, value in changes.items():
                self.assertEqual(fmu.set(name, value), OK, fmu.messages)
            self.assertEqual(fmu.begin(), OK, fmu.messages)
            self.assertEqual(fmu.step(0.0, 1.0)[0], OK)
            state, _ = fmu.save()
            self.assertEqual(fmu.step(1.0, 1.0)[0], OK)
            self.assertEqual([fmu.get("sensors.alpha"), fmu.get("sensors.load")], wanted["outputs"][0]["rows"][-1])
            self.assertEqual([fmu.get(f"bodies.dart.position.{axis}") for axis in "xyz"], wanted["samples"][-1]["bodies"]["dart"]["p"])
            self.assertEqual(fmu.call(fmu.state_name("SetFMUState"), state), OK)
            self.assertEqual(fmu.set("channels.gain", 0.5), OK)
            self.assertEqual(fmu.step(1.0, 1.0)[0], OK)
            self.assertEqual(fmu.get("sensors.alpha"), commanded[1])
            self.assertEqual([fmu.get(f"bodies.dart.position.{axis}") for axis in "xyz"], place)

    def test_the_scheme_of_the_resources_may_be_in_capitals(self):
        self.assertEqual(self.open(2, scheme="FILE:").begin(), OK)

    def test_parameters_are_read_and_set_whatever_the_locale(self):
        scenario = self.folder / "probe.yaml"
        scenario.write_text(PROBE)
        for version in (2, 3):
            fmu = self.open(version, scenario)
            self.assertEqual(fmu.set("constants.load", 15000.5), OK)
            self.assertEqual(fmu.begin(), OK, fmu.messages)
            self.assertEqual(fmu.get("constants.load"), 15000.5)
            self.assertEqual(fmu.set("channels.throttle", 1), OK)
            self.assertEqual(fmu.step(0.0, 0.1)[0], OK)
            self.assertAlmostEqual(fmu.get("bodies.probe.velocity.x"), 5000 * 0.1 / 15000.5)
            self.assertEqual(fmu.set("channels.throttle", 1.5), ERROR)
            if version == 3:  # the importer of FMI 2 here takes no messages
                self.assertIn("1.5 is outside its range, 0 to 1", fmu.messages[-1])

    def test_parameters_are_set_before_the_run_and_belong_to_the_state(self):
        scenario = self.folder / "probe.yaml"
        scenario.write_text(PROBE, encoding="utf-8")
        with unlatch.load(scenario, {"constants.load": "125 kg"}) as sim:
            sim.channels["throttle"] = 0.5
            sim.run(until=0.4)
            wanted = sim.bodies["probe"].position[0]
        for version in (3, 2):
            fmu, other = self.open(version, scenario), self.open(version, scenario)
            self.assertEqual(fmu.set("channels.throttle", 0.5), OK)
            self.assertEqual(fmu.set("constants.load", 125), OK, fmu.messages)
            self.assertEqual((fmu.get("constants.load"), fmu.get("constants.push"), fmu.get("channels.throttle")), (125, 5000, 0.5))
            for value in (math.nan, math.inf, -1.0):
                self.assertEqual(fmu.set("constants.load", value), ERROR)
            self.assertEqual(fmu.begin(), OK, fmu.messages)
            self.assertEqual(fmu.set("constants.load", 130), ERROR)  # in the run
            self.assertEqual(fmu.step(0.0, 0.4)[0], OK)
            self.assertEqual((fmu.get("constants.load"), fmu.get("bodies.probe.position.x")), (125, wanted))
            state, data = fmu.save()
            again = c_void_p()
            self.assertEqual(fmu.call("Reset"), OK)
            self.assertEqual((fmu.get("constants.load"), fmu.get("channels.throttle"), fmu.get("time")), (100, 0, 0))
            self.assertEqual(other.call(fmu.state_name("DeserializeFMUState"), data, c_size_t(len(data)), byref(again)), OK)
            for at, one in ((other, again), (fmu, state)):
                self.assertEqual(at.call(fmu.state_name("SetFMUState"), one), OK, at.messages)
                self.assertEqual((at.get("constants.load"), at.get("time"), at.get("bodies.probe.position.x")), (125, 0.4, wanted))
                self.assertEqual(at.call(fmu.state_name("FreeFMUState"), byref(one)), OK)

    def test_the_sources_and_how_to_build_them_are_inside(self):
        for version in (3, 2):
            folder = self.unpack(version)
            root = ElementTree.parse(folder / "sources/buildDescription.xml").getroot()
            self.assertEqual((root.tag, root.get("fmiVersion")), ("fmiBuildDescription", "3.0"))
            identifier = self.open(version).description.find("CoSimulation").get("modelIdentifier")
            every = {str(path.relative_to(folder / "sources")) for path in (folder / "sources").rglob("*.cc")}
            for configuration in root:
                self.assertEqual((configuration.tag, configuration.get("modelIdentifier")), ("BuildConfiguration", identifier))
                named = [file.get("name") for file in configuration.iter("SourceFile")]
                self.assertEqual(len(named), len(set(named)))
                wide = {"kernel/dispatch/avx2.cc", "kernel/dispatch/avx512.cc"} if configuration.get("platform") == "aarch64-linux" else set()
                self.assertEqual(set(named) | wide, every)
                self.assertEqual([part.tag for part in configuration], sorted((part.tag for part in configuration), reverse=True))
            if version == 2:
                files = [file.get("name") for file in self.open(2).description.find("CoSimulation/SourceFiles")]
                self.assertTrue(set(files) <= every)
            # Every included header of this project is there.
            for path in (folder / "sources").rglob("*.[ch]*"):
                for included in re.findall(r'^#include "([^"]+)"', path.read_text(encoding="utf-8"), re.M):
                    found = [folder / "sources" / place / included for place in (".", "kernel/include", "library/include")]
                    self.assertTrue(any(file.exists() for file in found), f"{path}: {included}")

    def test_the_sources_make_the_binary_again(self):
        """Built with the options of the build description: the same hash. Takes minutes."""
        folder = self.unpack(3, REFERENCE)
        platform = next((folder / "binaries").iterdir())
        root = ElementTree.parse(folder / "sources/buildDescription.xml").getroot()
        configuration = next(found for found in root if found.get("platform") == platform.name)
        jobs = []
        for place, files in enumerate(configuration.iter("SourceFileSet")):
            flags = files.get("compilerOptions").split() + ["-isystem", "/usr/include/eigen3"]
            flags += [f"-D{one.get('name')}" + (f"={one.get('value')}" if one.get("value") else "") for one in files.iter("PreprocessorDefinition")]
            flags += [f"-I{one.get('name')}" for one in files.iter("IncludeDirectory")]
            for number, file in enumerate(files.iter("SourceFile")):
                jobs.append((["g++", *flags, "-c", file.get("name"), "-o"], self.folder / f"{place}-{number}.o"))
        with ThreadPoolExecutor(os.cpu_count()) as pool:
            list(pool.map(lambda job: subprocess.run([*job[0], job[1]], cwd=folder / "sources", check=True, capture_output=True), jobs))
        binary = platform / f"{configuration.get('modelIdentifier')}.so"
        wanted = self.run_json(UNLATCH, "run", REFERENCE, "--until", "0.9", code=None)["hash"]
        binary.unlink()
        subprocess.run(["g++", "-shared", "-o", binary, *(job[1] for job in jobs), "-lyaml-cpp", "-ldl", "-pthread"], check=True)
        fmu = self.open(3, REFERENCE)
        self.assertEqual(fmu.begin(), OK, fmu.messages)
        self.assertEqual(fmu.step(0.0, 0.9)[0], OK)
        self.assertEqual(self.read_hash(fmu, REFERENCE), wanted)

    def test_what_is_not_resolved_is_logged_once_and_makes_this_and_all_later_steps_warnings(self):
        scenario = self.folder / "pulse.yaml"
        scenario.write_text(PULSE)
        for version in 2, 3:
            fmu = self.open(version, scenario)
            self.assertEqual(fmu.begin(), OK)
            found = [fmu.step(0.1 * k, 0.1)[0] for k in range(20)]
            first = found.index(WARNING)
            self.assertIn(first, (10, 11))
            self.assertEqual(found, [OK] * first + [WARNING] * (20 - first))
        self.assertEqual([m for m in fmu.messages if "step element 'pyro'" in m], fmu.messages[:1])
        self.assertEqual(len([m for m in fmu.messages if "profile pyro" in m and "unresolved" in m]), 1, fmu.messages)

    # The pulse at 1 s is not resolved.
    def test_a_restored_state_is_unresolved_as_it_was_when_it_was_kept(self):
        scenario = self.folder / "pulse.yaml"
        scenario.write_text(PULSE)
        fmu, other = self.open(3, scenario), self.open(3, scenario)
        self.assertEqual((fmu.begin(), other.begin()), (OK, OK))
        states = []
        for k in range(20):
            if k in (5, 15):
                states.append(c_void_p())
                self.assertEqual(fmu.call("GetFMUState", byref(states[-1])), OK)
            fmu.step(0.1 * k, 0.1)
        before, behind = states
        for _ in range(2):
            self.assertEqual(fmu.call("SetFMUState", before), OK)
            found = [fmu.step(0.5 + 0.1 * k, 0.1)[0] for k in range(10)]
            self.assertEqual((found[0], found[-1]), (OK, WARNING))
        size = c_size_t()
        self.assertEqual(fmu.call("SerializedFMUStateSize", behind, byref(size)), OK)
        kept, taken = (ctypes.c_ubyte * size.value)(), c_void_p()
        self.assertEqual(fmu.call("SerializeFMUState", behind, kept, size), OK)
        self.assertEqual(other.call("DeserializeFMUState", kept, size, byref(taken)), OK)
        self.assertEqual(other.call("SetFMUState", taken), OK)
        self.assertEqual(other.step(1.5, 0.1)[0], WARNING, other.messages)
        self.assertIn("start", other.messages[-1])

    def test_a_step_beyond_the_importers_stop_time_is_an_error(self):
        for version in 2, 3:
            fmu = self.open(version, REFERENCE)
            if version == 3:
                self.assertEqual(fmu.call("EnterInitializationMode", c_bool(False), c_double(0), c_double(0), c_bool(True), c_double(0.1)), OK)
            else:
                self.assertEqual(fmu.call("SetupExperiment", c_int(0), c_double(0), c_double(0), c_int(1), c_double(0.1)), OK)
                self.assertEqual(fmu.call("EnterInitializationMode"), OK)
            self.assertEqual(fmu.call("ExitInitializationMode"), OK)
            self.assertEqual(fmu.step(0, 0.1)[0], OK, fmu.messages)
            self.assertEqual(fmu.step(0.1, 0.1)[0], ERROR)
        self.assertIn("after the stop time of 0.1 s", fmu.messages[-1])

    def test_overrides_are_inside_and_mistakes_are_reported(self):
        file = self.folder / "heavy.fmu"
        self.run_ok(UNLATCH, "export", REFERENCE, "--fmu", file, "--set", "bodies.core.mass=99 t", "--set", "bodies.booster1.mass=4400")
        with zipfile.ZipFile(file) as archive:
            archive.extractall(self.folder / "heavy")
        fmu = Fmu(self.folder / "heavy", 3)
        self.addCleanup(fmu.free)
        self.assertEqual(fmu.begin(), OK, fmu.messages)
        self.assertEqual(fmu.step(0.0, 0.5)[0], OK)
        with unlatch.load(REFERENCE, {"bodies.core.mass": "99 t", "bodies.booster1.mass": 4400}) as sim:
            sim.run(until=0.5)
            self.assertEqual(fmu.get("bodies.core.position.x"), sim.bodies["core"].position[0])
            self.assertEqual(fmu.get("reactions.nose1.x"), sim.joints["nose1"].reaction[0])
        for more in (["--fmi", "4"], ["--out", "x.csv"], ["--set", "bodies.core.mass=-1"]):
            self.assertEqual(self.run_ok(UNLATCH, "export", REFERENCE, "--fmu", file, *more, code=None).returncode, 2, more)
        self.run_ok(UNLATCH, "export", REFERENCE, "--fmu", "/nowhere/x.fmu", code=3)


if __name__ == "__main__":
    main()
