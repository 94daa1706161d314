#!/usr/bin/env python3
"""Writes the module haptic._state: DeviceState and its parts as frozen values, from the messages.

    make_state.py DESCRIPTORS > _state.py

DESCRIPTORS: what protoc --descriptor_set_out --include_imports --include_source_info makes of
session.proto. A field keeps its name and comment, and gets its axis and unit said; one that ends in
_us becomes seconds, _s.
"""

import sys
import textwrap

from google.protobuf import descriptor_pb2 as pb
from google.protobuf import descriptor_pool, message_factory

HEAD = '''"""Made of proto/haptic/v1/session.proto by make_state.py: nothing to edit here."""

from __future__ import annotations

import dataclasses

from ._names import name_of
from .v1 import session_pb2 as wire
'''
INTEGERS = {pb.FieldDescriptorProto.TYPE_UINT32, pb.FieldDescriptorProto.TYPE_UINT64,
            pb.FieldDescriptorProto.TYPE_INT64}
MESSAGE_PATH, FIELD_PATH = 4, 2  # field numbers of FileDescriptorProto and DescriptorProto
AXES = ["", "per DoF", "per actuated DoF", "per virtual coordinate"]


class Options:
    """The options of haptic/v1/field_options.proto, in words."""

    def __init__(self, files: pb.FileDescriptorSet) -> None:
        pool = descriptor_pool.DescriptorPool()
        for file in files.file:
            pool.Add(file)
        self._type = message_factory.MessageFactory(pool).GetPrototype(
            pool.FindMessageTypeByName("google.protobuf.FieldOptions"))
        self._axis, self._unit, self._bits = (
            pool.FindExtensionByName(f"haptic.v1.{name}") for name in ("axis", "unit", "bits"))

    def of(self, field: pb.FieldDescriptorProto) -> str:
        said = self._type.FromString(field.options.SerializeToString()).Extensions
        unit = said[self._unit] if not field.name.endswith("_us") else "s"
        if "POSITION" in unit or "EFFORT" in unit:
            unit = " or ".join(unit.replace("POSITION", position).replace("EFFORT", effort)
                               for position, effort in (("m", "N"), ("rad", "N m")))
        words = " ".join(filter(None, [unit, AXES[said[self._axis]]]))
        bits = "bits 0, 1, ...: " + said[self._bits] if said[self._bits] else ""
        return "; ".join(filter(None, [words, bits]))


def comments(file: pb.FileDescriptorProto) -> dict[tuple[int, ...], str]:
    return {tuple(place.path): " ".join((place.leading_comments + place.trailing_comments).split())
            for place in file.source_code_info.location}


def value_of(field: pb.FieldDescriptorProto) -> tuple[str, str, str]:
    """Name, type and the expression that reads it from the message m."""
    read, kind = f"m.{field.name}", field.type_name.split(".")[-1]
    repeated = field.label == field.LABEL_REPEATED
    if field.type == field.TYPE_MESSAGE:
        if repeated:
            return field.name, f"tuple[{kind}, ...]", f"tuple(map({kind}.of, {read}))"
        return (field.name, f"{kind} | None",
                f'{kind}.of({read}) if m.HasField("{field.name}") else None')
    if field.type == field.TYPE_ENUM:
        return field.name, "str", f"name_of(wire.{kind}, {read})"
    if field.name.endswith("_us"):
        return field.name.removesuffix("us") + "s", "float", f"{read} * 1e-6"
    plain = "int" if field.type in INTEGERS else "float"
    return (field.name, f"tuple[{plain}, ...]", f"tuple({read})") if repeated else (
        field.name, plain, read)


def class_of(file: pb.FileDescriptorProto, index: int, options: Options) -> str:
    message, said = file.message_type[index], comments(file)
    text = ["", "", "@dataclasses.dataclass(frozen=True, slots=True)", f"class {message.name}:"]
    text += textwrap.wrap(f'"""{said[MESSAGE_PATH, index]}"""', 100, initial_indent="    ",
                          subsequent_indent="    ") + [""]
    values = [value_of(field) for field in message.field]
    for place, (name, kind, _) in enumerate(values):
        comment = filter(None, [said.get((MESSAGE_PATH, index, FIELD_PATH, place), "").rstrip("."),
                                options.of(message.field[place])])
        text += textwrap.wrap("; ".join(comment), 100, initial_indent="    # ",
                              subsequent_indent="    # ")
        text.append(f"    {name}: {kind}")
    text += ["", "    @classmethod", f"    def of(cls, m: wire.{message.name}) -> {message.name}:",
             "        return cls("]
    return "\n".join(text + [f"            {read}," for _, _, read in values] + ["        )"])


def main() -> None:
    with open(sys.argv[1], "rb") as stream:
        files = pb.FileDescriptorSet.FromString(stream.read())
    file, options = files.file[-1], Options(files)  # what it imports comes before it
    index = {message.name: i for i, message in enumerate(file.message_type)}
    wanted = ["DeviceState"]
    for name in wanted:  # grows: what a message holds comes with it
        wanted += [field.type_name.split(".")[-1] for field in file.message_type[index[name]].field
                   if field.type == field.TYPE_MESSAGE]
    print(HEAD + "\n".join(class_of(file, index[name], options) for name in reversed(wanted)))


main()
