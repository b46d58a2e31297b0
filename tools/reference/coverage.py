#!/usr/bin/env python3
"""Public names and their descriptions, from Doxygen's XML. Exit code 1 if a public name has no description.

    coverage.py XML_FOLDER [FOLDER_OF_THE_HEADERS]

Counted: namespaces' types, functions, constants and aliases; public members, enumerations and their values. Not counted:
operators, destructors, constructors without parameters, copying, and what is defaulted or deleted: their names say it.
Enumerators, and the data of a struct, may be described as a whole: by the comment of the enumeration or struct, if none of
them has a comment of its own.
"""
import sys
import xml.etree.ElementTree as ElementTree
from pathlib import Path


def is_described(node):
    texts = (node.find("briefdescription"), node.find("detaileddescription"))
    return any(text is not None and "".join(text.itertext()).strip() for text in texts)


def is_self_explaining(member, owner):
    name, arguments = member.findtext("name"), member.findtext("argsstring") or ""
    parameters = arguments[1:arguments.rfind(")")].strip() if ")" in arguments else ""
    simple = owner.rsplit("::", 1)[-1]
    copies = name == simple and parameters.split("&")[0].replace("const", "").strip() == simple
    return (name.startswith(("operator", "~")) or arguments.endswith(("=default", "=delete")) or
            (name == simple and not parameters) or copies)


def place(node):
    location = node.find("location")
    return f"{location.get('file')}:{location.get('line')}"


class Coverage:
    def __init__(self):
        self.described, self.missing = set(), {}

    def count(self, name, node, described):
        if described:
            self.described.add(name)
            self.missing.pop(name, None)
        elif name not in self.described:
            self.missing[name] = place(node)

    def read_compound(self, compound):
        kind, owner = compound.get("kind"), compound.findtext("compoundname")
        if kind in ("class", "struct", "union"):
            if compound.get("prot", "public") != "public":
                return
            self.count(owner, compound, is_described(compound))
        elif kind not in ("namespace", "file"):
            return
        members = [m for m in compound.iter("memberdef") if m.get("prot") == "public" and m.get("kind") != "friend"]
        data = [m for m in members if m.get("kind") == "variable"]
        whole = kind in ("class", "struct", "union") and is_described(compound) and not any(map(is_described, data))
        for member in members:
            if is_self_explaining(member, owner):
                continue
            prefix = "" if kind == "file" else f"{owner}::"
            name = prefix + member.findtext("name")
            described = is_described(member)
            self.count(name, member, described or (whole and member in data))
            values = member.findall("enumvalue")
            as_a_whole = described and not any(map(is_described, values))
            for value in values:
                self.count(f"{name}::{value.findtext('name')}", member, as_a_whole or is_described(value))


def main():
    coverage = Coverage()
    prefix = f"{sys.argv[2]}/" if len(sys.argv) > 2 else ""
    for path in sorted(Path(sys.argv[1]).glob("*.xml")):
        for compound in ElementTree.parse(path).getroot().iter("compounddef"):
            coverage.read_compound(compound)
    total = len(coverage.described) + len(coverage.missing)
    for name, where in coverage.missing.items():
        print(f"{prefix}{where}: {name} has no description", file=sys.stderr)
    print(f"{len(coverage.described)} of {total} public names have a description")
    return 1 if coverage.missing or total == 0 else 0


if __name__ == "__main__":
    sys.exit(main())
