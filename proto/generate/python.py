"""Python: DeviceState, what it holds, Plane, and what Contact has of it, as frozen values, from and
to the C structs.

A time in microseconds becomes seconds. An enum becomes its value's name.
"""

from schema import MADE, Enum, Field, Message, Schema, capitals, wrapped

_HEAD = f'''"""{MADE}"""

from __future__ import annotations

import dataclasses
from typing import Any

from ._library import floats, lists, name_of, put'''
_TYPES = {"double": "float", "uint32": "int", "uint64": "int", "int64": "int", "enum": "str"}


def _name(field: Field) -> str:
    return field.called.removesuffix("us") + "s" if field.is_time else field.called


def _type(field: Field) -> str:
    plain = field.type if field.kind == "message" else \
        "float" if field.is_time else _TYPES[field.kind]
    if field.repeated:
        return f"tuple[{plain}, ...]"
    return plain + " | None" if field.kind == "message" or field.optional else plain


def _default(field: Field) -> str:
    if field.repeated:
        return " = ()"
    return " = None" if field.optional else " = 0.0" if field.kind == "double" else " = 0"


def _read(field: Field) -> str:
    """The expression that reads it from the struct c of a state."""
    got = f"c.{field.called}"
    if field.kind == "message":
        return f"{field.type}.of({got}) if {got}.present else None"
    if field.repeated:
        return f"lists({got}.value, {got}.count)"
    if field.kind == "enum":
        return f"name_of({capitals(field.type)}, {got})"
    return f"{got} * 1e-6" if field.is_time else got


def _read_plane(field: Field) -> str:
    got = f"c.{field.called}"
    if field.repeated:
        return f"lists({got}, {'count' if field.axis else got + '_count'})"
    return f"{got} if c.has_{field.called} else None" if field.optional else got


def _fill_plane(field: Field) -> list[str]:
    to, value = f"c.{field.called}", f"self.{field.called}"
    if field.repeated:
        return [f'{"" if field.axis else to + "_count = "}put({to}, {value}, "{field.called}")']
    if field.optional:
        return [f"if {value} is not None:", f"    c.has_{field.called}, {to} = 1, {value}"]
    return [f"{to} = {value}"]


def _fill(fields: list[Field]) -> list[str]:
    return [f"        {line}" for field in fields for line in _fill_plane(field)]


def _normalised(fields: list[Field]) -> list[str]:
    """Lists are tuples, whatever they were given as."""
    return ["", "    def __post_init__(self) -> None:",
            *(f'        object.__setattr__(self, "{field.called}", floats(self.{field.called}))'
              for field in fields if field.repeated)]


def _members(fields: list[Field], notes: list[str], required: int) -> list[str]:
    lines = []
    for i, (field, note) in enumerate(zip(fields, notes)):
        lines += wrapped(note, "    # ") if note else []
        lines.append(f"    {_name(field)}: {_type(field)}" + (_default(field) if i >= required
                                                              else ""))
    return lines


def _class(name: str, about: str, more: str = "") -> list[str]:
    return ["", "", f"@dataclasses.dataclass(frozen=True, slots=True{more})", f"class {name}:",
            *wrapped(f'"""{about}"""', "    "), ""]


def _state(message: Message) -> list[str]:
    notes = [field.about("s" if field.is_time else None)
             + (f"; bits 0, 1, ...: {field.bits}" if field.bits else "")
             for field in message.fields]
    return [*_class(message.name, message.comment),
            *_members(message.fields, notes, len(notes)), "", "    @classmethod",
            f"    def of(cls, c: Any) -> {message.name}:", "        return cls(",
            *(f"            {_read(field)}," for field in message.fields), "        )"]


def _plane(message: Message) -> list[str]:
    """Goes up, and is made by people: all but normal and offset have defaults."""
    return [*_class("Plane", message.comment),
            *_members(message.fields, [field.of_plane() for field in message.fields], 2),
            *_normalised(message.fields), "", "    @classmethod",
            "    def of(cls, c: Any, count: int) -> Plane:",
            '        """`count`: how many coordinates the device has."""', "        return cls(",
            *(f"            {_read_plane(field)}," for field in message.fields), "        )",
            "", "    def fill(self, c: Any) -> None:", *_fill(message.fields)]


def _contact(fields: list[Field]) -> list[str]:
    same = "What a contact and its Plane have by the same name."
    return [*_class("Told", same, ", kw_only=True"),
            *_members(fields, [field.of_contact() for field in fields], 0), *_normalised(fields),
            "", "    def tell(self, c: Any) -> None:", *_fill(fields)]


def _enum(enum: Enum) -> list[str]:
    names = (("NONE" if name == "UNSPECIFIED" else name, number) for name, number in enum.values)
    return ["", f"{capitals(enum.name)} = {{", *(f'    {number}: "{name}",'
                                                  for name, number in names), "}"]


def messages(schema: Schema) -> list[str]:
    used = {enum.name: enum for enum in schema.state_enums}
    used |= {name: schema.enums[name] for name in ("Renderer", "Kind")}
    lines = _HEAD.splitlines()
    for enum in used.values():
        lines += _enum(enum)
    for message in schema.state:
        lines += _state(message)
    return lines + _plane(schema.plane) + _contact(schema.told)


KINDS = {"python": messages}  # from and to the C structs
