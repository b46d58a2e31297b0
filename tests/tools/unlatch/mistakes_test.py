#!/usr/bin/env python3
"""Facts about mistakes of users: the messages of `unlatch`, and its exit codes. Run by ctest like tools_test.py."""

import os
import re
import subprocess

from processes import FSW, HANG, REFERENCE, UNLATCH, ProcessTest, main

FULL = "/dev/full"  # a device on which nothing can be written
NOBODY = 65534


class MistakesTest(ProcessTest):
    def setUp(self):
        super().setUp()
        self.run_ok(UNLATCH, "init", self.folder / "first")
        self.first = self.folder / "first.yaml"

    def write(self, name, text):
        path = self.folder / name
        path.write_text(text)
        return path

    def change(self, name, *changes):
        text = self.first.read_text()
        for old, new in changes:
            self.assertIn(old, text)
            text = text.replace(old, new, 1)
        return self.write(name, text)

    def refuse(self, *arguments, code=2):
        """Returns the message about a mistake; nothing else is printed."""
        return self.run_ok(UNLATCH, *arguments, code=code).stderr

    # --- Outputs ------------------------------------------------------------------------------------------------

    def test_a_full_device_is_an_error_of_every_verb(self):
        log = self.folder / "run.log"
        self.run_ok(UNLATCH, "run", self.first, "--until", "0.1", "--log", log)
        for arguments in (["check", self.first], ["run", self.first, "--until", "0.1"], ["diff", log, log],
                          ["replay", log], ["check", self.first, "--json", "-"], ["--version"]):
            with open(FULL, "w") as full:
                done = subprocess.run([UNLATCH, *map(str, arguments)], stdout=full, stderr=subprocess.PIPE, text=True,
                                      timeout=HANG)
            self.assertEqual(done.returncode, 3, arguments)
            self.assertIn("No space left on device", done.stderr, arguments)
        self.assertIn("No space left", self.refuse("report", log, "--out", FULL, code=3))
        self.assertTrue(os.path.exists(FULL))

    def test_a_failed_report_leaves_no_file_and_keeps_an_old_one(self):
        """Writes a page to a file system of 64 KiB, which is too small for it."""
        log = self.folder / "run.log"
        self.run_ok(UNLATCH, "run", self.first, "--until", "0.1", "--log", log)
        small = self.folder / "small"
        small.mkdir()
        script = (f"mount -t tmpfs -o size=64k none {small} || exit 77; echo old > {small}/old.html; "
                  f"for name in new old; do {UNLATCH} report {log} --out {small}/$name.html; echo code $?; done; "
                  f"cat {small}/*; ls {small}")
        done = subprocess.run(["unshare", "--mount", "--map-root-user", "bash", "-c", script], capture_output=True, text=True,
                              timeout=HANG)
        if done.returncode == 77 or "unshare: " in done.stderr:
            self.skipTest("no file system can be mounted here: " + done.stderr)
        self.assertEqual(done.stdout.split(), ["code", "3", "code", "3", "old", "old.html"], done.stderr)
        self.assertIn("No space left", done.stderr)

    def test_outputs_that_cannot_be_made_are_reported_before_the_run(self):
        log = self.folder / "run.log"
        for option in ("--json", "--log", "--junit"):
            said = self.refuse("run", REFERENCE, "--until", "100000", option, self.folder / "none/x", code=3)
            self.assertIn("none/x: cannot be created: No such file or directory", said)
        self.refuse("hil", self.first, "--transport", "inproc", "--pace", "fast", "--json", self.folder / "none/x", code=3)
        for option in ("--json", "--junit"):
            self.refuse("hil", REFERENCE, "--until", "100000", "--transport", "inproc", "--pace", "fast", option, self.folder / "none/x", code=3)
        said = self.refuse("log", "--transport", "lcm", "--out", log, "--json", self.folder / "none/x", code=3)
        self.assertIn("none/x: cannot be created", said)
        said = self.refuse("run", REFERENCE, "--until", "100000", "--checkpoint", "1", self.folder / "none/x", code=3)
        self.assertIn("none/x: cannot be created", said)
        self.run_ok(UNLATCH, "run", self.first, "--until", "0.1", "--log", log)
        self.assertIn("Is a directory", self.refuse("report", log, "--out", self.folder, code=3))
        self.assertEqual({p.name for p in self.folder.iterdir()}, {"first.yaml", "unlatch.schema.json", "run.log"})

    # --- The command line ---------------------------------------------------------------------------------------

    def test_verbs_and_options_are_guessed(self):
        self.assertIn("there is no verb 'rnu'; did you mean 'run'?", self.refuse("rnu", self.first))
        self.assertIn("there is no option '--untl'; did you mean '--until'?", self.refuse("run", self.first, "--untl", "3"))
        self.assertIn("there is no option '--transprt'; did you mean '--transport'?",
                      self.refuse("hil", self.first, "--transprt", "dds", "--pace", "lockstep"))
        self.assertIn("--transport is required", self.refuse("hil", self.first, "--pace", "lockstep"))
        self.assertIn("unlatch modes: there is no verb 'arcc'; did you mean 'arc'? known: arc, shell, import, show",
                      self.refuse("modes", "arcc"))
        self.assertIn("unlatch modes arc: there is no option '--angel'; did you mean '--angle'?", self.refuse("modes", "arc", "--angel", "3"))
        for wrong in ("--untl", "--until"):
            self.assertIn(f"unlatch: there is no option '{wrong}'; did you mean '--until' behind 'run'?",
                          self.refuse(wrong, "3", "run", self.first))
        self.assertIn("did you mean '--points' behind 'arc'?", self.refuse("modes", "--points=5", "arc"))

    def test_the_help_of_the_flight_software_names_every_transport(self):
        about, options = self.run_ok(FSW, "--help").stdout.split("Usage:")
        for transport in re.search(r"--transport TEXT:\{(.*?)\}", options)[1].split(","):
            self.assertIn(transport.rstrip(":").upper(), about)

    def test_a_cpu_that_does_not_exist_is_a_usage_error(self):
        for arguments in (["hil", self.first, "--transport", "inproc", "--pace", "realtime"], ["preflight"]):
            for cpu in ("999", "1" * 30):
                self.assertIn(f"CPU {cpu} does not exist; this machine has CPUs 0 to ",
                              self.refuse(*arguments, "--cpu", cpu))
            self.assertIn("is not the number of a CPU", self.refuse(*arguments, "--cpu", "one"))

    def test_times_of_options_take_units(self):
        ends = {self.run_json(UNLATCH, "run", self.first, "--until", text)["ticks"] for text in ("2", "2 s", "2000 ms")}
        self.assertEqual(ends, {2000})
        result = self.run_json(UNLATCH, "run", self.first, "--until", "2 s", "--dt", "500 us", "--sample", "0,250 ms,1.5 s")
        self.assertEqual([sample["t"] for sample in result["samples"]], [0, 0.25, 1.5])
        for wrong in ("3 kg", "-1 s", "0", "soon", "nan"):
            said = self.refuse("run", self.first, "--until", wrong)
            self.assertIn(f"'{wrong}' is not a positive number of seconds; write for example 3, 3 s, 300 ms", said)

    # --- Files --------------------------------------------------------------------------------------------------

    def test_a_scenario_may_come_from_standard_input(self):
        for path in ("-", "/dev/stdin"):
            with self.first.open() as text:
                done = subprocess.run([UNLATCH, "check", path], stdin=text, capture_output=True, text=True, timeout=HANG)
            self.assertEqual((done.returncode, done.stderr), (0, ""), path)
        done = subprocess.run([UNLATCH, "check", "-"], input="unlatch: 1\nname: [x\n", capture_output=True, text=True,
                              timeout=HANG)
        self.assertEqual(done.returncode, 2)
        self.assertRegex(done.stderr, r"^<stdin>:\d+:\d+: not YAML")

    def test_files_that_cannot_be_read_say_why(self):
        self.assertIn("there is no such file", self.refuse("check", self.folder / "none.yaml"))
        self.assertIn("there is nothing in it", self.refuse("check", self.write("empty.yaml", "# nothing\n")))
        large = self.write("large.yaml", "#" * 1_580_000)
        self.assertIn("it has 1580000 bytes, more than 1 MiB; a scenario file has at most 1048576 bytes", self.refuse("check", large))
        tab = self.write("tab.yaml", "unlatch: 1\nstep:\n\tdt: 1 ms\n")
        self.assertIn("tab.yaml:3:1: a tab in the indentation; indent with spaces", self.refuse("check", tab))

    def test_a_file_without_permission_says_so(self):
        if os.geteuid() != 0:
            secret = self.write("secret.yaml", "unlatch: 1\n")
            secret.chmod(0)
            self.assertIn("Permission denied", self.refuse("check", secret))
            return
        os.chmod(self.folder, 0o755)
        secret = self.write("secret.yaml", "unlatch: 1\n")
        secret.chmod(0)
        done = subprocess.run(["setpriv", f"--reuid={NOBODY}", "--clear-groups", UNLATCH, "check", str(secret)],
                              capture_output=True, text=True, timeout=HANG)
        if "failed to execute" in done.stderr:
            self.skipTest("the programs are in a folder of root's")
        self.assertEqual(done.returncode, 2)
        self.assertIn("it cannot be opened: Permission denied", done.stderr)

    def test_a_cyclic_include_is_the_only_mistake_reported(self):
        main_file = self.write("a.yaml", "unlatch: 1\nname: a\ninclude: b.yaml\n")
        self.write("b.yaml", "unlatch_part: 1\ninclude: a.yaml\n")
        said = self.refuse("check", main_file).splitlines()
        self.assertEqual(len(said), 1, said)
        self.assertIn("b.yaml:2:10: cannot include 'a.yaml': it would include itself: a.yaml → b.yaml → a.yaml", said[0])

    # --- Scenarios ----------------------------------------------------------------------------------------------

    # A misspelt constant changed nothing, and each sample of a campaign that drew it was the same.
    def test_a_constant_or_a_channel_that_only_an_override_names_is_refused(self):
        box = self.write("box.yaml", "unlatch: 1\nname: box\nstep: {dt: 10 ms, until: 20 ms}\nconstants: {load: 2 kg}\n"
                                     "bodies: {box: {mass: load, inertia: [1, 1, 1]}}\n")
        said = self.refuse("run", box, "--set", "constants.laod=3")
        self.assertIn("box.yaml: --set constants.laod=3: the scenario has no constant 'laod', nor does it read one", said)
        self.assertIn("did you mean 'load'?", said)
        self.assertIn("has no channel 'throttle'", self.refuse("check", box, "--set", "channels.throttle.initial=0.5"))
        self.run_ok(UNLATCH, "run", box, "--set", "constants.half=1 kg", "--set", "bodies.box.mass=2 * half")
        self.run_ok(UNLATCH, "run", box, "--set", "channels.pull.range=[0, 2]", "--set",
                    "elements.pull={type: force, body: box, direction: [1, 0, 0], profile: 1 N, channel: pull}")
        campaign = self.write("c.yaml", "unlatch_campaign: 1\nname: c\nscenario: box.yaml\nsamples: 3\n"
                                        "parameters: {load: {path: constants.laod, uniform: {min: 1 kg, max: 2 kg}}}\n")
        self.assertIn("has no constant 'laod'", self.refuse("check", campaign))

    # Nothing reads `spare`, so that another value of it changes nothing.
    UNREAD = ("unlatch: 1\nname: box\nSETstep: {dt: 10 ms, until: 20 ms}\nconstants: {load: 2 kg, spare: 3 m}\n"
              "channels: {idle: {}}\nbodies: {box: {mass: load, inertia: [1, 1, 1]}}\n"
              "requirements: [{id: r, text: a spare word, position: {body: box}, at_most: 1 m}]\n")

    def test_a_misspelt_or_unread_constant_of_a_files_own_set_is_refused(self):
        said = self.refuse("check", self.write("laod.yaml", self.UNREAD.replace("SET", "set: {constants.laod: 3 kg}\n")))
        self.assertIn("laod.yaml:3:7: the scenario has no constant 'laod', nor does it read one", said)
        self.assertIn("did you mean 'load'?", said)
        said = self.refuse("run", self.write("spare.yaml", self.UNREAD.replace("SET", "set: {constants.spare: 4 m}\n")))
        self.assertIn("nothing reads the constant 'spare': another value changes nothing", said)
        self.assertIn("has no channel 'idel'", self.refuse("check", self.write(
            "idel.yaml", self.UNREAD.replace("SET", "set: {channels.idel.initial: 1}\n"))))
        self.run_ok(UNLATCH, "run", self.write("good.yaml", self.UNREAD.replace("SET", "set: {constants.load: 3 kg}\n")))

    def test_another_value_of_a_constant_that_nothing_reads_is_refused_and_the_same_one_is_not(self):
        box = self.write("box.yaml", self.UNREAD.replace("SET", ""))
        self.assertIn("--set constants.spare=4: nothing reads the constant 'spare'", self.refuse("run", box, "--set", "constants.spare=4"))
        self.run_ok(UNLATCH, "run", box, "--set", "constants.spare=3")
        self.run_ok(UNLATCH, "run", box, "--set", "constants.spare=4", "--set", "bodies.box.position[0]=spare", code=1)
        campaign = self.write("c.yaml", "unlatch_campaign: 1\nname: c\nscenario: box.yaml\nsamples: 3\n"
                                        "parameters: {spare: {path: constants.spare, uniform: {min: 1 m, max: 2 m}}}\n")
        self.assertIn("nothing reads the constant 'spare'", self.refuse("check", campaign))

    def test_a_constant_that_only_an_unread_one_names_is_unread_too(self):
        text = self.UNREAD.replace("SET", "").replace("spare: 3 m", "spare: 3 m, more: 2 * spare, heavy: 2, load: heavy * 1 kg", 1).replace("load: 2 kg, ", "")
        box = self.write("box.yaml", text)
        warnings = self.run_json(UNLATCH, "check", box)["warnings"]
        self.assertEqual([(w["name"], w["where"]) for w in warnings], [("unread", "constant 'spare'"), ("unread", "constant 'more'")])
        for name in "spare", "more":
            self.assertIn(f"nothing reads the constant '{name}'", self.refuse("run", box, "--set", f"constants.{name}=4 m"))
        self.run_ok(UNLATCH, "run", box, "--set", "constants.heavy=3")

    # The draws of a campaign replace what its scenario computes from the constant, and start from that.
    def test_a_constant_that_a_campaign_is_given_for_the_mean_of_its_draws_is_read(self):
        self.write("box.yaml", self.UNREAD.replace("SET", ""))
        campaign = self.write("c.yaml", "unlatch_campaign: 1\nname: c\nscenario: box.yaml\nsamples: 3\nset: {constants.load: 5 kg}\n"
                                        "parameters: {mass: {path: bodies.box.mass, normal: {mean: nominal, sigma: 1 %}}}\n")
        self.run_ok(UNLATCH, "check", campaign)
        self.run_ok(UNLATCH, "campaign", campaign, "--out", self.folder / "out", "--set", "constants.load=6 kg")
        log = self.folder / "run.log"
        self.run_ok(UNLATCH, "run", campaign, "--sample", "1", "--log", log, "--set", "constants.load=6 kg")
        self.run_ok(UNLATCH, "replay", log)
        both = self.write("both.yaml", campaign.read_text().replace("set: {constants.load: 5 kg}\n", "").replace(
            "parameters: {", "parameters: {load: {path: constants.load, uniform: {min: 1 kg, max: 2 kg}}, "))
        self.assertIn("nothing reads the constant 'load'", self.refuse("check", both))

    # `required` is a list of names: nothing of it is called `late`.
    def test_a_key_that_is_absent_is_no_misspelling_of_a_list_beside_it(self):
        text = self.UNREAD.replace("SET", "").replace(", spare: 3 m", "") + "flight_software: {required: [obc]}\n"
        box = self.write("box.yaml", text)
        self.run_ok(UNLATCH, "check", box, "--set", "flight_software.require.late=2 %")
        self.assertIn("lost", self.refuse("check", box, "--set", "flight_software.require.lots=2"))
        self.assertIn("there is no 'boxx'", self.refuse("check", box, "--set", "bodies.boxx.mass=2"))

    # Metres of a constant in millimetres would be a thousand times too much.
    def test_a_study_with_plain_numbers_for_a_constant_in_another_unit_than_that_of_si_is_refused(self):
        self.write("box.yaml", self.UNREAD.replace("SET", "").replace("spare: 3 m", "gap: 2 mm, turn: 2").replace("position: {body: box}, at_most: 1 m", "position: {body: box}, at_most: gap * turn"))
        head = "unlatch_campaign: 1\nname: c\nscenario: box.yaml\nsamples: 3\nparameters: {g: {path: constants.gap, "
        for plain in ("uniform: {min: 1, max: 4}", "uniform: {min: 1 mm, max: 4}", "normal: {mean: 3, sigma: 1 %}", "discrete: {values: [1, 2]}",
                      "normal: {mean: nominal, sigma: 0.1}", "triangular: {min: 0, mode: 1, max: 2}"):
            said = self.refuse("check", self.write("c.yaml", head + plain + "}}\n"))
            self.assertIn("a plain number for 'constants.gap', which the scenario gives in mm; write the unit: 1 mm, or that of SI", said, plain)
        for good in ("uniform: {min: 1 mm, max: 4 mm}", "uniform: {min: 0, max: 0.004 m}", "normal: {mean: nominal, sigma: 1 %}", "discrete: {values: [0, 2 mm]}"):
            self.run_ok(UNLATCH, "check", self.write("c.yaml", head + good + "}}\n"))
        self.run_ok(UNLATCH, "check", self.write("c.yaml", head.replace("gap", "turn") + "uniform: {min: 1, max: 4}}}\n"))
        table = "unlatch_campaign: 1\nname: c\nscenario: box.yaml\nsampling: csv\ntable: t.csv\nparameters: {g: {path: constants.gap}}\n"
        for heading, code in (("g", 2), ("g [mm]", 0), ("g [m]", 0)):
            self.write("t.csv", heading + "\n0.001\n")
            self.run_ok(UNLATCH, "check", self.write("c.yaml", table), code=code)
        problem = ("unlatch_optimize: 1\nname: p\nscenario: box.yaml\nvariables: {width: {path: constants.gap, RANGE}}\nobjectives: [{minimise: r}]\n")
        for plain in "between: [1, 4]", "values: [1, 4]", "values: [1 mm, 4]":
            said = self.refuse("check", self.write("p.yaml", problem.replace("RANGE", plain)))
            self.assertIn("plain numbers for 'constants.gap', which the scenario gives in mm", said)
        for good in "between: [1 mm, 4 mm]", "values: [0, 1 mm]":
            self.run_ok(UNLATCH, "check", self.write("p.yaml", problem.replace("RANGE", good)))

    def test_constants_that_nothing_reads_are_findings_of_check_and_of_each_run(self):
        box = self.write("box.yaml", self.UNREAD.replace("SET", ""))
        for verb in "check", "run":
            warnings = self.run_json(UNLATCH, verb, box)["warnings"]
            self.assertEqual([(w["name"], w["where"]) for w in warnings], [("unread", "constant 'spare'")])

    def test_a_mistake_that_an_override_makes_is_the_overrides(self):
        said = self.refuse("check", self.first, "--set", "constants.gap=-0.2 m", "--set", "step.until=4")
        self.assertIn("first.yaml: --set constants.gap=-0.2 m: element 'spring1': free_length is -0.4", said)
        self.assertNotIn("step.until", said)
        wrong = self.change("wrong.yaml", ("mass: 500 kg", "mass: -500 kg"))
        said = self.refuse("check", wrong, "--set", "step.until=4")
        self.assertRegex(said, r"wrong\.yaml:\d+:\d+: body 'satellite': its mass is -500 kg")

    def test_times_before_and_after_the_run_are_reported(self):
        early = self.change("early.yaml", ("{time: 1 s}", "{time: -1 s}"))
        self.assertIn("this time is before the run, which begins at 0 s; 0 s or later", self.refuse("check", early))
        late = self.change("late.yaml", ("{time: 1 s}", "{time: 50 s}"))
        note = "event 'release' of 'satellite' cannot come before 50 s; the run ends at 5 s"
        self.assertEqual(self.run_ok(UNLATCH, "check", late).stderr, f"note: {note}\n")
        self.assertEqual(self.run_json(UNLATCH, "check", late)["notes"], [note])
        self.assertEqual(self.run_json(UNLATCH, "check", self.first)["notes"], [])
        both = self.change("both.yaml", ("{time: 1 s}", "{all: [{time: 1 s}, {any: [{time: 9 s}, {time: 7 s}]}]}"))
        self.assertIn("before 7 s", self.run_json(UNLATCH, "check", both)["notes"][0])

    def test_one_mistake_of_many_instances_is_one_line(self):
        many = ("{template: spring, count: 3}", "{template: spring, count: 24}")
        said = self.refuse("check", self.change("m.yaml", many, ("stiffness: <stiffness>", "stiffness: -<stiffness>")))
        self.assertEqual(len(said.splitlines()), 1, said)
        self.assertIn("and 23 more", said)
        rows = ("{template: spring, count: 3}", "{template: spring, for: [" + ", ".join(["{}"] * 24) + "]}")
        said = self.refuse("check", self.change("rows.yaml", rows))
        self.assertEqual(len(said.splitlines()), 1, said)
        self.assertIn("parameter 'i' has no value (and 23 more)", said)

    def test_count_says_that_it_gives_i(self):
        text = self.first.read_text().replace("{i, angle", "{k, angle").replace("<i>", "<k>").replace("count: 3", "count: 24")
        said = self.refuse("check", self.write("named.yaml", text))
        self.assertEqual(len(said.splitlines()), 1, said)
        self.assertIn("`count` gives the parameter 'i', from 1, and template 'spring' has none of that name; "
                      "name its parameter i, or write `for: [{k: 1}, {k: 2}]`", said)

    # --- Many alike ---------------------------------------------------------------------------------------------

    def make_planks(self):
        """A satellite with 24 planks on hinges, from one template, and 24 springs."""
        template = ("    bodies:\n      plank<i>: {mass: 3 kg, inertia: [1, 1, 1], position: [2.5 m, <i>*1 m, 0]}\n"
                    "    joints:\n      hinge<i>:\n        between: [satellite, plank<i>]\n        point: [0.9 m, <i>*1 m, 0]\n"
                    "        modes: {turns: {kind: revolute, axis: z}, free: {kind: free}}\n        mode: turns\n    elements:\n")
        event = ("events:\n", "events:\n  - name: let_go\n    when: {time: 2 s}\n    then: ["
                 + ", ".join(f"{{set_mode: {{joint: hinge{i}, mode: free}}}}" for i in range(1, 25)) + "]\n")
        return self.change("planks.yaml", ("    elements:\n", template), ("count: 3}", "count: 24}"), event)

    def test_one_is_singular(self):
        text = self.run_ok(UNLATCH, "check", self.first, "--dt", "1", "--until", "1").stdout
        self.assertIn("1 tick to 1 s; 0 channels, 9 sensor values, 1 signal, 1 event", text)
        self.assertIn("at 1 instant of events", self.run_ok(UNLATCH, "run", self.first).stdout)
        self.assertIn("first: ok, 1 tick of", self.run_ok(UNLATCH, "run", self.first, "--until", "1 ms").stdout)

    def test_lists_show_many_alike_as_one(self):
        planks = self.make_planks()
        lines = self.run_ok(UNLATCH, "check", planks).stdout.splitlines()
        self.assertLess(len(lines), 40)
        text = "\n".join(lines)
        self.assertIn("plank1 … plank24 (24) mass 3 kg", text)
        self.assertIn("hinge1 … hinge24 (24): satellite – plank#", text)
        self.assertIn("plank24 … plank1 (24) through hinge# into satellite", text)
        self.assertIn("turns          5 rows", text)
        lines = self.run_ok(UNLATCH, "run", planks, "--until", "3").stdout.splitlines()
        self.assertLess(len(lines), 50)  # the tables alone, not 24 lines of any
        text = "\n".join(lines)
        self.assertIn("hinge1 … hinge24 (24), the largest of each row:", text)
        self.assertIn("of 24 pairs satellite – plank# the one that turns fastest", text)
        self.assertIn("spring1 … spring24 (24)", self.run_ok(UNLATCH, "check", planks).stdout)

    def test_the_graph_shows_many_alike_as_one(self):
        drawing = self.folder / "planks.svg"
        self.run_ok(UNLATCH, "check", self.make_planks(), "--graph", drawing)
        text = drawing.read_text()
        self.assertIn("plank1 … plank24", text)
        self.assertNotIn(">plank7<", text)
        self.assertLess(int(text.partition('height="')[2].partition("pt")[0]), 900)


if __name__ == "__main__":
    main()
