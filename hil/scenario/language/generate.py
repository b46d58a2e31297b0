#!/usr/bin/env python3
"""Writes hil/scenarios/REFERENCE.md and unlatch.schema.json from language.yaml, campaign.schema.json and optimize.schema.json from
campaign.yaml and optimize.yaml, and number_keys.h, the bounds of numbers, from all three. --check: only reports whether they are current."""

import json
import re
import sys
from pathlib import Path

import yaml

sys.path.insert(0, str(Path(__file__).resolve().parent))
from language import HERE, load_sections, parse_type  # noqa: E402

OUT = HERE.parents[1] / "scenarios"
NAME = r"^[A-Za-z<][A-Za-z0-9_<>-]*$"
SHAPES = r"^[A-Za-z<][A-Za-z0-9_<>-]*([.][A-Za-z<][A-Za-z0-9_<>-]*)?$"  # body, body.shape, body.group
# Words that YAML 1.1 tools read as true, false or null; they are no names (is_name in yaml_reader.cc).
NOT_A_NAME = "^(" + "|".join("".join(f"[{c.upper()}{c}]" for c in word) for word in ("true", "false", "yes", "no", "on", "off", "null")) + ")$"
EXPRESSION = r"^[A-Za-z0-9_.,+*/^()<>%°µμ·⋅×²³−√ -]+$"
PARAMETER = r"^<[A-Za-z][A-Za-z0-9_-]*>$"

# --- The schema ------------------------------------------------------------------------------------------------------


class Schema:
    def __init__(self, sections):
        self.sections = sections

    def build_defs(self, top):
        """Definitions of all types, and of all sections but the top one."""
        defs = {
            "quantity": {"anyOf": [{"type": "number"}, {"type": "string", "pattern": EXPRESSION}]},
            "name": {"type": "string", "pattern": NAME, "not": {"pattern": NOT_A_NAME}},
            "parameter": {"type": "string", "pattern": PARAMETER},
            "pair_of_bodies": {"type": "array", "items": {"$ref": "#/$defs/name"}, "minItems": 2, "maxItems": 2},
            "shapes": {"type": "string", "pattern": SHAPES, "not": {"pattern": NOT_A_NAME}},
            "pair_of_shapes": {"type": "array", "items": {"$ref": "#/$defs/shapes"}, "minItems": 2, "maxItems": 2},
            "rotation": {"type": "array", "prefixItems": [{"enum": ["x", "y", "z"]}, {"$ref": "#/$defs/quantity"}],
                         "items": False, "minItems": 2},
        }
        return {**defs, **{name: self.of_section(section) for name, section in self.sections.items() if name != top}}

    def build_plain(self, top):
        return {"$schema": "https://json-schema.org/draft/2020-12/schema", "title": f"unlatch {top}",
                **self.of_section(self.sections[top]), "$defs": self.build_defs(top)}

    def build(self):
        defs = self.build_defs("scenario")
        top = self.of_section(self.sections["scenario"])
        required = top.pop("required")
        required.remove("unlatch")
        return {"$schema": "https://json-schema.org/draft/2020-12/schema", "title": "unlatch scenario", **top,
                "oneOf": [{"required": ["unlatch"]}, {"required": ["unlatch_part"]}],
                "if": {"anyOf": [{"required": ["unlatch_part"]}, {"required": ["include"]}]}, "else": {"required": required},
                "$defs": defs}

    def of_section(self, section):
        keys = section["keys"]
        out = {"type": "object", "additionalProperties": False,
               "properties": {name: self.of_key(key) for name, key in keys.items()}}
        if "about" in section:
            out["description"] = section["about"]
        required = [name for name, key in keys.items() if key.get("need")]
        if required:
            out["required"] = required
        if "at_least" in section:
            out["minProperties"] = section["at_least"]
        groups = [{"oneOf": [{"required": [name]} for name in group]} for group in section.get("one_of", [])]
        if groups:
            out["allOf"] = groups
        return out

    def of_key(self, key):
        bounds = {to: key[of] for of, to in (("above", "exclusiveMinimum"), ("least", "minimum"), ("most", "maximum")) if of in key}
        out = self.of_type(parse_type(key["is"], self.sections), bounds)
        out["description"] = describe(key)
        return out

    def of_type(self, kind, bounds):
        inner = [self.of_type(t, bounds) for t in kind.inner or []]
        quantity = {"$ref": "#/$defs/quantity", **bounds}
        parameter = {"$ref": "#/$defs/parameter"}
        if kind.kind == "or":
            return {"anyOf": inner}
        if kind.kind == "list":
            return {"anyOf": [{"type": "array", "items": inner[0]}, parameter]}
        if kind.kind == "map":
            named = {} if kind.inner[0].kind == "anything" else {"propertyNames": {"$ref": "#/$defs/name"}}
            return {"type": "object", "additionalProperties": inner[0], **named}
        if kind.kind == "one of":
            words = [int(word) if word.isdigit() else word for word in kind.words]
            return {"anyOf": [{"enum": words}, parameter]} if isinstance(words[0], str) else {"enum": words}
        return {
            "number": lambda: quantity, "whole": lambda: quantity,
            "bool": lambda: {"anyOf": [{"enum": [True, False, "true", "false", "on", "off"]}, parameter]},
            "text": lambda: {"type": ["string", "number", "boolean"]}, "name": lambda: {"$ref": "#/$defs/name"}, "anything": lambda: {},
            "vector": lambda: self.numbers(3), "numbers": lambda: self.numbers(kind.of),
            "pair_of_bodies": lambda: {"anyOf": [{"$ref": "#/$defs/pair_of_bodies"}, parameter]},
            "pair_of_shapes": lambda: {"anyOf": [{"$ref": "#/$defs/pair_of_shapes"}, parameter]},
            "rotation": lambda: {"$ref": "#/$defs/rotation"}, "section": lambda: {"$ref": f"#/$defs/{kind.of}"},
        }[kind.kind]()

    @staticmethod
    def numbers(count):
        counted = {"minItems": count, "maxItems": count} if count else {}
        return {"anyOf": [{"type": "array", "items": {"$ref": "#/$defs/quantity"}, **counted}, {"$ref": "#/$defs/parameter"}]}


