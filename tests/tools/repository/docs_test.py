#!/usr/bin/env python3
"""Pages for people: their commands run, the files that they show have these contents, the targets of their links exist.

A fenced block ```sh run is run, all of a page in its order in one scratch folder that sees the repository; ```yaml check is
a scenario and is checked; after ```LANGUAGE file=PATH stands that file. Run by ctest in a network namespace of its own:

    docs_test.py BIN_FOLDER SOURCE_FOLDER [unittest options]
"""
import os
import re
import subprocess
import urllib.parse
from pathlib import Path

from processes import BIN, SOURCE, ProcessTest, main

SOURCES = (".cc", ".h", ".c", ".py", ".md", ".yaml", ".sh", ".json", ".idl", ".cmake", ".svg", ".txt")
BLOCK = re.compile(r"^```([^\n]*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
SLOWEST = 240  # s for all commands of a page; a limit for hangs, not a measurement


def list_files(*patterns):
    """Files of the project; not those of a build folder, where other tests make and remove some at the same time."""
    listed = subprocess.run(["git", "-C", SOURCE, "ls-files", "-z", "--cached", "--others", "--exclude-standard", *patterns],
                            capture_output=True, check=True).stdout.decode()
    return [SOURCE / name for name in listed.split("\0") if name and (SOURCE / name).exists()]


def list_pages():
    return list_files("*.md")


class DocsTest(ProcessTest):
    def run_page(self, page):
        """Runs the page's commands; returns their output."""
        blocks = []
        for info, body in BLOCK.findall((SOURCE / page).read_text()):
            if info.split() == ["sh", "run"]:
                blocks.append(body)
            elif info.split() == ["yaml", "check"]:
                blocks.append(f"cat > shown.yaml <<'END'\n{body}END\nunlatch check shown.yaml\n")
        self.assertTrue(blocks, f"{page} has no commands to run")
        for entry in SOURCE.iterdir():
            if entry.name not in ("build", ".git"):
                (self.folder / entry.name).symlink_to(entry)
        # The reader's build folder.
        (self.folder / "build/release").mkdir(parents=True)
        (self.folder / "build/release/bin").symlink_to(BIN)
        done = subprocess.run(["bash", "-euxo", "pipefail", "-c", "\n".join(blocks)], cwd=self.folder, text=True, timeout=SLOWEST,
                              env={**os.environ, "PATH": f"{BIN}:{os.environ['PATH']}"},
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        self.assertEqual(done.returncode, 0, f"{page}:\n{done.stdout[-4000:]}")
        return done.stdout

    def test_the_readme_commands_work(self):
        said = self.run_page("README.md")
        self.assertIn("is valid", said)

    def test_the_first_pages_commands_work(self):
        said = self.run_page("START.md")
        self.assertIn("shown.yaml is valid", said)
        self.assertRegex(said, r"0\.600000 s  cutoff")  # by the flight software that is a copy with one change

    def test_the_commands_of_the_page_on_dossiers_work(self):
        said = self.run_page("hil/scenarios/DOSSIER.md")
        self.assertIn("of dossier.json", re.sub(r"[0-9a-f]{64}  ", "of ", said))
        self.assertIn("2 requirements", said)

    def test_the_tutorial_commands_work(self):
        said = self.run_page("bridge/TUTORIAL.md")
        rate = float(re.search(r"^rate \[.*, (\S+)\]$", said, re.MULTILINE)[1])
        self.assertLess(abs(rate), 1e-3)  # rad/s; of 0.2 exp(-40/90 * 20) = 3e-5 is left
        self.assertIn("every bit agrees", said.replace("\n", " "))

    def test_the_scenario_pages_commands_work(self):
        self.run_page("hil/scenarios/README.md")

    def test_files_shown_in_pages_are_those_files(self):
        shown = 0
        for page in list_pages():
            for info, body in BLOCK.findall(page.read_text()):
                named = re.search(r"\bfile=(\S+)", info)
                if named:
                    self.assertEqual(body, (SOURCE / named[1]).read_text(), f"{page.name} shows another {named[1]}")
                    shown += 1
        self.assertGreater(shown, 0)

    def test_links_lead_somewhere(self):
        links = 0
        for page in list_pages():
            text = BLOCK.sub("", page.read_text())
            for target in re.findall(r"\]\(([^)\s]+)\)", text):
                if re.match(r"[a-z]+:", target):
                    continue
                path, _, anchor = urllib.parse.unquote(target).partition("#")
                there = (page.parent / path).resolve() if path else page
                self.assertTrue(there.exists(), f"{page.relative_to(SOURCE)} links to {target}")
                if anchor and there.suffix == ".md":
                    self.assertIn(anchor, self.list_anchors(there), f"{page.relative_to(SOURCE)} links to {target}")
                links += 1
        self.assertGreater(links, 30)

    def test_every_figure_of_a_scenario_is_drawn_by_tools_figures_and_shown(self):
        drawn = self.run_ok(SOURCE / "tools/figures", "--list").stdout.split()
        kept = {path.stem: path for path in (SOURCE / "hil/scenarios").glob("**/figures/*.svg")}
        self.assertEqual(sorted(drawn), sorted(kept))
        for name, path in kept.items():
            self.assertTrue(any(f"figures/{name}.svg" in page.read_text() for page in path.parent.parent.glob("*.md")), f"no page shows {name}.svg")

    def test_files_named_in_pages_exist(self):
        names = 0
        files = list_files()
        for page in list_pages():
            if page.name == "CHANGELOG.md":  # history: names of former files
                continue
            text = BLOCK.sub("", page.read_text())
            for name in re.findall(r"`([\w./-]+)`", text):
                if not name.endswith(SOURCES) or name.startswith((".", "/")) or "/build/" in f"/{name}":
                    continue
                names += 1
                parts = Path(name).parts
                ends_so = [path for path in files if path.parts[-len(parts):] == parts]
                near = any(page.parent in path.parents or path.parents[len(parts)] == page.parent.parent for path in ends_so)
                there = near or (page.parent / name).exists() or (SOURCE / name).exists()
                self.assertTrue(there or self.is_made(name), f"{page.relative_to(SOURCE)} names {name}")
        self.assertGreater(names, 100)

    @staticmethod
    def is_made(name):
        """Files that a reader or a program creates."""
        made = ("first.yaml", "first.svg", "run.json", "manifest.json", "summary.json", "samples.csv", "requirements.csv", "review.md", "patch.yaml", "problem.yaml", "result.json", "unlatch.schema.json", "plot.svg")
        return name in made or name.startswith(("NAME", "FILE"))

    @staticmethod
    def list_anchors(page):
        titles = re.findall(r"^#+ (.+)$", BLOCK.sub("", page.read_text()), re.MULTILINE)
        plain = [re.sub(r"[^\w\- ]", "", re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", title).lower()) for title in titles]
        return {title.replace(" ", "-") for title in plain}


if __name__ == "__main__":
    main()
