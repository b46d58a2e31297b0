#!/usr/bin/env python3
"""Facts about the command line itself: help, completion, manual pages, colours, progress. Run by ctest like tools_test.py."""

import os
import pty
import re
import select
import shutil
import subprocess
import time
from pathlib import Path

from processes import BIN, BOOSTERS, FSW, HANG, REFERENCE, SCENARIOS, UNLATCH, ProcessTest, call, main

BUSY = ["run", REFERENCE, "--until", "900"]  # long enough for a progress bar on any machine


def read_terminal(command, environment=None, until=None, keys=b""):
    """Returns the output of a program on a terminal of 80 x 24, until it ends or `until` appears."""
    child, terminal = pty.fork()
    if child == 0:
        os.environ.update(environment or {})
        os.execv(command[0], list(map(str, command)))
    text, end = b"", time.monotonic() + HANG
    if keys:
        os.write(terminal, keys)
    try:
        while time.monotonic() < end and not (until and re.search(until, text)):
            if select.select([terminal], [], [], 0.2)[0]:
                text += os.read(terminal, 65536)
    except OSError:  # the program has ended
        pass
    finally:
        os.kill(child, 9)
        os.waitpid(child, 0)
        os.close(terminal)
    return text.decode(errors="replace")


def list_verbs():
    text = call(UNLATCH, "--help").stdout
    return re.findall(r"^  ([a-z]+) {2,}", text[text.index("Subcommands:"):], re.M)


