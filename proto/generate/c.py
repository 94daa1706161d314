"""C: haptic_state, haptic_device, haptic_server_info, haptic_plane and haptic_contact, and their
way from and to haptic::client.

The members stand in the order of the fields' numbers: a new field has the highest number, so it
comes last, as the ABI wants. The messages in DeviceState do not grow.
"""

from cpp import TYPES as CPP_TYPES
from cpp import FACTS, called, fields_of, is_optional, name_of, source
from schema import MADE, Enum, Field, Message, Schema, wrapped

_TYPES = {kind: name.removeprefix("std::") for kind, name in CPP_TYPES.items()}
_TYPES |= {"enum": "int32_t", "bool": "int32_t"}
_LENGTHS = {"normal": "HAPTIC_MAX_COORDINATES", "curvature": "36", "object_direction": "6"}
_NAMES = {"DeviceState": "haptic_state", "DegreeOfFreedom": "haptic_dof",
          "VirtualCoordinate": "haptic_coordinate", "GetServerInfoResponse": "haptic_server_info"}
_PREFIXES = {"DeviceStateName": "HAPTIC_", "ProxyMode": "HAPTIC_", "StalenessLevel": "HAPTIC_",
             "Transport": "HAPTIC_BY_", "Kind": "HAPTIC_EVENT_"}  # of values
_MOST = {"DegreeOfFreedom": "HAPTIC_MAX_DOFS", "VirtualCoordinate": "HAPTIC_MAX_COORDINATES"}
_TEXTS = {"scene": 256, "explanation": 256, "insecure": 1024}  # bytes; others: a name's


def _name(message: str) -> str:
    words = "".join("_" + c.lower() if c.isupper() else c for c in message)
    return _NAMES.get(message, "haptic" + words.removesuffix("_state"))


def count_of(field: Field) -> str:
    """The member that says how many messages a list has."""
    return field.called.removesuffix("s") + "_count"


def _list(field: Field) -> str:
    if field.kind == "uint32" and field.axis in ("DOF", "ACTUATED"):
        return "haptic_dof_bits"
    if field.kind == "double" and field.axis:
        return "haptic_coordinates" if field.axis == "COORDINATE" else "haptic_dofs"
    raise SystemExit(f"{field.message}.{field.name}: a list in C needs an (axis), and is of double "
                     "or, per DoF, of uint32")


def _in_state(field: Field) -> list[str]:
    if field.kind == "string":
        return [f"char {field.called}[{_TEXTS.get(field.name, 'HAPTIC_MAX_NAME + 1')}];"]
    if field.kind == "duration":
        return [f"int64_t {field.called}_ns;"]
    if field.kind == "message" and field.repeated:
        return [f"uint32_t {count_of(field)};",
                f"{_name(field.type)} {field.called}[{_MOST[field.type]}];"]
    kind = _name(field.type) if field.kind == "message" else \
        _list(field) if field.repeated else _TYPES[field.kind]
    return [f"{kind} {field.called};"]


def _in_plane(field: Field) -> list[str]:
    """A list has its count before it, unless it is as long as the device has coordinates."""
    if field.repeated:
        count = [] if field.axis else [f"uint32_t {field.name}_count;"]
        return [*count, f"{_TYPES[field.kind]} {field.name}[{_LENGTHS[field.name]}];"]
    has = [f"int32_t has_{field.name}; /* 0: the next is absent */"] if field.optional else []
    return [*has, f"{_TYPES[field.kind]} {field.name};"]


def _by_number(fields: list[Field]) -> list[Field]:
    return sorted(fields, key=lambda field: field.number)


def _members(fields: list[Field], note, declared) -> list[str]:
    lines = []
    for field in _by_number(fields):
        lines += _comment(note(field), "  ") + ["  " + line for line in declared(field)]
    return lines


def _comment(text: str, indent: str = "") -> list[str]:
    return wrapped(text, indent + "/* ", indent + " * ", " */") if text else []


def _struct(name: str, comment: str, members: list[str]) -> list[str]:
    return ["", *_comment(comment), f"typedef struct {name} {{", *members, f"}} {name};"]


def _header(name: str, more: str, include: str, body: list[str]) -> list[str]:
    guard = f"HAPTIC_HAPTIC_{name}_H"
    return [f"#ifndef {guard}", f"#define {guard}", f"/* {MADE}", f" * {more} */",
            f"#include <haptic/{include}>", *body, "", "#endif"]


def _enum(enum: Enum) -> list[str]:
    prefix = _PREFIXES[enum.name]
    return ["", *_comment(enum.comment), "enum {",
            *(f"  {prefix}{name} = {number}," for name, number in enum.values[1:-1]),
            f"  {prefix}{enum.values[-1][0]} = {enum.values[-1][1]}", "};"]


def _structs(schema: Schema, messages: list[Message], tops: tuple[str, ...],
             nested: list[str]) -> list[str]:
    body = []
    for message in messages:
        first = ["  size_t size;"] if message.name in tops else nested
        members = _members(fields_of(schema, message), Field.about, _in_state)
        body += _struct(_name(message.name), message.comment, [*first, *members])
    return body


