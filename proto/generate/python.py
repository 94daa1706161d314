"""Python: DeviceState, Device, ServerInfo, what these hold, Plane, and what Contact has of it, as
frozen values, from and to the C structs.

A time in microseconds becomes seconds. An enum becomes its value's name.
"""

from c import count_of
from cpp import FACTS, fields_of, is_optional
from schema import MADE, Enum, Field, Message, Schema, capitals, wrapped

_HEAD = f'''"""{MADE}"""

from __future__ import annotations

import dataclasses
from typing import Any
'''
_TYPES = {"double": "float", "uint32": "int", "uint64": "int", "int64": "int", "enum": "str",
          "int32": "int", "string": "str", "bool": "bool", "duration": "float"}
_CALLED = {"GetServerInfoResponse": "ServerInfo", "VirtualCoordinate": "Coordinate"}


def _called(message: str) -> str:
    return _CALLED.get(message, message)


def _name(field: Field) -> str:
    if field.kind == "duration":
        return field.called + "_s"
    return field.called.removesuffix("us") + "s" if field.is_time else field.called


def _type(field: Field) -> str:
    plain = _called(field.type) if field.kind == "message" else \
        "float" if field.is_time else _TYPES[field.kind]
    if field.repeated:
        return f"tuple[{plain}, ...]"
    optional = is_optional(field) and field.kind != "duration"
    return plain + " | None" if optional else plain


def _default(field: Field) -> str:
    if field.repeated:
        return " = ()"
    return " = None" if field.optional else " = 0.0" if field.kind == "double" else " = 0"


def _read(field: Field) -> str:
    """The expression that reads it from the struct c of a state."""
    got = f"c.{field.called}"
    if field.kind == "message":
        kind = _called(field.type)
        if field.repeated:
            return f"tuple({kind}.of({got}[i]) for i in range(c.{count_of(field)}))"
        return f"{kind}.of({got})" + (f" if {got}.present else None" if is_optional(field) else "")
    if field.kind == "string":
        return f"tuple(text({got}).splitlines())" if field.repeated else f"text({got})"
    if field.kind == "duration":
        return f"{got}_ns * 1e-9"
    if field.kind == "bool":
        return f"{got} != 0"
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


def _state(schema: Schema, message: Message) -> list[str]:
    fields, name = fields_of(schema, message), _called(message.name)
    notes = [field.about("s" if field.is_time else None)
             + (f"; bits 0, 1, ...: {field.bits}" if field.bits else "") for field in fields]
    return [*_class(name, message.comment), *_members(fields, notes, len(notes)), "",
            "    @classmethod", f"    def of(cls, c: Any) -> {name}:", "        return cls(",
            *(f"            {_read(field)}," for field in fields), "        )"]


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
    lines = [*_HEAD.splitlines(), "", "from ._library import floats, lists, name_of, put"]
    for enum in used.values():
        lines += _enum(enum)
    for message in schema.state:
        lines += _state(schema, message)
    return lines + _plane(schema.plane) + _contact(schema.told)


def facts(schema: Schema) -> list[str]:
    return [*_HEAD.splitlines(), "", "from ._library import lists, name_of, text",
            "from ._messages import DEVICE_STATE_NAME, RENDERER",
            *(line for message in schema.with_held(*FACTS) for line in _state(schema, message))]


KINDS = {
    "python": messages,     # DeviceState, Plane and Told, from and to the C structs
    "python_facts": facts,  # Device and ServerInfo
}
