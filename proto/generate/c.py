"""C: haptic_state, and how the library fills it from haptic::client::DeviceState.

The members stand in the order of the fields' numbers: a new field has the highest number, so it
comes last, as the ABI wants. The messages in DeviceState do not grow.
"""

import cpp
from schema import Field, Message, Schema, wrapped

_MADE = "Made of proto/haptic/v1/session.proto by proto/generate: nothing to edit here."
_TYPES = {"double": "double", "uint32": "uint32_t", "uint64": "uint64_t", "int64": "int64_t",
          "enum": "int32_t"}


def _name(message: str) -> str:
    words = "".join("_" + c.lower() if c.isupper() else c for c in message)
    return "haptic_state" if message == "DeviceState" else "haptic" + words.removesuffix("_state")


def _type(field: Field) -> str:
    if field.kind == "message":
        return _name(field.type)
    if not field.repeated:
        return _TYPES[field.kind]
    if field.kind == "uint32" and field.axis in ("DOF", "ACTUATED"):
        return "haptic_dof_bits"
    if field.kind == "double" and field.axis:
        return "haptic_coordinates" if field.axis == "COORDINATE" else "haptic_dofs"
    raise SystemExit(f"{field.message}.{field.name}: a list in C needs an (axis), and is of double "
                     "or, per DoF, of uint32")


def _members(message: Message) -> list[Field]:
    return sorted(message.fields, key=lambda field: field.number)


def _struct(message: Message, first: list[str]) -> list[str]:
    lines = ["", *_comment(message.comment, ""), f"typedef struct {_name(message.name)} {{", *first]
    for field in _members(message):
        lines += _comment(field.about(), "  ")
        lines.append(f"  {_type(field)} {field.called};")
    return lines + [f"}} {_name(message.name)};"]


def _comment(text: str, indent: str) -> list[str]:
    return wrapped(text, indent + "/* ", indent + " * ", " */") if text else []


def state_header(schema: Schema) -> list[str]:
    lines = ["#ifndef HAPTIC_HAPTIC_STATE_H", "#define HAPTIC_HAPTIC_STATE_H",
             f"/* {_MADE}", " * The rules of structs are in haptic_types.h. */",
             "#include <haptic/haptic_lists.h>"]
    for message in schema.reachable("DeviceState"):
        top = message.name == "DeviceState"
        first = "size_t size;" if top else "int32_t present; /* 0: absent */"
        lines += _struct(message, ["  " + first])
    return lines + ["", "#endif"]


def _assigned(field: Field) -> str:
    to, got = f"to.{field.called}", f"from.{cpp.name_of(field)}"
    if field.kind == "message":
        return f"if ({got}) write(*{got}, {to});"
    if field.repeated:
        return f"write_list({got}, {to});"
    if field.kind == "enum":
        return f"{to} = static_cast<std::int32_t>({got});"
    if field.is_time:
        return f"{to} = static_cast<std::{_TYPES[field.kind]}>({got}.count());"
    return f"{to} = {got};"


def state_conversion(schema: Schema) -> list[str]:
    lines = [f"// {_MADE}", '#include "state_struct.hpp"', "", "namespace haptic::c {"]
    for message in schema.reachable("DeviceState"):
        top = message.name == "DeviceState"
        head = f"void write(const client::{message.name}& from, {_name(message.name)}& to) {{"
        lines += ["", head if top else "static " + head, *([] if top else ["  to.present = 1;"]),
                  *(f"  {_assigned(field)}" for field in _members(message)), "}"]
    return lines + ["", "}  // namespace haptic::c"]
