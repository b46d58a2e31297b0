#!/usr/bin/env python3
"""Files for contributors: the checks before a commit work, and the workflow runs the README's test command.

    habits_test.py BIN_FOLDER SOURCE_FOLDER [unittest options]
"""
import os
import re
import shutil
import subprocess

import yaml
from processes import HANG, SOURCE, ProcessTest, main

WHO = {"GIT_AUTHOR_NAME": "a", "GIT_AUTHOR_EMAIL": "a@b", "GIT_COMMITTER_NAME": "a", "GIT_COMMITTER_EMAIL": "a@b"}


class HabitsTest(ProcessTest):
    def git(self, *arguments, code=0):
        done = subprocess.run(["git", *map(str, arguments)], cwd=self.folder, capture_output=True, text=True, timeout=HANG,
                              env={**os.environ, **WHO})
        self.assertEqual(done.returncode, code, done.stdout + done.stderr)
        return done.stdout + done.stderr

    def copy_tree(self):
        """Makes a separate repository with this tree's files, so that the settings of this one do not apply."""
        listed = subprocess.run(["git", "-C", SOURCE, "ls-files", "-z", "--cached", "--others", "--exclude-standard"],
                                capture_output=True, check=True).stdout.decode()
        for name in filter(None, listed.split("\0")):
            if (SOURCE / name).is_file():
                (self.folder / name).parent.mkdir(parents=True, exist_ok=True)
                shutil.copy2(SOURCE / name, self.folder / name)
        self.git("init", "-q")
        self.git("add", "-A")
        self.git("commit", "-qm", "all")

    def test_checks_before_a_commit_refuse_what_is_wrong_and_name_it(self):
        self.copy_tree()
        self.run_ok(self.folder / "tools/hooks", "install")
        path = self.folder / "hil/session/realtime/new.h"
        path.write_text("#pragma once\nint  badly_formatted( );\n")
        self.git("add", path)
        self.assertIn("hil/session/realtime/new.h:2", self.git("commit", "-qm", "format", code=1))
        path.write_text('#pragma once\n#include "tools/program/exit_codes.h"\n')
        self.git("add", path)
        self.assertIn("hil/session/realtime/new.h includes tools/program/exit_codes.h", self.git("commit", "-qm", "includes", code=1))
        path.write_text("#pragma once\n")
        reference = self.folder / "hil/scenarios/REFERENCE.md"
        reference.write_text(reference.read_text() + "more\n")
        self.git("add", path, reference)
        self.assertIn("REFERENCE.md is not what language.yaml says", self.git("commit", "-qm", "schema", code=1))
        self.git("checkout", "-q", "HEAD", "--", reference)
        self.git("commit", "-qm", "right")

    def test_the_hooks_of_pre_commit_call_our_own_tools(self):
        config = yaml.safe_load((SOURCE / ".pre-commit-config.yaml").read_text())
        for repository in config["repos"]:
            self.assertEqual(repository["repo"], "local")
            for hook in repository["hooks"]:
                self.assertEqual(hook["language"], "system")
                program, check = hook["entry"].split()
                self.assertIn(f"tools/hooks {check} ", self.run_ok(SOURCE / program, "--help").stdout)
                re.compile(hook["files"])

    def test_the_workflow_runs_the_readmes_test_command(self):
        workflow = yaml.safe_load((SOURCE / ".github/workflows/ci.yml").read_text())
        self.assertEqual(workflow[True], ["push", "pull_request"])  # the key `on`, as YAML 1.1 reads it
        (job,) = workflow["jobs"].values()
        self.assertEqual(job["container"]["image"], "debian:12")
        self.assertEqual(job["steps"][-1]["run"], "tools/test")
        self.assertIn("tools/test ", (SOURCE / "README.md").read_text())

    def test_issue_forms_ask_for_something(self):
        forms = sorted(p for p in (SOURCE / ".github/ISSUE_TEMPLATE").glob("*.yml") if p.name != "config.yml")
        self.assertGreaterEqual(len(forms), 2)
        for path in forms:
            form = yaml.safe_load(path.read_text())
            self.assertTrue(form["name"] and form["description"])
            self.assertTrue(any(field.get("validations", {}).get("required") for field in form["body"]), path)
            self.assertEqual(len({field["id"] for field in form["body"]}), len(form["body"]))


if __name__ == "__main__":
    main()