def describe(key):
    """Returns the one-line description that editors show."""
    facts = [key["unit"]] if "unit" in key else []
    facts += [bounds] if (bounds := describe_range(key)) else []
    facts += ["required"] if key.get("need") else [f"default {get_default(key)}"] if "default" in key else []
    return key["about"] + (f" ({', '.join(facts)})" if facts else "")


def describe_range(key):
    parts = []
    if "above" in key:
        parts.append(f"> {key['above']:g}")
    if "least" in key:
        parts.append(f"≥ {key['least']:g}")
    if "most" in key:
        parts.append(f"≤ {key['most']:g}")
    return ", ".join(parts)


def get_default(key):
    default = key["default"]
    return str(default).lower() if isinstance(default, bool) else str(default)


# --- The reference ---------------------------------------------------------------------------------------------------

HEAD = """# Scenario reference

Written by `hil/scenario/language/generate.py` from [language.yaml](../scenario/language/language.yaml); the language by example is [README.md](README.md).
Editors complete and check a scenario that begins with `# yaml-language-server: $schema=` and the path of
[unlatch.schema.json](unlatch.schema.json).

Numbers are SI and radians; expressions may have units. *Unit* "–" is a plain number or none. A *bool* is `true` or `false`;
`on` and `off` are accepted as well. Examples are from
[everything.yaml](../scenario/language/everything.yaml), which has every key once.
"""


def collect_examples(sections):
    """Returns the text of the first mapping of each section in everything.yaml."""
    text = (HERE / "everything.yaml").read_text()
    examples = {}

    def visit(node, kind):
        if kind.kind == "or":
            visit(node, pick(node, kind))
        elif kind.kind == "section" and isinstance(node, yaml.MappingNode):
            if kind.of not in examples:
                start = node.start_mark.index - node.start_mark.column
                lines = text[start:node.end_mark.index].rstrip().split("\n")
                if node.flow_style:
                    lines = [text[node.start_mark.index:node.end_mark.index]]
                indent = min(len(line) - len(line.lstrip()) for line in lines)
                examples[kind.of] = "\n".join(line[indent:] for line in lines if not line.lstrip().startswith("#"))
            for key, value in node.value:
                if key.value in sections[kind.of]["keys"]:
                    visit(value, parse_type(sections[kind.of]["keys"][key.value]["is"], sections))
        elif kind.kind == "list" and isinstance(node, yaml.SequenceNode):
            for item in node.value:
                visit(item, kind.inner[0])
        elif kind.kind == "map" and isinstance(node, yaml.MappingNode):
            for _, value in node.value:
                visit(value, kind.inner[0])

    def pick(node, kind):
        """Returns the section, among alternatives, that has the keys and the `type` or `kind` of this node."""
        if not isinstance(node, yaml.MappingNode):
            return next((t for t in kind.inner if t.kind != "section"), kind.inner[0])
        keys = {key.value: value for key, value in node.value}
        for t in kind.inner:
            if t.kind != "section" or not set(keys) <= set(sections[t.of]["keys"]):
                continue
            marks = [sections[t.of]["keys"][k]["is"].split()[2:] for k in ("type", "kind") if k in sections[t.of]["keys"]]
            if all(keys[k].value in words for k, words in zip([k for k in ("type", "kind") if k in keys], marks)):
                return t
        raise ValueError(f"line {node.start_mark.line + 1} of everything.yaml is in no section")

    visit(yaml.compose(text), parse_type("scenario", sections))
    return examples


