#!/usr/bin/env python3
"""The table of the scenario language (hil/scenario/language/language.yaml), the files generated from it, and the loader agree.

language_test.py PROBE SOURCE_DIR [TEST...]

With EVERY_PLACE in the environment bounds and defaults are tried at every place where a key stands in everything.yaml, and 240 damaged texts
(a long test); without it at the first place of each key of a section, and 80."""

import json
import os
import pickle
import random
import re
import subprocess
import sys
import unittest
from pathlib import Path

import yaml
from jsonschema import Draft202012Validator

PROBE, SOURCE = Path(sys.argv[1]), Path(sys.argv[2])
sys.path.insert(0, str(SOURCE / "hil/scenario/language"))
sys.dont_write_bytecode = True
from language import load_sections, load_yaml, parse_type  # noqa: E402

SECTIONS = load_sections()
SCHEMA = json.loads((SOURCE / "hil/scenarios/unlatch.schema.json").read_text())
VALIDATOR = Draft202012Validator(SCHEMA)  # one, which keeps the references that it has resolved
EVERYTHING = load_yaml((SOURCE / "hil/scenario/language/everything.yaml").read_text())
COPY = pickle.dumps(EVERYTHING)  # pickle.loads() makes a copy, ten times as fast as copy.deepcopy()
PART = "".join(f"\n--- # included: {name}\n" + (SOURCE / "hil/scenario/language" / name).read_text() for name in ("everything-part.yaml", "everything.modes", "everything.csv", "everything.obj"))

# Keys that are processed before the loader's reader asks for any, so it does not list them.
NOT_OF_SCENARIOS = {"unlatch_part"}


def is_scenario(path):
    return "faults" not in path.parts and bool(re.search(r"^unlatch(_part)?:", path.read_text(), re.M))


def list_files():
    folders = ["hil/scenarios", "hil/scenario/language", "tools/unlatch/files/starters", "bridge/examples"]
    return sorted(p for folder in folders for p in (SOURCE / folder).rglob("*.yaml") if is_scenario(p))


class Probe:
    """The loader, for many questions."""

    def __init__(self):
        self.process = subprocess.Popen([PROBE], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)

    def ask(self, document):
        text = document if isinstance(document, str) else json.dumps(document, ensure_ascii=False) + PART
        self.process.stdin.write(json.dumps({"text": text}) + "\n")
        self.process.stdin.flush()
        return json.loads(self.process.stdout.readline())

    def close(self):
        self.process.stdin.close()
        self.process.stdout.close()
        self.process.wait()


def pick(value, kind):
    """Returns, among alternatives, the one in which a value is written."""
    if kind.kind != "or":
        return kind
    for t in kind.inner:
        if t.kind == "section" and isinstance(value, dict):
            section = SECTIONS[t.of]
            words = [(k, parse_type(section["keys"][k]["is"], SECTIONS).words) for k in ("type", "kind") if k in section["keys"]]
            if set(value) <= set(section["keys"]) and all(value.get(k) in w for k, w in words):
                return t
        elif t.kind in ("list", "numbers", "vector", "pair_of_bodies", "pair_of_shapes") and isinstance(value, list):
            nested = bool(value) and isinstance(value[0], list)
            if nested == (t.kind == "list") or t.inner is None:
                return t
        elif t.kind == "bool":
            if isinstance(value, bool):
                return t
        elif t.kind not in ("section", "list", "numbers", "vector", "map") and not isinstance(value, (list, dict)):
            if t.kind != "one of" or value in t.words:
                return t
    for t in kind.inner:  # a list that is no list of lists
        if t.kind == "list" and isinstance(value, list):
            return t
    raise AssertionError(f"{value} is none of its alternatives")


def walk(value, kind, path=()):
    """Every mapping of a section: (path, section's name)."""
    kind = pick(value, kind)
    if kind.kind == "section":
        yield path, kind.of
        for key, inner in value.items():
            if key in SECTIONS[kind.of]["keys"]:
                yield from walk(inner, parse_type(SECTIONS[kind.of]["keys"][key]["is"], SECTIONS), path + (key,))
    elif kind.kind == "list":
        for i, inner in enumerate(value):
            yield from walk(inner, kind.inner[0], path + (i,))
    elif kind.kind == "map":
        for key, inner in value.items():
            yield from walk(inner, kind.inner[0], path + (key,))


def get(document, path):
    for part in path:
        document = document[part]
    return document


def changed(path, change):
    document = pickle.loads(COPY)
    change(get(document, path))
    return document


