"""Reads messages.yaml into plain objects and refuses what the generators' targets cannot carry."""

import json
import re
from dataclasses import dataclass, field
from pathlib import Path

import yaml

SIZES = {"int64": 8, "double": 8, "int32": 4, "octet": 1}
LCM_TYPES = {"int64": "int64_t", "double": "double", "int32": "int32_t", "octet": "byte"}
ROLES = {"simulator", "participant"}


class DefinitionError(Exception):
    """A mistake in messages.yaml, with its place."""


@dataclass
class Field:
    name: str
    type: str
    array: str | None  # name of the constant that is its length
    unit: str | None
    enum: str | None
    range: list | None
    key: bool
    comment: str


@dataclass
class Struct:
    name: str
    sender: str | None  # None: a part of messages, not a message
    comment: str
    fields: list[Field]
    size: int = 0  # bytes, of the struct and of its fields on the wire
    fingerprint: int = 0  # LCM's, unsigned

    @property
    def cpp(self):
        """The C++ struct's name: no type of the kernel has it (unlatch::State is the kernel's state)."""
        return f"{self.name}Message"

    def snake(self):
        return re.sub(r"(?<!^)(?=[A-Z])", "_", self.name).lower()


@dataclass
class Definition:
    version: int
    constants: dict[str, int]
    constant_comments: dict[str, str]
    enums: dict[str, dict[str, int]]
    structs: list[Struct]  # parts first
    hash: int = 0  # unsigned, 64 bits
    by_name: dict[str, Struct] = field(default_factory=dict)

    def messages(self):
        return [s for s in self.structs if s.sender]

    def number(self, value):
        """A number, or the value of a named constant."""
        return self.constants[value] if isinstance(value, str) else value


def load(path: Path) -> Definition:
    raw = yaml.safe_load(path.read_text())
    definition = Definition(
        version=raw["version"],
        constants={name: c["value"] for name, c in raw["constants"].items()},
        constant_comments={name: c["comment"] for name, c in raw["constants"].items()},
        enums=raw["enums"],
        structs=[],
    )
    for group in ("structs", "messages"):
        for name, body in raw[group].items():
            struct = Struct(name, body.get("from"), body["comment"], [_field(name, f) for f in body["fields"]])
            if (group == "messages") != (struct.sender in ROLES):
                raise DefinitionError(f"{name}: 'from' must be one of {sorted(ROLES)} for messages, absent for structs")
            _check(definition, struct)
            struct.fingerprint = _lcm_fingerprint(definition, struct)
            definition.structs.append(struct)
            definition.by_name[name] = struct
    definition.hash = _schema_hash(definition)
    return definition


def _field(struct: str, raw: dict) -> Field:
    unknown = set(raw) - {"name", "type", "array", "unit", "enum", "range", "key", "comment"}
    if unknown:
        raise DefinitionError(f"{struct}.{raw.get('name')}: unknown {sorted(unknown)}")
    return Field(raw["name"], raw["type"], raw.get("array"), raw.get("unit"), raw.get("enum"), raw.get("range"),
                 raw.get("key", False), raw.get("comment", ""))


def _check(definition: Definition, struct: Struct):
    """Descending alignment and a size that is a multiple of it: then no compiler adds padding."""
    if struct.sender and [(f.name, f.type) for f in struct.fields[:2]] != [("session", "int64"), ("sequence", "int64")]:
        raise DefinitionError(f"{struct.name}: a message begins with session and sequence, both int64")
    previous = 8
    for f in struct.fields:
        where = f"{struct.name}.{f.name}"
        part = definition.by_name.get(f.type)
        if f.type not in SIZES and part is None:
            raise DefinitionError(f"{where}: type '{f.type}' is neither of {sorted(SIZES)} nor a struct above")
        if f.array is not None and f.array not in definition.constants:
            raise DefinitionError(f"{where}: array length '{f.array}' is not one of the constants")
        if f.enum is not None and (f.enum not in definition.enums or f.type != "int32"):
            raise DefinitionError(f"{where}: enum '{f.enum}' must be defined, on an int32")
        if f.type == "double" and not f.unit:
            raise DefinitionError(f"{where}: a double needs a unit ('1' for none)")
        if f.range is not None and (f.type != "int32" or f.array):
            raise DefinitionError(f"{where}: a range is for a single int32")
        alignment = 8 if part else SIZES[f.type]
        if alignment > previous:
            raise DefinitionError(f"{where}: move it up, fields go from 8-byte ones to octets")
        previous = alignment
        struct.size += (part.size if part else SIZES[f.type]) * (definition.constants[f.array] if f.array else 1)
    if struct.size % 8:
        raise DefinitionError(f"{struct.name}: {struct.size} bytes is not a multiple of 8, add a reserved field")
    for name, values in definition.enums.items():
        if list(values.values()) != list(range(len(values))):
            raise DefinitionError(f"{name}: enum values must count from 0")


def _lcm_fingerprint(definition: Definition, struct: Struct) -> int:
    """The fingerprint that lcm-gen computes: a hash over member names, primitive types and dimensions, to which the fingerprints of the
    struct types inside are added, all rotated left by one bit."""

    def signed(value):
        value &= 2**64 - 1
        return value - 2**64 if value >= 2**63 else value

    def add_char(value, char):
        return signed(((value << 8) ^ (value >> 55)) + char)  # the shift to the right keeps the sign

    def add_text(value, text):
        value = add_char(value, len(text))
        for char in text.encode():
            value = add_char(value, char)
        return value

    value = 0x12345678
    nested = 0
    for f in struct.fields:
        value = add_text(value, f.name)
        if f.type in LCM_TYPES:
            value = add_text(value, LCM_TYPES[f.type])
        else:
            nested += definition.by_name[f.type].fingerprint
        value = add_char(value, 1 if f.array else 0)  # number of dimensions
        if f.array:
            value = add_text(add_char(value, 0), str(definition.constants[f.array]))  # 0: a constant length
    value = (value + nested) % 2**64
    return (value << 1 | value >> 63) % 2**64


def _schema_hash(definition: Definition) -> int:
    """FNV-1a over what two parties must agree on: everything but the comments."""
    canonical = json.dumps(
        [definition.version, list(definition.constants.items()),
         [[name, list(values.items())] for name, values in definition.enums.items()],
         [[s.name, s.sender, [[f.name, f.type, f.array, f.unit, f.enum, f.range, f.key] for f in s.fields]]
          for s in definition.structs]],
        separators=(",", ":"))
    value = 0xCBF29CE484222325
    for byte in canonical.encode():
        value = (value ^ byte) * 0x100000001B3 % 2**64
    return value