def write_reference(sections):
    examples = collect_examples(sections)
    parts = [HEAD]
    for name, section in sections.items():
        parts.append(f"\n## {section['title']}\n")
        if "about" in section:
            parts.append(section["about"] + "\n")
        notes = [f"Exactly one of {', '.join(f'`{key}`' for key in group)}." for group in section.get("one_of", [])]
        if notes:
            parts.append(" ".join(notes) + "\n")
        parts.append("| key | is | unit | range | default | meaning |\n|---|---|---|---|---|---|")
        for key_name, key in section["keys"].items():
            default = "**required**" if key.get("need") else get_default(key) if "default" in key else "–"
            cells = [f"`{key_name}`", link(str(key["is"]), sections), str(key.get("unit", "–")), describe_range(key) or "–", default, key["about"]]
            parts.append("| " + " | ".join(cells) + " |")
        if name != "scenario" and name in examples:
            parts.append("\n" + "\n".join("    " + line for line in examples[name].split("\n")))
    return "\n".join(parts) + "\n"


def link(kind, sections):
    """Returns types with links to their sections. Values after `one of` and the kind after `name of` are no types."""
    def link_alternative(text):
        types, plain = re.fullmatch(r"(.*?)((?:(?:one|name) of .*)?)", text).groups()
        return re.sub(r"\w+", link_word, types).replace("_of_", " of ") + plain

    def link_word(match):
        word = match[0]
        return f"[{word}](#{anchor(sections[word]['title'])})" if word in sections else word

    return " or ".join(link_alternative(text) for text in kind.split(" or "))


def anchor(title):
    kept = "".join(c for c in title.lower() if c.isalnum() or c in " _-")
    return kept.replace(" ", "-")


# --- The bounds that the readers use ----------------------------------------------------------------------------------

HEADER = """// Numbers of the language that have a least or a greatest value, for read_bounded() (bounded_number.h). Written by generate.py
// from language.yaml, campaign.yaml and optimize.yaml, which alone state these bounds.
// clang-format off
#pragma once

#include <limits>

#include "hil/scenario/language/number_key.h"

namespace unlatch::hil {

inline constexpr NumberKey kNumberKeys[] = {
"""


def write_number_keys(tables):
    lines = []
    for table, sections in tables.items():
        for section_name, section in sections.items():
            for key_name, key in section["keys"].items():
                kinds = str(key["is"]).split(" or ")
                kind, unit = kinds[0], str(key.get("unit", ""))
                if kind not in ("number", "whole") or " or " in unit or unit.startswith("that of") or not {"least", "most", "above"} & key.keys():
                    continue
                least = key.get("above", key.get("least"))
                limits = "std::numeric_limits<double>::infinity()"
                lines.append(f'    {{"{table}.{section_name}.{key_name}", "{unit}", {f"-{limits}" if least is None else repr(float(least))}, '
                             f'{repr(float(key["most"])) if "most" in key else limits}, {"true" if "above" in key else "false"}, '
                             f'{"true" if kind == "whole" else "false"}}},\n')
    return HEADER + "".join(lines) + "};\n\n}  // namespace unlatch::hil\n"


def main():
    sections = load_sections()
    files = {OUT / "unlatch.schema.json": json.dumps(Schema(sections).build(), indent=1, ensure_ascii=False) + "\n",
             OUT / "REFERENCE.md": write_reference(sections),
             HERE / "number_keys.h": write_number_keys({"scenario": sections, "campaign": load_sections("campaign"), "optimize": load_sections("optimize")})}
    for top in ("campaign", "optimize"):
        schema = Schema(load_sections(top)).build_plain(top)
        files[OUT / f"{top}.schema.json"] = json.dumps(schema, indent=1, ensure_ascii=False) + "\n"
    stale = [path for path, text in files.items() if not path.exists() or path.read_text() != text]
    if "--check" not in sys.argv:
        for path in stale:
            path.write_text(files[path])
        return 0
    for path in stale:
        table = path.name.replace(".schema.json", ".yaml") if path.name.startswith(("campaign", "optimize")) else "language.yaml"
        print(f"{path.name} is not what {table} says: run hil/scenario/language/generate.py", file=sys.stderr)
    return 1 if stale else 0


if __name__ == "__main__":
    sys.exit(main())
