"""C++: haptic::client::DeviceState, and its way to and from the message."""

from schema import Field, Message, Schema, wrapped

_MADE = "Made of proto/haptic/v1/session.proto by proto/generate: nothing to edit here."
_TYPES = {"double": "double", "uint32": "std::uint32_t", "uint64": "std::uint64_t",
          "int64": "std::int64_t"}


def name_of(field: Field) -> str:
    """Times are std::chrono's, so their names have no unit."""
    return field.called.removesuffix("_us")


def enum_type(schema: Schema, field: Field) -> str:
    """An enum of haptic/client/state_types.hpp; a number if the library has none for it."""
    return schema.enums[field.type].called or "std::uint32_t"


def _declared(schema: Schema, field: Field) -> str:
    if field.kind == "message":
        many = f"std::vector<{field.type}>" if field.repeated else f"std::optional<{field.type}>"
        return f"{many} {name_of(field)}{{}};"
    if field.kind == "enum":
        return f"{enum_type(schema, field)} {name_of(field)}{{}};"
    kind = "std::chrono::microseconds" if field.is_time else _TYPES[field.kind]
    return f"{f'std::vector<{kind}>' if field.repeated else kind} {name_of(field)}{{}};"


def _struct(schema: Schema, message: Message, more: list[str]) -> list[str]:
    lines = ["", *wrapped(message.comment, "/// "), f"struct {message.name} {{"]
    for field in message.fields:
        lines += wrapped(field.about("" if field.is_time else None), "  /// ")
        lines.append("  " + _declared(schema, field))
    return lines + more + [
        "", f"  friend bool operator==(const {message.name}&, const {message.name}&) = default;",
        "};"]


def state_header(schema: Schema) -> list[str]:
    arrived = ["  /// This machine's steady clock when the state arrived.",
               "  std::chrono::steady_clock::time_point received{};"]
    lines = ["#pragma once", f"// {_MADE}", "", "#include <chrono>", "#include <cstdint>",
             "#include <optional>", "#include <vector>", "",
             '#include "haptic/client/state_types.hpp"', "", "namespace haptic::client {"]
    for message in schema.reachable("DeviceState"):
        lines += _struct(schema, message, arrived if message.name == "DeviceState" else [])
    return lines + ["", "}  // namespace haptic::client"]


def _read(schema: Schema, field: Field) -> str:
    to, got = f"to.{name_of(field)}", f"from.{field.name}()"
    if field.kind == "message" and field.repeated:
        return f"for (const auto& part : {got}) read(part, {to}.emplace_back());"
    if field.kind == "message":
        return f"if (from.has_{field.name}()) read({got}, {to}.emplace());"
    if field.repeated:
        return f"{to}.assign({got}.begin(), {got}.end());"
    if field.kind == "enum":
        return f"{to} = static_cast<{enum_type(schema, field)}>({got});"
    return f"{to} = std::chrono::microseconds({got});" if field.is_time else f"{to} = {got};"


def _write(field: Field) -> str:
    got = f"from.{name_of(field)}"
    if field.kind == "message" and field.repeated:
        return f"for (const auto& part : {got}) write(part, *to.add_{field.name}());"
    if field.kind == "message":
        return f"if ({got}) write(*{got}, *to.mutable_{field.name}());"
    if field.repeated:
        return f"to.mutable_{field.name}()->Add({got}.begin(), {got}.end());"
    if field.kind == "enum":
        got = f"static_cast<v1::{field.type}>({got})"
    return f"to.set_{field.name}({got}{'.count()' if field.is_time else ''});"


def state_conversion(schema: Schema) -> list[str]:
    lines = [f"// {_MADE}", '#include "convert_state.hpp"', "", "namespace haptic::client {"]
    for message in schema.reachable("DeviceState"):
        read = [f"  {_read(schema, field)}" for field in message.fields]
        write = [f"  {_write(field)}" for field in message.fields]
        name = message.name
        local = "" if name == "DeviceState" else "static "
        lines += ["", f"{local}void read(const v1::{name}& from, {name}& to) {{", *read, "}",
                  "", f"{local}void write(const {name}& from, v1::{name}& to) {{", *write, "}"]
    return lines + ["", "}  // namespace haptic::client"]
