#!/usr/bin/env python3
"""Option unlatch hil --fmu: controller FMUs as flight software, valid and hostile ones: fmuloop_test.py BIN_FOLDER SOURCE_FOLDER"""
import os
import platform
import struct
import subprocess
import warnings
import zipfile
from pathlib import Path

from processes import BOOSTERS, SANITIZED, UNLATCH, ProcessTest, main

HERE = Path(__file__).resolve().parent
TOKEN = "{5a1e4c2f-controller}"
INPUTS = {f"kr{i}": i - 1 for i in range(1, 5)}
KINDS = ("throttle", "rudder", "cut_ties", "cutoff", "nozzle")
OUTPUTS = {f"{kind}{i + 1}": 100 + 5 * i + place for i in range(4) for place, kind in enumerate(KINDS)} | {"verniers": 120}
MACHINE = platform.machine()
PLATFORM = {2: "linux64" if MACHINE == "x86_64" else f"linux-{MACHINE}", 3: f"{MACHINE}-linux"}
SAID = ["--transport", "inproc", "--pace", "lockstep", "--until", "2"]
ERROR_AT_STEP, NAN_OUTPUT, ERROR_AT_SET, ENDS, RETURNS_EARLY, FATAL_AT_STEP, OTHER_VERSION, WARNS_FROM_STEP = range(1, 9)


def describe(version, inputs, outputs, token=TOKEN, identifier="controller", more="", booleans=()):
    def variable(name, reference, causality):
        common = f'name="{name}" valueReference="{reference}" causality="{causality}"'
        start = ' start="0"' if causality == "input" else ""
        if version == 3:
            return f'<{"Boolean" if name in booleans else "Float64"} {common}{start.replace("0", "false") if name in booleans else start}/>'
        return f'<ScalarVariable {common}><{"Boolean" if name in booleans else "Real"}{start}/></ScalarVariable>'

    named = "instantiationToken" if version == 3 else "guid"
    variables = [variable(name, at, "input") for name, at in inputs.items()] + [variable(name, at, "output") for name, at in outputs.items()]
    return (f'<?xml version="1.0"?>\n<fmiModelDescription fmiVersion="{version}.0" modelName="c" {named}="{token}">\n'
            f'<CoSimulation modelIdentifier="{identifier}"/>\n<ModelVariables>{"".join(variables)}{more}</ModelVariables>\n'
            "<ModelStructure/></fmiModelDescription>\n")


