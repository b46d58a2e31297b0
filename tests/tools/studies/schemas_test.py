#!/usr/bin/env python3
"""Tables of campaign files and optimisation problems, against the programs that read them. Run by ctest:

    schemas_test.py BIN_FOLDER SOURCE_FOLDER [unittest options]
"""
import copy
import json
import re
import subprocess
import sys

from jsonschema import Draft202012Validator
from optimize_test import SCENARIO
from processes import SCENARIOS, SOURCE, UNLATCH, ProcessTest, main

sys.path.insert(0, str(SOURCE / "hil/scenario/language"))
sys.dont_write_bytecode = True
from language import load_sections, load_yaml, parse_type  # noqa: E402

# Campaign and problem with every key once.
CAMPAIGN = """unlatch_campaign: 1
name: all
title: every key
scenario: s.yaml
set: {step.until: 0.5 s}
samples: 8
tolerance: 1e-6
seed: 3
sampling: subset
subset: {of: far, below: 1 m, part: 50 %, levels: 3, at_most: 0.1}
levels: 3
parameters:
  a: {path: bodies.block.mass, normal: {mean: nominal, sigma: 2 %, within: 3, min: 0.5, max: 1.5}}
  b: {path: [elements.px.profile], shared: true, levels: 4, lognormal: {mean: 1 N, sigma: 0.1 N, within: 3}}
  c: {path: elements.py.profile, triangular: {min: 0 N, mode: 1 N, max: 2 N}}
  d: {path: "bodies.block.velocity[0]", uniform: {min: 0, max: 1}}
  e: {path: "bodies.block.velocity[1]", discrete: {values: [0, 1], weights: [1, 2]}}
  f: {path: elements.px.direction, cone: {sigma: 1 deg, within: 3, about: [1, 0, 0]}}
  g: {path: "bodies.block.velocity[2]", empirical: {file: t.csv, column: v}}
  h: {path: ["bodies.block.position[0]", "bodies.block.position[1]"], shared: true, discrete: {rows: [[0, 0], [1 mm, 2 mm]]}}
correlations:
  - {between: [a, b], rho: 0.3}
outputs: [{of: [block.position, block.vx], take: max}]
curves: [{of: block.velocity, every: 50 ms}]
"""
PROBLEM = """unlatch_optimize: 1
name: all
title: every key
scenario: s.yaml
set: {step.until: 1 s}
tolerance: 1e-6
variables:
  a: {path: elements.px.profile, between: [0 N, 5 N], start: 2 N}
  b: {paths: [elements.py.profile], values: [1 N, 2 N]}
  c: {paths: ["bodies.block.position[0]", "bodies.block.position[1]"], rows: [[0, 0], [1 mm, 2 mm]], columns: [x, y]}
objectives: [{minimise: a^2}, {maximise: b}]
constraints: [far, {requirement: far, probability: 0.5}]
campaign: {file: c.yaml, samples: 4, most: 8, checks: 8}
method: auto
starts: 1
seed: 2
budget: {runs: 20, seconds: 5 s}
"""
DRAWN = "unlatch_campaign: 1\nname: drawn\nscenario: s.yaml\nsamples: 4\nparameters: {m: {path: bodies.block.mass, uniform: {min: 0.9, max: 1.1}}}\n"
FILES = {"campaign": CAMPAIGN, "optimize": PROBLEM}


def pick(value, kind, sections):
    """Returns, among alternatives, the one in which a value is written."""
    if kind.kind != "or":
        return kind
    wanted = "section" if isinstance(value, dict) else "list" if isinstance(value, list) else None
    return next((pick(value, t, sections) for t in kind.inner if t.kind == wanted), kind.inner[0])


def list_places(value, kind, sections, path=()):
    """Returns (path, name of the section) of every mapping that the table describes."""
    kind = pick(value, kind, sections)
    if kind.kind == "section":
        yield path, kind.of
        for key, inner in value.items():
            yield from list_places(inner, parse_type(sections[kind.of]["keys"][key]["is"], sections), sections, (*path, key))
    elif kind.kind == "map" and isinstance(value, dict):
        for key, inner in value.items():
            yield from list_places(inner, kind.inner[0], sections, (*path, key))
    elif kind.kind == "list" and isinstance(value, list):
        for i, inner in enumerate(value):
            yield from list_places(inner, kind.inner[0], sections, (*path, i))


def get(document, path):
    for step in path:
        document = document[step]
    return document


class SchemasTest(ProcessTest):
    def setUp(self):
        super().setUp()
        for name, text in (("s.yaml", SCENARIO.replace("dt: 100 ms", "dt: 10 ms")), ("c.yaml", DRAWN), ("t.csv", "v\n0\n1\n")):
            (self.folder / name).write_text(text)

    def check(self, document):
        path = self.folder / "file.yaml"
        path.write_text(json.dumps(document, ensure_ascii=False))
        return subprocess.run([UNLATCH, "check", path], capture_output=True, text=True)

    def find_schema_errors(self, name, document):
        schema = json.loads((SCENARIOS / f"{name}.schema.json").read_text())
        Draft202012Validator.check_schema(schema)
        return [error.message for error in Draft202012Validator(schema).iter_errors(document)]

    def test_a_file_with_every_key_is_valid_for_the_program_and_the_schema(self):
        for name, text in FILES.items():
            document, sections = load_yaml(text), load_sections(name)
            done = self.check(document)
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
            self.assertEqual(self.find_schema_errors(name, document), [])
            seen = {section: set() for section in sections}
            for path, section in list_places(document, parse_type(name, sections), sections):
                seen[section] |= set(get(document, path))
            for section, keys in seen.items():
                missing = set(sections[section]["keys"]) - keys - {"table", "above"}  # for sampling csv only; in place of `below`
                self.assertEqual(missing, set(), f"{name}: {section}")

    def test_the_programs_know_exactly_the_keys_of_the_tables(self):
        for name, text in FILES.items():
            sections = load_sections(name)
            known = {}
            for path, section in list_places(load_yaml(text), parse_type(name, sections), sections):
                document = copy.deepcopy(load_yaml(text))
                get(document, path)["zzz"] = 1
                self.assertNotEqual(self.find_schema_errors(name, document), [], f"{name}: {path}")
                done = self.check(document)
                printed = re.search(r"unknown key 'zzz' in .*?known: ([^\n]*)", done.stdout + done.stderr)
                self.assertTrue(printed, f"{name} at {path}: {done.stdout}{done.stderr}")
                known.setdefault(section, set()).update(printed[1].split(", "))
            for section, keys in known.items():
                self.assertEqual(keys, set(sections[section]["keys"]), f"{name}: {section}")

    def test_shipped_files_satisfy_the_schema_and_name_it(self):
        for name in FILES:
            files = sorted(SCENARIOS.rglob({"campaign": "campaign*.yaml", "optimize": "synthesis*.yaml"}[name]))
            self.assertGreaterEqual(len(files), 2)
            for path in files:
                text = path.read_text()
                self.assertEqual(self.find_schema_errors(name, load_yaml(text)), [], path)
                named = re.match(r"# yaml-language-server: \$schema=(\S+)\n", text)
                self.assertTrue(named, f"{path} names no schema in its first line")
                self.assertEqual((path.parent / named[1]).resolve(), (SCENARIOS / f"{name}.schema.json").resolve())


if __name__ == "__main__":
    main()