WRONG = "kg2 m3 s5 rad7"  # unit of no quantity
FREE = {"for", "parameters", "set"}  # keys whose values may have any shape
PLACES = list(walk(EVERYTHING, parse_type("scenario", SECTIONS)))


def list_tried_places():
    """(path, section's name, key) of bounds and defaults; see above."""
    seen = set()
    for path, name in PLACES:
        for key in list(get(EVERYTHING, path)):
            if "EVERY_PLACE" in os.environ or (name, key) not in seen:
                seen.add((name, key))
                yield path, name, key


def alternatives():
    """Sections that are alternatives somewhere: the loader asks for the keys of all before it knows the section."""
    groups = []
    for section in SECTIONS.values():
        for key in section["keys"].values():
            kind = parse_type(key["is"], SECTIONS)
            while kind.kind in ("list", "map"):
                kind = kind.inner[0]
            if kind.kind == "or":
                groups.append({t.of for t in kind.inner if t.kind == "section"})
    return groups


class LanguageTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.probe = Probe()

    @classmethod
    def tearDownClass(cls):
        cls.probe.close()

    def find_schema_errors(self, document):
        # An editor reads the document as JSON.
        return [e.message for e in VALIDATOR.iter_errors(document)]

    # Errors of a change to EVERYTHING, which satisfies the schema as a whole. At the top the schema asks for keys and sees each of their
    # values apart, and of a map or a list there each entry apart, so that only the changed ones are read again, and those that it asks for.
    def find_errors_of_change(self, document):
        required = {"unlatch", "name", "step", "bodies", "include"}
        changes = {}
        for key, value in document.items():
            old = EVERYTHING.get(key)
            if key in required or value != old:
                changes[key] = self.keep_changed_entries(value, old) if key in SECTIONS["scenario"]["keys"] and parse_type(SECTIONS["scenario"]["keys"][key]["is"], SECTIONS).kind in ("map", "list") else value
        return self.find_schema_errors(changes)

    def keep_changed_entries(self, value, old):
        if isinstance(value, dict) and isinstance(old, dict):
            return {name: inner for name, inner in value.items() if name not in old or inner != old[name]} or dict(list(value.items())[:1])
        if isinstance(value, list) and isinstance(old, list) and len(value) == len(old):
            return [inner for inner, before in zip(value, old) if inner != before] or value[:1]
        return value

    def test_schema_and_reference_are_made_of_the_table(self):
        done = subprocess.run([sys.executable, "-B", SOURCE / "hil/scenario/language/generate.py", "--check"], capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        Draft202012Validator.check_schema(SCHEMA)

    # A value may be called as a section is: `contact`, the type of a sensor.
    def test_values_in_the_reference_are_no_links_and_types_are(self):
        reference = (SOURCE / "hil/scenarios/REFERENCE.md").read_text()
        values = re.findall(r"\bone of (.*?)(?: or | \|)", reference)
        self.assertGreater(len(values), 50)
        self.assertEqual([words for words in values if "[" in words], [])
        self.assertIn("| `type` | one of contact |", reference)
        self.assertIn("| one of fail catch_up slip skip_output or [catch_up](#overruns) |", reference)

    def test_shipped_scenarios_satisfy_the_schema_and_name_it(self):
        files = list_files()
        self.assertGreaterEqual(len(files), 10)
        for path in files:
            text = path.read_text()
            self.assertEqual(self.find_schema_errors(load_yaml(text)), [], path)
            named = re.match(r"# yaml-language-server: \$schema=(\S+)\n", text)
            self.assertTrue(named, f"{path} names no schema in its first line")
            if "starters" not in path.parts:  # starters get a schema beside them
                self.assertEqual((path.parent / named[1]).resolve(), SOURCE / "hil/scenarios/unlatch.schema.json")

    def test_everything_loads_and_has_every_key(self):
        self.assertNotIn("mistakes", self.probe.ask(EVERYTHING))
        seen = {name: set() for name in SECTIONS}
        for path, name in PLACES:
            seen[name] |= set(get(EVERYTHING, path))
        for name, section in SECTIONS.items():
            missing = set(section["keys"]) - seen[name] - NOT_OF_SCENARIOS
            if name == "rate":  # as in group
                missing -= {"period"}
            self.assertEqual(missing, set(), f"everything.yaml has none of these keys of {name}")

    # An unknown key at every place: the loader lists all keys that it would have accepted there.
    def test_the_loader_knows_exactly_the_keys_of_the_table(self):
        known = {}
        document = pickle.loads(COPY)
        for k, (path, name) in enumerate(PLACES):
            get(document, path)[f"zzz{k}"] = 1
        mistakes = {}
        for mistake in self.probe.ask(document).get("mistakes", []):
            if found := re.match(r"unknown key 'zzz(\d+)' in ", mistake["what"]):
                mistakes.setdefault(int(found[1]), []).append(mistake)
        for k, (path, name) in enumerate(PLACES):
            self.assertEqual(len(mistakes.get(k, [])), 1, f"{name} at {path}: {mistakes.get(k)}")
            known.setdefault(name, set()).update(re.search(r"known: (.*)$", mistakes[k][0]["mend"])[1].split(", "))
        groups = alternatives()
        for name, found in known.items():
            keys = set(SECTIONS[name]["keys"]) - NOT_OF_SCENARIOS
            together = [g for g in groups if name in g] or [{name}]
            allowed = set().union(*(SECTIONS[n]["keys"] for g in together for n in g))
            self.assertLessEqual(keys, found, f"{name}: the loader does not ask for these")
            self.assertLessEqual(found, allowed, f"{name}: the table lacks these")
        self.assertEqual(set(known), set(SECTIONS))

    def test_the_loader_expects_the_units_of_the_table(self):
        asked = []
        together = pickle.loads(COPY)  # with all of them wrong, each with a number of its own
        for path, name in PLACES:
            for key in get(EVERYTHING, path):
                entry = SECTIONS[name]["keys"][key]
                kind = pick(get(EVERYTHING, path)[key], parse_type(entry["is"], SECTIONS))
                if kind.kind not in ("number", "whole", "vector", "numbers") or str(get(EVERYTHING, path)[key]).startswith("<"):
                    continue
                wrong = f"{1000 + len(asked)} {WRONG}"
                wrong = wrong if kind.kind in ("number", "whole") else [wrong] + get(EVERYTHING, path)[key][1:]
                asked.append((path, name, key, wrong))
                get(together, path)[key] = wrong
        mistakes = self.probe.ask(together).get("mistakes", [])
        for k, (path, name, key, wrong) in enumerate(asked):
            mends = [m["mend"] for m in mistakes if f"{1000 + k} {WRONG}" in m["what"]]
            if not mends:  # something else is wrong with its section then
                mends = [m["mend"] for m in self.probe.ask(changed(path, lambda node: node.update({key: wrong}))).get("mistakes", [])]
            units = [re.match(r"write a (?:plain number|number in ([^,]+))", m) for m in mends]
            units = {m[1] or "" for m in units if m}
            expected = SECTIONS[name]["keys"][key].get("unit", "")
            if name == "channel" or expected.startswith("that of"):
                expected = " or ".join(units)  # another key determines it
            self.assertLessEqual(units, set(expected.split(" or ")), f"{name}.{key}")
            self.assertTrue(units, f"{name}.{key}: {mends}")
        self.assertGreater(len(asked), 80)

    def test_loader_and_schema_keep_the_bounds_of_the_table(self):
        tried = 0
        for path, name, key in list_tried_places():
            entry = SECTIONS[name]["keys"][key]
            if pick(get(EVERYTHING, path)[key], parse_type(entry["is"], SECTIONS)).kind not in ("number", "whole"):
                continue
            beyond = [entry["above"]] if "above" in entry else []
            beyond += [entry["least"] - max(1e-3, abs(entry["least"]))] if "least" in entry else []
            beyond += [entry["most"] * 1.5] if "most" in entry else []
            for value in beyond:
                document = changed(path, lambda node: node.update({key: value}))
                self.assertIn("mistakes", self.probe.ask(document), f"{name}.{key} = {value}")
                self.assertTrue(self.find_errors_of_change(document), f"{name}.{key} = {value}")
                tried += 1
        self.assertGreater(tried, 25)

    def test_defaults_are_those_of_the_table(self):
        compared = 0
        for path, name, key in list_tried_places():
            entry = SECTIONS[name]["keys"][key]
            default = entry.get("default")
            if isinstance(default, str):
                kind = parse_type(entry["is"], SECTIONS)
                words = kind.words if kind.kind == "one of" else []
                default = load_yaml(default) if default[0] in "[{" else default if default in words else None
            if default is None:
                continue
            without = self.probe.ask(changed(path, lambda node: node.pop(key)))
            given = self.probe.ask(changed(path, lambda node: node.update({key: default})))
            self.assertEqual(without, given, f"{name}.{key}: {default}")
            compared += "scenario" in given
        self.assertGreater(compared, 50)

    # Random damage: the loader refuses every text that the schema refuses, and the schema every text whose shape the loader
    # refuses.
    def test_schema_and_loader_refuse_the_same_shapes(self):
        seed = 20261
        rng = random.Random(seed)
        shapes = re.compile(
            r"unknown key|has no (?!value|shape|mode( |$))|of the wrong type|has both| needs |is not a list|is not a name|is not a mapping|not a pair|"
            r"an? list of \d|not a list of|is not a truth value|cannot be the name|two axes|names no file|"
            r"unknown (policy|row|axis|joint kind|element type|sensor type|frame|action|condition) '")
        refused = 0
        mapping = [p for p in self.list_paths(EVERYTHING) if p and not FREE & set(p) and p[0] != "include"]
        count = 240 if "EVERY_PLACE" in os.environ else 80
        for i in range(count):
            path = rng.choice(mapping)
            document = pickle.loads(COPY)
            for key in ("set", "include"):  # with these, a missing key may come from elsewhere
                document.pop(key)
            parent, key, what = get(document, path[:-1]), path[-1], rng.randrange(6)
            if path[-2:-1] == ("bias",):  # how many numbers it has depends on the sensor's kind, which a schema does not see
                continue
            if what == 0:
                parent.pop(key)
            elif what == 1 and isinstance(parent, dict):
                parent[key + "x"] = parent.pop(key)
            elif what == 2:
                parent[key] = [parent[key]]
            elif what == 3:
                parent[key] = {"a": parent[key]}
            elif what == 4:
                parent[key] = "no such thing!"
            else:
                parent[key] = 7.5
            mistakes = [m["what"] for m in self.probe.ask(document).get("mistakes", [])]
            errors = self.find_errors_of_change(document)
            note = f"seed {seed}, {i}: {what} at {path}: {mistakes} against {errors}"
            if any(shapes.search(m) for m in mistakes):
                self.assertTrue(errors, note)
            if errors:
                self.assertTrue(mistakes, note)
                refused += 1
        self.assertGreater(refused, count / 3)

    # `y` is the exception: PyYAML, libyaml and similar tools read it as a word.
    def test_no_key_and_no_word_means_something_else_in_yaml_1_1(self):
        words = {word for section in SECTIONS.values() for word in section["keys"]}
        for section in SECTIONS.values():
            for key in section["keys"].values():
                words |= self.list_words(parse_type(key["is"], SECTIONS))
        words |= set(load_yaml((SOURCE / "hil/scenario/language/language.yaml").read_text())["sections"])
        for word in sorted(words - {"1"}):
            self.assertEqual(yaml.safe_load(word), word)
            self.assertNotIn(word.lower(), ("yes", "no", "on", "off", "n", "true", "false", "null"))

    def list_words(self, kind):
        words = set(kind.words)
        return words.union(*(self.list_words(inner) for inner in kind.inner or []))

    def test_shipped_files_mean_the_same_in_yaml_1_1(self):
        folders = ["hil", "tools", "bridge", "tests/data", "tests/fuzz/corpus"]
        files = sorted(p for folder in folders for p in (SOURCE / folder).rglob("*.yaml") if "node_modules" not in p.parts)
        self.assertGreater(len(files), 25)
        for path in files:
            try:
                new = load_yaml(path.read_text())
            except yaml.YAMLError:
                self.assertIn("corpus", path.parts)  # an intentionally damaged input
                continue
            self.assert_same(new, yaml.safe_load(path.read_text()), str(path))

    def assert_same(self, new, old, where):
        if isinstance(new, dict):
            self.assertEqual(list(new), list(old), where)
            for key in new:
                self.assert_same(new[key], old[key], f"{where}: {key}")
        elif isinstance(new, list):
            self.assertEqual(len(new), len(old), where)
            for i, (a, b) in enumerate(zip(new, old)):
                self.assert_same(a, b, f"{where}[{i}]")
        elif isinstance(new, float) and isinstance(old, str):  # 1e3: a number in YAML 1.2, a word in 1.1, written back as it is
            self.assertEqual(new, float(old), where)
        else:
            self.assertEqual((type(new), new), (type(old), old), where)

    def test_words_of_yaml_1_1_are_no_names_to_loader_and_schema(self):
        for word in ("yes", "No", "ON", "off", "null", "True"):
            document = pickle.loads(COPY)
            document["name"] = word
            mistakes = self.probe.ask(document).get("mistakes", [])
            self.assertTrue(any("is not a name" in m["what"] and "YAML 1.1" in m["mend"] for m in mistakes), mistakes)
            self.assertTrue(self.find_schema_errors(document), word)
        self.assertFalse(any(re.fullmatch(word, "y") for word in [SCHEMA["$defs"]["name"]["not"]["pattern"]]))

    def list_paths(self, value, path=()):
        yield path
        inner = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
        for key, item in inner:
            yield from self.list_paths(item, path + (key,))


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0]] + sys.argv[3:])