class FmuLoopTest(ProcessTest):
    def build(self, version, hostile=0, *flags):
        binary = self.folder / f"controller{version}{hostile}{len(flags)}.so"
        if not binary.exists():
            subprocess.run([os.environ.get("CC", "cc"), "-std=c99", "-Wall", "-Wextra", "-Werror", "-shared", "-fPIC", f"-DFMI={version}",
                            f"-DHOSTILE={hostile}", f'-DTOKEN="{TOKEN}"', *flags, HERE / "controller.c", "-o", binary, "-lm"], check=True)
        return binary.read_bytes()

    def pack(self, version, members=None, hostile=0, flags=(), description=None, compression=zipfile.ZIP_DEFLATED):
        path = self.folder / "controller.fmu"
        names = {"modelDescription.xml": description or describe(version, INPUTS, OUTPUTS),
                 f"binaries/{PLATFORM[version]}/controller.so": self.build(version, hostile, *flags), "resources/": "", **(members or {})}
        with zipfile.ZipFile(path, "w", compression) as archive:
            for name, content in names.items():
                if content is not None:
                    archive.writestr(name, content)
        return path

    def fly(self, fmu, code, *more):
        return self.run_ok(UNLATCH, "hil", BOOSTERS, "--fmu", fmu, *SAID, *more, code=code)

    def refuse(self, fmu, *words):
        result = self.fly(fmu, 2)
        for word in words:
            self.assertIn(word, result.stderr)

    def fail(self, fmu, *words):
        report = self.run_json(UNLATCH, "hil", BOOSTERS, "--fmu", fmu, *SAID, code=1)
        self.assertEqual(report["status"], "aborted")
        self.assertLess(report["ticks"], 2000)
        for word in words:
            self.assertIn(word, report["message"])

    def test_a_controller_fmu_separates_the_boosters_to_the_hash_of_the_reference_flight_software(self):
        wanted = self.run_json(UNLATCH, "hil", BOOSTERS, *SAID, code=None)
        for version, compression in ((3, zipfile.ZIP_DEFLATED), (2, zipfile.ZIP_STORED)):
            flown = self.run_json(UNLATCH, "hil", BOOSTERS, "--fmu", self.pack(version, compression=compression), *SAID, code=None)
            self.assertEqual((flown["status"], flown["hash"]), (wanted["status"], wanted["hash"]))
            self.assertEqual(flown["events"], wanted["events"])

    def test_a_warning_of_the_controller_is_printed_once(self):
        for version in 2, 3:
            said = self.fly(self.pack(version, hostile=WARNS_FROM_STEP), None).stderr
            self.assertEqual(said.count(f"FMU controller.fmu at t = 0.2 s: fmi{version}DoStep returned fmi{version}Warning"), 1, said)
            self.assertEqual(said.count("Warning"), 1)

    def test_two_outputs_for_one_channel_and_outputs_of_no_channel_are_refused(self):
        self.fly(self.pack(3), 2, "--map", "throttle1=throttle2")
        self.assertIn("output 'throttle2': it is mapped to 'throttle2', as is 'throttle1'",
                      self.fly(self.pack(3), 2, "--map", "throttle1=throttle2").stderr)
        outputs = {"channels.throtle1" if name == "throttle1" else name: at for name, at in OUTPUTS.items()}
        self.refuse(self.pack(3, description=describe(3, INPUTS, outputs)), "output 'channels.throtle1', which is no channel")

    def test_a_variable_in_a_unit_that_is_not_of_si_is_refused(self):
        for version in 2, 3:
            text = describe(version, INPUTS, OUTPUTS).replace(
                "<ModelVariables>", '<UnitDefinitions><Unit name="deg"><BaseUnit rad="1" factor="0.017453292519943295"/></Unit>'
                '<Unit name="rad"><BaseUnit rad="1"/></Unit></UnitDefinitions><ModelVariables>')
            spoilt = text.replace('causality="output"><Real/>', 'causality="output"><Real unit="UNIT"/>', 1) if version == 2 else \
                text.replace('causality="output"/>', 'causality="output" unit="UNIT"/>', 1)
            self.assertNotEqual(spoilt, text)
            self.refuse(self.pack(version, description=spoilt.replace("UNIT", "deg")), "'throttle1' in SI: it is in 'deg'")
            self.fly(self.pack(version, description=spoilt.replace("UNIT", "rad")), None)

    def test_an_archive_whose_paths_have_backslashes_is_read(self):
        wanted = self.run_json(UNLATCH, "hil", BOOSTERS, *SAID, code=None)["hash"]
        binary = self.build(3)
        fmu = self.pack(3, {f"binaries/{PLATFORM[3]}/controller.so": None, f"binaries\\{PLATFORM[3]}\\controller.so": binary,
                            "resources/": None, "resources\\": ""})
        self.assertEqual(self.run_json(UNLATCH, "hil", BOOSTERS, "--fmu", fmu, *SAID, code=None)["hash"], wanted)

    def test_names_with_prefix_states_and_booleans_are_mapped(self):
        wanted = self.run_json(UNLATCH, "hil", BOOSTERS, *SAID, code=None)["hash"]
        for version in (2, 3):
            inputs = {f"sensors.{name}": at for name, at in INPUTS.items()} | {"bodies.core.position.x": 200}
            outputs = {f"channels.{name}": at for name, at in OUTPUTS.items()} | {"debug": 200}
            booleans = ["sensors.kr1", "channels.cutoff2", "channels.nozzle3"]
            fmu = self.pack(version, description=describe(version, inputs, outputs, booleans=booleans))
            self.assertEqual(self.run_json(UNLATCH, "hil", BOOSTERS, f"--fmu=fsw={fmu}", *SAID, code=None)["hash"], wanted)

    def test_other_names_are_mapped_by_options_and_files(self):
        wanted = self.run_json(UNLATCH, "hil", BOOSTERS, *SAID, code=None)["hash"]
        inputs = {f"In{k}": at for k, (_, at) in enumerate(INPUTS.items())} | {"Spare": 200}
        outputs = {f"Out{k}": at for k, (_, at) in enumerate(OUTPUTS.items())}
        maps = [f"In{k} = sensors.{name}" for k, name in enumerate(INPUTS)] + [f"Out{k}={name}" for k, name in enumerate(OUTPUTS)]
        fmu = self.pack(3, description=describe(3, inputs, outputs))
        options = [part for line in [*maps, "Spare=-"] for part in ("--map", line)]
        self.assertEqual(self.run_json(UNLATCH, "hil", BOOSTERS, "--fmu", fmu, *options, *SAID, code=None)["hash"], wanted)
        file = self.folder / "names.map"
        file.write_text("# the controller's ports\n\n" + "\n".join(maps) + "\nfsw:Spare = -  # not wired\n")
        self.assertEqual(self.run_json(UNLATCH, "hil", BOOSTERS, "--fmu", fmu, "--map", file, *SAID, code=None)["hash"], wanted)
        exported = [*(f"In{k}=received.{name}" for k, name in enumerate(INPUTS)), *(f"Out{k}=channel.{name}" for k, name in enumerate(OUTPUTS)), "Spare=-"]
        exported[0] = exported[0].replace("received.", "sensor.")
        options = [part for line in exported for part in ("--map", line)]
        self.assertEqual(self.run_json(UNLATCH, "hil", BOOSTERS, "--fmu", fmu, *options, *SAID, code=None)["hash"], wanted)
        for option, words in ((f"In0={'x' * 5}", ("'In0', mapped to 'xxxxx'", "no sensor")), ("Out0=nothing", ("'Out0', mapped to 'nothing'", "no channel")),
                              ("In99=kr1", ("no input or output 'In99'", "Spare")), ("In0", ("neither VARIABLE=NAME nor a file",)),
                              ("In0=", ("is no VARIABLE=NAME",))):
            with self.subTest(option):
                result = self.fly(fmu, 2, "--map", option)
                for word in words:
                    self.assertIn(word, result.stderr)
        file.write_text("In0 = kr1\nIn0 = kr2\n")
        self.assertIn("names.map:2: 'In0' is mapped twice", self.fly(fmu, 2, "--map", file).stderr)
        self.assertIn("give one by --fmu", self.run_ok(UNLATCH, "hil", BOOSTERS, *SAID, "--map", "In0=kr1", code=2).stderr)

    def test_an_fmu_of_our_own_is_refused_because_its_names_are_those_of_a_vehicle(self):
        own = self.folder / "own.fmu"
        self.run_ok(UNLATCH, "export", BOOSTERS, "--fmu", own)
        self.refuse(own, "channels.throttle1", "no sensor and no state")

    def test_what_no_vehicle_has_is_named(self):
        self.refuse(self.pack(3, description=describe(3, INPUTS | {"altimeter": 9}, OUTPUTS)), "'altimeter'", "no sensor")
        self.refuse(self.pack(3, description=describe(3, INPUTS, {"debug": 100})), "an output that is called as a channel")
        wrong = '<Int32 name="kr1" valueReference="7" causality="input" start="0"/>'
        self.refuse(self.pack(3, description=describe(3, {}, OUTPUTS, more=wrong)), "'kr1'", "Boolean")

    def test_what_is_wrong_with_a_file_is_said_before_the_run(self):
        folder = self.folder
        (folder / "none.fmu").write_bytes(b"")
        (folder / "text.fmu").write_text("no zip file at all, but longer than the shortest one")
        self.refuse(folder / "none.fmu", "empty")
        self.refuse(folder / "nowhere.fmu", "cannot be read")
        self.refuse(folder / "text.fmu", "no zip file")
        self.refuse(self.pack(3, {"modelDescription.xml": None}), "modelDescription.xml", "not in the zip")
        self.refuse(self.pack(3, {"modelDescription.xml": "<a><b></a>"}), "modelDescription.xml: line 1")
        self.refuse(self.pack(3, {"modelDescription.xml": "<other/>"}), "fmiModelDescription")
        self.refuse(self.pack(3, description=describe(3, INPUTS, OUTPUTS).replace('"3.0"', '"1.0"')), "fmiVersion")
        self.refuse(self.pack(3, description=describe(3, INPUTS, OUTPUTS).replace("CoSimulation", "ModelExchange")), "co-simulation")
        self.refuse(self.pack(3, description=describe(3, INPUTS, OUTPUTS, identifier="../../bin/sh")), "no C identifier")
        self.refuse(self.pack(3, {f"binaries/{PLATFORM[3]}/controller.so": None, "binaries/win64/controller.dll": b"MZ"}), "win64")
        self.refuse(self.pack(3, {f"binaries/{PLATFORM[3]}/controller.so": b"no library"}), "cannot be loaded")
        self.refuse(self.pack(3, description=describe(3, {"kr1": "one"}, OUTPUTS)), "valueReference")

    def test_a_member_that_leads_out_of_the_folder_is_refused(self):
        outside = self.folder / "outside"
        for name in ("../outside", "resources/../../outside", str(outside), "resources\\..\\outside"):
            self.refuse(self.pack(3, {name: "x"}), "leads out")
            self.assertFalse(outside.exists())

    def test_a_damaged_zip_file_is_refused(self):
        path = self.pack(3)
        sound = path.read_bytes()
        spoilt = bytearray(sound)
        spoilt[sound.index(b"modelDescription.xml") + 60] ^= 0xFF  # in its compressed bytes
        path.write_bytes(spoilt)
        self.refuse(path, "modelDescription.xml")
        directory = sound.rindex(b"PK\x05\x06")
        for place, value in ((directory + 16, 0xF0), (sound.index(b"PK\x01\x02") + 24, 0xFF), (sound.index(b"PK\x01\x02") + 10, 99),
                             (sound.index(b"PK\x01\x02") + 8, 1), (sound.index(b"PK\x01\x02") + 45, 0x7F)):
            spoilt = bytearray(sound)
            spoilt[place] = value
            path.write_bytes(spoilt)
            self.refuse(path, "controller.fmu")
        path.write_bytes(sound[:len(sound) // 2])
        self.refuse(path, "no zip file")

    def test_a_member_that_is_not_what_the_directory_states_is_refused(self):
        path = self.pack(3, compression=zipfile.ZIP_STORED)
        stored = bytearray(path.read_bytes())
        stored[stored.index(b"fmiModelDescription") + 3] ^= 1  # nothing but the checksum sees it
        path.write_bytes(stored)
        self.refuse(path, "modelDescription.xml", "CRC error")
        path = self.pack(3)
        packed = path.read_bytes()
        length = packed.index(b"PK\x01\x02") + 24  # of modelDescription.xml, in the directory
        for change in (-1, 1):
            spoilt = bytearray(packed)
            spoilt[length:length + 4] = struct.pack("<I", struct.unpack_from("<I", packed, length)[0] + change)
            path.write_bytes(spoilt)
            self.refuse(path, "modelDescription.xml")
        spoilt = bytearray(packed)
        spoilt[length:length + 4] = struct.pack("<I", 1 << 30)
        path.write_bytes(spoilt)
        self.refuse(path, "larger than 1 GiB")
        with zipfile.ZipFile(path, "w") as archive, warnings.catch_warnings():
            warnings.simplefilter("ignore")  # that the name is there already
            for _ in range(2):
                archive.writestr("modelDescription.xml", "")
        self.refuse(path, "it is there twice")

    def test_a_binary_that_does_not_fit_is_refused(self):
        for version in (2, 3):
            self.refuse(self.pack(version, flags=["-DWITHOUT_STEP", "-Wno-unused-function"]), f"controller.so lacks fmi{version}DoStep")
            self.refuse(self.pack(version, description=describe(version, INPUTS, OUTPUTS, token="{other}")), "{other}", "refused")
            self.refuse(self.pack(version, hostile=OTHER_VERSION), f"fmi{version}GetVersion returned 1.0")

    def test_a_failing_step_ends_the_run_and_is_reported(self):
        for version in (2, 3):
            self.fail(self.pack(version, hostile=ERROR_AT_STEP), f"fmi{version}DoStep returned fmi{version}Error", "t = 0.2 s", "gyro 7 has failed")
            self.fail(self.pack(version, hostile=FATAL_AT_STEP), f"fmi{version}Fatal")
            self.fail(self.pack(version, hostile=NAN_OUTPUT), "output 'throttle1' is NaN", "t = 0.2 s")
            self.fail(self.pack(version, hostile=ERROR_AT_SET), "of kr1 returned", "t = 0 s")
        self.fail(self.pack(3, hostile=ENDS), "asks to end the simulation")
        self.fail(self.pack(3, hostile=RETURNS_EARLY), "returned early")

    def test_it_needs_lockstep_in_this_process_and_one_required_participant(self):
        fmu = self.pack(3)
        for more in (["--transport", "inproc", "--pace", "realtime"], ["--transport", "lcm", "--pace", "lockstep"]):
            self.assertIn("lockstep", self.run_ok(UNLATCH, "hil", BOOSTERS, "--fmu", fmu, *more, code=2).stderr)
        two = ["--set", "flight_software.required=[fsw, guidance]"]
        self.assertIn("fsw, guidance", self.fly(fmu, 2, *two).stderr)
        self.assertIn("requires no flight software", self.fly(fmu, 2, "--set", "flight_software.required=[]").stderr)
        again = self.run_ok(UNLATCH, "hil", BOOSTERS, "--fmu", fmu, "--fmu", fmu, *SAID, code=2)
        self.assertIn("two FMUs", again.stderr)


if __name__ == "__main__":
    if SANITIZED:
        raise SystemExit(77)  # the FMU's allocations are its own
    main()
