#!/usr/bin/env python3
"""Writes everything that follows from messages.yaml: see there for the list. Output depends on that file alone.

    generate.py            writes the files
    generate.py --check    writes nothing; exit 1 and a list if a file is out of date
"""

import sys
from pathlib import Path

sys.dont_write_bytecode = True  # a check leaves nothing behind

import emit_c
import emit_cpp
import emit_docs
import emit_fields
import emit_idl
import emit_layout
import emit_lcm
from definition import DefinitionError, load

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent


def main(arguments):
    if arguments not in ([], ["--check"]):
        print(__doc__, file=sys.stderr)
        return 2
    try:
        definition = load(HERE / "messages.yaml")
    except DefinitionError as error:
        print(f"messages.yaml: {error}", file=sys.stderr)
        return 2
    files = {
        ROOT / "hil/session/messages/messages.h": emit_cpp.header(definition),
        ROOT / "hil/session/messages/messages.cc": emit_cpp.source(definition),
        HERE / "unlatch.idl": emit_idl.idl(definition),
        HERE / "unlatch_wire.h": emit_c.header(definition),
        HERE / "dds_layout.h": emit_layout.header(definition),
        ROOT / "bridge/telemetry/message_fields.h": emit_fields.header(definition),
        HERE / "README.md": emit_docs.readme(definition),
        ROOT / "bridge/CLIENTS.md": emit_docs.clients(definition, (ROOT / "bridge/CLIENTS.md").read_text(encoding="utf-8")),
        **{HERE / "lcm" / f"{s.snake()}.lcm": emit_lcm.lcm(definition, s) for s in definition.structs},
    }
    stale = [path for path, text in files.items() if not path.exists() or path.read_text() != text]
    stray = sorted(set((HERE / "lcm").glob("*.lcm")) - set(files))
    if arguments == ["--check"]:
        for path in stale:
            print(f"{path.relative_to(ROOT)} is out of date: run bridge/schema/generate.py and commit", file=sys.stderr)
        for path in stray:
            print(f"{path.relative_to(ROOT)} is of no message any more: delete it", file=sys.stderr)
        return 1 if stale or stray else 0
    for path in stale:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(files[path])
    for path in stray:
        path.unlink()
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