def state_header(schema: Schema) -> list[str]:
    return _header("STATE", "The rules of structs are in haptic_types.h.", "haptic_lists.h", [
        *(line for name in _PREFIXES for line in _enum(schema.enums[name])),
        *_structs(schema, schema.state, ("DeviceState",), ["  int32_t present; /* 0: absent */"])])


def facts_header(schema: Schema) -> list[str]:
    return _header("FACTS", "The rules of structs are in haptic_types.h; lists of text have a line "
                   "each.", "haptic_lists.h", _structs(schema, schema.with_held(*FACTS), FACTS, []))


def plane_header(schema: Schema) -> list[str]:
    geometry = ["  haptic_point point;  /* its size too must be set */",
                "  double normal[3];    /* of the object at the nearest point, outwards */",
                "  double gap;          /* from the object to the point along the normal, m; < 0: "
                "inside */",
                "  double curvature[6]; /* of the object; haptic_sphere_curvature() */",
                "  double stiffness;    /* of point and object in series, N/m; 0: rigid */"]
    plane = _members(schema.plane.fields, Field.of_plane, _in_plane)
    told = _members(schema.told, Field.of_contact, _in_plane)
    return _header("PLANE", "haptic_contact.h includes this.", "haptic_point.h", [
        *_struct("haptic_plane", schema.plane.comment, ["  size_t size;", *plane]),
        *_struct("haptic_contact", "A point of the tool against an object.",
                 ["  size_t size;", *geometry, *told])])


def _assigned(field: Field) -> str:
    to, got = f"to.{field.called}", f"from.{name_of(field)}"
    if field.kind == "string":
        return f"write_text({f'joined({got})' if field.repeated else got}, {to});"
    if field.kind == "duration":
        return f"{to}_ns = {got}.count();"
    if field.kind == "message" and field.repeated:
        return (f"to.{count_of(field)} = fitting({got}, {to});\n"
                f"  for (std::uint32_t i = 0; i < to.{count_of(field)}; ++i) "
                f"write({got}[i], {to}[i]);")
    if field.kind == "message":
        return f"if ({got}) write(*{got}, {to});" if is_optional(field) else f"write({got}, {to});"
    if field.repeated:
        return f"write_list({got}, {to});"
    if field.kind == "enum":
        return f"{to} = static_cast<std::int32_t>({got});"
    if field.is_time:
        return f"{to} = static_cast<std::{_TYPES[field.kind]}>({got}.count());"
    return f"{to} = {got};"


def _conversion(schema: Schema, messages: list[Message], tops: tuple[str, ...]) -> list[str]:
    body = []
    for message in messages:
        local = "" if message.name in tops else "static "
        present = ["  to.present = 1;"] if local and message in schema.state else []
        body += ["", f"{local}void write(const client::{called(message.name)}& from, "
                 f"{_name(message.name)}& to) {{", *present,
                 *(f"  {_assigned(field)}" for field in _by_number(fields_of(schema, message))),
                 "}"]
    return source(['#include "state_struct.hpp"'], "haptic::c", body)


def state_conversion(schema: Schema) -> list[str]:
    return _conversion(schema, schema.state, ("DeviceState",))


def facts_conversion(schema: Schema) -> list[str]:
    return _conversion(schema, schema.with_held(*FACTS), FACTS)


def _reader(name: str, struct: str, called: str, fields: list[Field]) -> list[str]:
    lines = ["", f"void read_fields(const {struct}& from, client::{name}& to) {{"]
    for field in fields:
        got, to = f"from.{field.name}", f"to.{field.name}"
        if field.repeated:
            lines += [f'  at_most("{called}{field.name}_count", {got}_count, std::size({got}));',
                      f"  {to}.assign({got}, {got} + {got}_count);"]
        else:
            when = f"if ({'from.has_' + field.name} != 0) " if field.optional else ""
            lines.append(f"  {when}{to} = {got};")
    return lines + ["}"]


def plane_conversion(schema: Schema) -> list[str]:
    plane = [field for field in schema.plane.fields if not field.axis]
    body = [*_reader("Plane", "haptic_plane", "plane.", plane),
            *_reader("Contact", "haptic_contact", "contact->", schema.told), "",
            "void write_fields(const client::Plane& from, haptic_plane& to) {"]
    for field in plane:
        got, to = f"from.{field.name}", f"to.{field.name}"
        if field.repeated:
            body.append(f"  {to}_count = write_values({got}, {to});")
        elif field.optional:
            body += [f"  to.has_{field.name} = {got}.has_value();",
                     f"  {to} = {got}.value_or({CPP_TYPES[field.kind]}{{}});"]
        else:
            body.append(f"  {to} = {got};")
    return source(['#include "convert_plane.hpp"'], "haptic::c", body + ["}"])


KINDS = {
    "c": state_header,                    # haptic_state
    "c_convert": state_conversion,        # of client::DeviceState
    "c_facts": facts_header,              # haptic_device and haptic_server_info
    "c_facts_convert": facts_conversion,  # of client::DeviceInfo and client::ServerInfo
    "c_plane": plane_header,              # haptic_plane and haptic_contact
    "c_plane_convert": plane_conversion,  # from and to client::Plane and client::Contact
}