class CliTest(ProcessTest):
    def complete(self, line, *shell):
        """Returns completions of the bash script for a line that ends at the cursor."""
        script = (f"source <({UNLATCH} completion bash); COMP_LINE=$1; COMP_POINT=${{#1}}; shift; COMP_WORDS=(\"$@\"); "
                  "COMP_CWORD=$(($# - 1)); _unlatch; printf '%s\\n' \"${COMPREPLY[@]}\"")
        words = line.split(" ")
        words[0] = UNLATCH
        done = subprocess.run(["bash", "-c", script, "bash", line, *words], capture_output=True, text=True, timeout=HANG,
                              cwd=SCENARIOS / "boosters")
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout.split()

    def test_every_verb_has_help_with_an_example_of_options_that_exist(self):
        verbs = list_verbs()
        self.assertGreater(len(verbs), 10)
        for verb in verbs:
            text = self.run_ok(UNLATCH, verb, "--help").stdout
            self.assertIn("Example", text, verb)
            example = text[text.index("Example"):]
            self.assertIn(f"unlatch {verb}", example)
            subs = re.findall(r"^  ([a-z]+) {2,}", text[:text.index("Example")].partition("Subcommands:")[2], re.M)
            for line in re.findall(rf"unlatch {verb} .*", example):
                sub = [word for word in line.split()[2:3] if word in subs]
                known = self.run_ok(UNLATCH, verb, *sub, "--help").stdout
                for name in re.findall(r"--[a-z-]+", line.split("&&")[0]):
                    self.assertIn(name, known.partition("Example")[0], line)
        self.assertIn("Example", self.run_ok(FSW, "--help").stdout)
        self.assertIn("Exit codes", self.run_ok(UNLATCH, "--help").stdout)

    def test_bash_completes_verbs_options_values_files_and_paths(self):
        self.assertEqual(self.complete("unlatch pre"), ["preflight"])
        self.assertIn("--until", self.complete("unlatch run --un"))
        self.assertEqual(self.complete("unlatch hil --pace l"), ["lockstep"])
        self.assertEqual(self.complete("unlatch hil --transport "), ["dds", "lcm", "udp", "uart:", "inproc"])
        self.assertIn("reference.yaml", self.complete("unlatch check ref"))
        self.assertEqual(self.complete("unlatch run reference.yaml --set bodies.core.ma"), ["bodies.core.mass="])

    def test_bash_completes_at_a_real_prompt(self):
        child, terminal = pty.fork()
        if child == 0:
            os.environ.update(PATH=f"{BIN}:{os.environ['PATH']}", PS1="> ", TERM="dumb")
            os.chdir(SCENARIOS / "boosters")
            os.execvp("bash", ["bash", "--norc", "--noprofile", "-i"])
        heard = b""
        try:
            for keys, wanted in ((b"source <(unlatch completion bash); echo rea''dy\n", rb"ready"),
                                 (b"unlatch hil dead\t --pace re\t --transport in\t",
                                  rb"unlatch hil dead-nozzle.yaml\s+--pace realtime\s+--transport inproc")):
                os.write(terminal, keys)
                end = time.monotonic() + HANG
                while time.monotonic() < end and not re.search(wanted, heard):
                    if select.select([terminal], [], [], 0.2)[0]:
                        heard += os.read(terminal, 65536)
                self.assertRegex(heard, wanted)
        finally:
            os.kill(child, 9)
            os.waitpid(child, 0)
            os.close(terminal)

    def test_other_shells_take_their_scripts(self):
        tried = 0
        for shell, check in (("zsh", ["zsh", "-n"]), ("fish", ["fish", "-n"])):
            script = self.folder / shell
            self.run_ok(UNLATCH, "completion", shell, "--out", script)
            if shutil.which(shell):
                self.run_ok(*check, script)
                tried += 1
        if shutil.which("fish"):
            offered = self.run_ok("fish", "-c", f"source {self.folder}/fish; complete -C 'unlatch hil --pace '").stdout
            self.assertEqual([line.split("\t")[0] for line in offered.splitlines()], ["fast", "lockstep", "realtime"])
        if shutil.which("zsh"):
            loaded = self.run_ok("zsh", "-fc", f"autoload -U compinit; compinit -D -u; source {self.folder}/zsh; echo $_comps[unlatch]")
            self.assertEqual(loaded.stdout.strip(), "_unlatch")
        if tried == 0:
            self.skipTest("neither zsh nor fish is installed")

    def test_paths_of_a_scenario_can_all_be_set(self):
        paths = self.run_ok(UNLATCH, "completion", "paths", REFERENCE).stdout.split()
        self.assertIn("bodies.core.mass", paths)
        self.assertTrue(any(path.startswith("events.contact:booster1.") for path in paths))
        for path in ("bodies.core.mass=1000", "bodies.core.inertia[1]=1.18e7"):
            self.assertIn(path.split("=")[0], paths)
            self.run_ok(UNLATCH, "check", REFERENCE, "--set", path)

    def test_manual_pages_are_clean_and_say_what_help_says(self):
        self.run_ok(UNLATCH, "man", "--out", self.folder)
        pages = sorted(path.name for path in self.folder.iterdir())
        self.assertEqual(pages, sorted(["unlatch.1"] + [f"unlatch-{verb}.1" for verb in list_verbs()]))
        for page in self.folder.iterdir():
            text = page.read_text()
            for section in ("NAME", "SYNOPSIS", "DESCRIPTION", "EXIT STATUS", "EXAMPLES"):
                self.assertIn(f".SH {section}", text, page.name)
            if shutil.which("mandoc"):
                lint = call("mandoc", "-T", "lint", "-W", "warning", page)
                # The missing date is intended: without it the page is the same from every build.
                found = [line for line in (lint.stdout + lint.stderr).splitlines() if "missing date" not in line]
                self.assertEqual(found, [], page.name)
        built = BIN.parent / "tools/share/man/man1"
        if built.exists():
            self.assertIn("unlatch-fsw.1", [path.name for path in built.iterdir()])
        if shutil.which("mandoc"):
            shown = self.run_ok("mandoc", "-T", "utf8", self.folder / "unlatch-run.1").stdout
            self.assertIn("--until", re.sub(".\b", "", shown))

    def test_colours_are_for_terminals_alone(self):
        self.assertIn("\033[", read_terminal([UNLATCH, "check", REFERENCE]))
        self.assertNotIn("\033[", read_terminal([UNLATCH, "check", REFERENCE], {"NO_COLOR": "1"}))
        self.assertNotIn("\033[", self.run_ok(UNLATCH, "check", REFERENCE).stdout)

    def test_a_long_run_shows_how_far_it_is_and_how_long_it_takes(self):
        self.assertRegex(read_terminal([UNLATCH, *BUSY], until=rb"left"), r"\[#*\.+\] t = \d+\.\d+ s of 900 s, .*s left")

    def test_check_gives_programs_the_plan_or_every_mistake(self):
        plan = self.run_json(UNLATCH, "check", BOOSTERS)
        self.assertTrue(plan["valid"])
        self.assertEqual(plan["joints"][0]["modes"]["slider"], ["y", "z", "rot_x", "rot_z"])
        self.assertEqual(len(plan["elimination"]), 5)
        bad = self.folder / "bad.yaml"
        bad.write_text(Path(REFERENCE).read_text().replace("mass: 98500", "mass: -1"))
        wrong = self.run_json(UNLATCH, "check", bad, code=2)
        self.assertFalse(wrong["valid"])
        self.assertGreater(wrong["mistakes"][0]["line"], 1)

    def test_reactions_that_are_not_unique_are_reported(self):
        bolts = "".join(f"""
  bolt{k}: {{between: [ground, plate], point: [0.4*cos({k}*pi/4), 0.4*sin({k}*pi/4), 0], share: 1, share_length: 1 cm,
          follower_point: [0.4*cos({k}*pi/4), 0.4*sin({k}*pi/4), 0], modes: {{held: {{rows: [z]}}, free: {{rows: []}}}}, mode: held}}"""
                        for k in range(8))
        scenario = self.folder / "plate.yaml"
        scenario.write_text(f"""unlatch: 1
name: plate
step: {{dt: 1 ms, until: 0.1 s}}
gravity: {{uniform: [0, 0, -10]}}
bodies: {{plate: {{mass: 80 kg, inertia: [3, 3, 6]}}}}
joints:{bolts}
events:
  - {{name: cut, when: {{time: 0.05 s}}, then: [{", ".join(f"{{set_mode: {{joint: bolt{k}, mode: free}}}}" for k in (0, 1, 3, 4, 6))}]}}
""")
        printed = "5 of 8 rows of bolt0, bolt1, bolt2, bolt3, bolt4, bolt5, bolt6, bolt7 are redundant"
        checked = call(UNLATCH, "check", scenario)
        self.assertIn(printed, checked.stdout)
        joints = [f"bolt{k}" for k in range(8)]
        self.assertEqual(self.run_json(UNLATCH, "check", scenario)["redundant"], [{"joints": joints, "rows": 8, "redundant": 5, "nearly_redundant": 0}])
        self.assertIn(printed, call(UNLATCH, "run", scenario).stdout)
        run = self.run_json(UNLATCH, "run", scenario, "--sample", "0.02")
        self.assertEqual(run["redundant"], [{"joints": joints, "rows": 8, "redundant": 5, "nearly_redundant": 0, "from": 0.0, "until": 0.049}])
        for joint in joints:
            self.assertAlmostEqual(run["samples"][0]["reactions"][joint]["lambda"][0], 100, 9)
        refused = call(UNLATCH, "check", scenario, "--set", "joints.bolt0.share=0")
        self.assertEqual(refused.returncode, 2)
        self.assertIn("share is 0", refused.stderr)


if __name__ == "__main__":
    main()
