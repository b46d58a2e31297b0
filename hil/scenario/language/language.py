"""The table of the scenario language as Python objects, and YAML with the simulator's rules."""

import re
from pathlib import Path

import yaml

HERE = Path(__file__).resolve().parent


class Loader(getattr(yaml, "CSafeLoader", yaml.SafeLoader)):
    """YAML 1.2's scalars, as editors and yaml-cpp read them: `on` is a word, 1e3 a number. Libyaml, where PyYAML has it, is several
    times as fast."""


Loader.yaml_implicit_resolvers = {}
Loader.add_implicit_resolver("tag:yaml.org,2002:bool", re.compile(r"^(?:true|false)$"), list("tf"))
Loader.add_implicit_resolver("tag:yaml.org,2002:null", re.compile(r"^(?:~|null|)$"), ["~", "n", ""])
Loader.add_implicit_resolver("tag:yaml.org,2002:int", re.compile(r"^[-+]?[0-9]+$"), list("-+0123456789"))
Loader.add_implicit_resolver(
    "tag:yaml.org,2002:float",
    re.compile(r"^[-+]?(?:\.[0-9]+|[0-9]+(?:\.[0-9]*)?)(?:[eE][-+]?[0-9]+)?$"), list("-+.0123456789"))
# PyYAML's own constructor expects the digits of YAML 1.1; numbers of YAML 1.2 are Python's.
Loader.add_constructor("tag:yaml.org,2002:int", lambda loader, node: int(node.value))
Loader.add_constructor("tag:yaml.org,2002:float", lambda loader, node: float(node.value))


def load_yaml(text):
    return yaml.load(text, Loader)


def load_sections(name="language"):
    """Sections of scenarios ("language"), of campaign files ("campaign"), or of problems of `unlatch optimize` ("optimize")."""
    return load_yaml((HERE / f"{name}.yaml").read_text())["sections"]


class Type:
    """Parses `is` of a key: kind number, whole, bool, text, name, vector, anything, numbers (count), one of (words), list, map, section, or."""

    def __init__(self, kind, inner=None, words=(), of=None):
        self.kind, self.inner, self.words, self.of = kind, inner, list(words), of


def parse_type(text, sections):
    text = str(text)
    if text.startswith(("list of ", "map of ")):  # binds wider than `or`
        kind, rest = text.split(" of ", 1)
        return Type(kind, [parse_type(rest, sections)])
    if " or " in text:
        first, rest = text.split(" or ", 1)
        tail = parse_type(rest, sections)
        return Type("or", [parse_type(first, sections)] + (tail.inner if tail.kind == "or" else [tail]))
    if text.startswith("one of "):
        return Type("one of", words=text.split()[2:])
    if text.startswith("name of "):
        return Type("name", of=text.split()[2])
    if text.startswith("numbers"):
        return Type("numbers", of=int(text.split()[1]) if " " in text else 0)
    if text in ("number", "whole", "bool", "text", "name", "vector", "anything", "pair_of_bodies", "pair_of_shapes", "rotation"):
        return Type(text)
    if text not in sections:
        raise ValueError(f"no type '{text}'")
    return Type("section", of=text)
