"""C++: haptic::client::DeviceState, Plane, and what Contact has of it; and their way to and from
the messages."""

from schema import MADE, Field, Message, Schema, wrapped

TYPES = {"double": "double", "uint32": "std::uint32_t", "uint64": "std::uint64_t",
         "int64": "std::int64_t"}


def source(includes: list[str], namespace: str, body: list[str]) -> list[str]:
    """A file of C++. `body` begins with an empty line."""
    return [f"// {MADE}", *includes, "", f"namespace {namespace} {{", *body, "",
            f"}}  // namespace {namespace}"]


def name_of(field: Field) -> str:
    """Times are std::chrono's, so their names have no unit."""
    return field.called.removesuffix("_us")


def _type(schema: Schema, field: Field) -> str:
    if field.kind == "enum":  # of haptic/client/state_types.hpp, if the library has one for it
        return schema.enums[field.type].called or "std::uint32_t"
    kind = field.type if field.kind == "message" else \
        "std::chrono::microseconds" if field.is_time else TYPES[field.kind]
    if field.repeated:
        return f"std::vector<{kind}>"
    return f"std::optional<{kind}>" if field.optional or field.kind == "message" else kind


def _members(schema: Schema, fields: list[Field], notes: list[str]) -> list[str]:
    lines = []
    for field, note in zip(fields, notes):
        lines += [*wrapped(note, "  /// "), f"  {_type(schema, field)} {name_of(field)}{{}};"]
    return lines


def _struct(message: Message, members: list[str]) -> list[str]:
    return ["", *wrapped(message.comment, "/// "), f"struct {message.name} {{", *members, "};"]


def _header(includes: list[str], body: list[str]) -> list[str]:
    return ["#pragma once", *source(["", *includes], "haptic::client", body)]


def state_header(schema: Schema) -> list[str]:
    body = []
    for message in schema.state:
        notes = [field.about("" if field.is_time else None) for field in message.fields]
        members = _members(schema, message.fields, notes)
        if message.name == "DeviceState":
            members += ["  /// This machine's steady clock when the state arrived.",
                        "  std::chrono::steady_clock::time_point received{};"]
        name = f"const {message.name}&"
        body += _struct(message, [
            *members, "", f"  friend bool operator==({name}, {name}) = default;"])
    return _header(["#include <chrono>", "#include <cstdint>", "#include <optional>",
                    "#include <vector>", "", '#include "haptic/client/state_types.hpp"'], body)


def plane_header(schema: Schema) -> list[str]:
    notes = [field.of_plane() for field in schema.plane.fields]
    return _header(["#include <cstdint>", "#include <optional>", "#include <vector>"],
                   _struct(schema.plane, _members(schema, schema.plane.fields, notes)))


def contact_members(schema: Schema) -> list[str]:
    """Of haptic::client::Contact, to be included in it."""
    notes = [field.of_contact() for field in schema.told]
    return [f"  // {MADE}", *_members(schema, schema.told, notes)]


def _read(schema: Schema, field: Field) -> str:
    to, got = f"to.{name_of(field)}", f"from.{field.name}()"
    if field.kind == "message":
        return f"if (from.has_{field.name}()) read({got}, {to}.emplace());"
    if field.repeated:
        return f"{to}.assign({got}.begin(), {got}.end());"
    if field.kind == "enum":
        return f"{to} = static_cast<{_type(schema, field)}>({got});"
    return f"{to} = std::chrono::microseconds({got});" if field.is_time else f"{to} = {got};"


def _write(field: Field) -> str:
    got = f"from.{name_of(field)}"
    if field.kind == "message":
        return f"if ({got}) write(*{got}, *to.mutable_{field.name}());"
    if field.repeated:
        return f"to.mutable_{field.name}()->Add({got}.begin(), {got}.end());"
    if field.optional:
        return f"if ({got}) to.set_{field.name}(*{got});"
    if field.kind == "enum":
        got = f"static_cast<v1::{field.type}>({got})"
    return f"to.set_{field.name}({got}{'.count()' if field.is_time else ''});"


def _writer(message: Message, local: str = "") -> list[str]:
    name = message.name
    return ["", f"{local}void write(const {name}& from, v1::{name}& to) {{",
            *(f"  {_write(field)}" for field in message.fields), "}"]


def state_conversion(schema: Schema) -> list[str]:
    body = []
    for message in schema.state:
        name = message.name
        local = "" if name == "DeviceState" else "static "
        body += ["", f"{local}void read(const v1::{name}& from, {name}& to) {{",
                 *(f"  {_read(schema, field)}" for field in message.fields), "}",
                 *_writer(message, local)]
    return source(['#include "convert_state.hpp"'], "haptic::client", body)


def plane_conversion(schema: Schema) -> list[str]:
    told = [f"  to.{field.name} = from.{field.name}{' / coupling' if field.by_coupling else ''};"
            for field in schema.told]
    return source(['#include "convert.hpp"', '#include "told.hpp"'], "haptic::client", [
        *_writer(schema.plane), "",
        "void tell(const Contact& from, double coupling, Plane& to) {", *told, "}"])


KINDS = {
    "cpp": state_header,                    # client::DeviceState
    "cpp_convert": state_conversion,        # to and from v1::DeviceState
    "cpp_plane": plane_header,              # client::Plane
    "cpp_contact": contact_members,         # what client::Contact has of it
    "cpp_plane_convert": plane_conversion,  # to v1::Plane, and contact_at()'s part of it
}
