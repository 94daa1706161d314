"""C++: haptic::client::DeviceState, Plane, what Contact has of it, and the facts of servers,
devices and links; and their way to and from the messages."""

from schema import MADE, Enum, Field, Message, Schema, pascal, wrapped

TYPES = {"double": "double", "uint32": "std::uint32_t", "uint64": "std::uint64_t",
         "int32": "std::int32_t", "int64": "std::int64_t", "sint64": "std::int64_t", "bool": "bool",
         "string": "std::string", "duration": "std::chrono::nanoseconds"}
FACTS = ("Device", "GetServerInfoResponse")  # that C and Python have, too
_FACTS = ("Event", *FACTS, "GetLinkStatsResponse", "UpdateSettingsRequest",
          "UpdateSettingsResponse")
_CALLED = {"Device": "DeviceInfo", "GetServerInfoResponse": "ServerInfo",
           "GetLinkStatsResponse": "LinkReport", "LinkTransport": "LinkCarrier",
           "UpdateSettingsRequest": "Settings", "UpdateSettingsResponse": "AppliedSettings",
           "LinkTransport.transport": "carrier", "SessionLink.transports": "carriers"}
# Messages and durations that the server always sends; others are optional.
_ALWAYS = ("realtime", "loop", "uptime", "lease_timeout", "up", "down", "bound")
_INCLUDES = ["#include <chrono>", "#include <cstdint>", "#include <optional>", "#include <string>",
             "#include <vector>", "", '#include "haptic/client/enums.hpp"']


def source(includes: list[str], namespace: str, body: list[str]) -> list[str]:
    """A file of C++. `body` begins with an empty line."""
    return [f"// {MADE}", *includes, "", f"namespace {namespace} {{", *body, "",
            f"}}  // namespace {namespace}"]


def name_of(field: Field) -> str:
    """Times are std::chrono's, so their names have no unit."""
    name = _CALLED.get(f"{field.message}.{field.name}", field.called)
    return name.removesuffix("_us") if field.is_time else name


def called(message: str) -> str:
    return _CALLED.get(message, message)


def fields_of(schema: Schema, message: Message) -> list[Field]:
    """But for the session's id, which the library has, and messages of another file."""
    return [field for field in message.fields if field.name != "session_id"
            and (field.kind != "message" or field.type in schema.messages)]


def is_optional(field: Field) -> bool:
    may_lack = field.kind in ("message", "duration") and field.name not in _ALWAYS
    return field.optional or (may_lack and not field.repeated)


def _type(schema: Schema, field: Field) -> str:
    if field.kind == "enum":  # of haptic/client/enums.hpp, if the library has one for it
        return schema.enums[field.type].called or "std::uint32_t"
    kind = called(field.type) if field.kind == "message" else \
        "std::chrono::microseconds" if field.is_time else TYPES[field.kind]
    if field.repeated:
        return f"std::vector<{kind}>"
    return f"std::optional<{kind}>" if is_optional(field) else kind


def _members(schema: Schema, fields: list[Field], notes: list[str]) -> list[str]:
    lines = []
    for field, note in zip(fields, notes):
        lines += [*wrapped(note, "  /// "), f"  {_type(schema, field)} {name_of(field)}{{}};"]
    return lines


def _struct(message: Message, members: list[str]) -> list[str]:
    return ["", *wrapped(message.comment, "/// "), f"struct {called(message.name)} {{", *members,
            "};"]


def _header(includes: list[str], body: list[str]) -> list[str]:
    return ["#pragma once", *source(["", *includes], "haptic::client", body)]


def _structs(schema: Schema, messages: list[Message]) -> list[str]:
    body = []
    for message in messages:
        fields = fields_of(schema, message)
        notes = [field.about("" if field.is_time else None) for field in fields]
        members = _members(schema, fields, notes)
        if message.name == "DeviceState":
            members += ["  /// This machine's steady clock when the state arrived.",
                        "  std::chrono::steady_clock::time_point received{};"]
        name = f"const {called(message.name)}&"
        body += _struct(message, [
            *members, "", f"  friend bool operator==({name}, {name}) = default;"])
    return _header(_INCLUDES, body)


def state_header(schema: Schema) -> list[str]:
    return _structs(schema, schema.state)


def facts_header(schema: Schema) -> list[str]:
    return _structs(schema, schema.with_held(*_FACTS))


def _enum(enum: Enum) -> list[str]:
    lines = ["", *wrapped(enum.comment, "/// "), f"enum class {enum.called} : std::uint8_t {{"]
    for (name, number), note in zip(enum.values, enum.notes):
        lines += wrapped(note, "  /// ")
        lines.append(f"  k{pascal('NONE' if name == 'UNSPECIFIED' else name)} = {number},")
    return lines + ["};"]


def enums_header(schema: Schema) -> list[str]:
    return _header(["#include <cstdint>"], [line for enum in schema.enums.values() if enum.called
                                            for line in _enum(enum)])


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
    if field.kind == "message" and field.repeated:
        return f"for (const auto& part : {got}) read(part, {to}.emplace_back());"
    if field.repeated:
        return f"{to}.assign({got}.begin(), {got}.end());"
    when = f"if (from.has_{field.name}()) " if is_optional(field) else ""
    if field.kind == "message":
        return f"{when}read({got}, {to}{'.emplace()' if when else ''});"
    if field.kind == "duration":
        return f"{when}{to} = to_duration({got});"
    if field.kind == "enum":
        return f"{to} = static_cast<{_type(schema, field)}>({got});"
    return f"{when}{to} = " + (f"std::chrono::microseconds({got});" if field.is_time else f"{got};")


def _write(field: Field) -> str:
    got = f"from.{name_of(field)}"
    if field.kind == "message" and field.repeated:
        return f"for (const auto& part : {got}) write(part, *to.add_{field.name}());"
    if field.repeated:
        return f"to.mutable_{field.name}()->Add({got}.begin(), {got}.end());"
    when, value = (f"if ({got}) ", f"*{got}") if is_optional(field) else ("", got)
    if field.kind in ("message", "duration"):
        return f"{when}write({value}, *to.mutable_{field.name}());"
    if field.kind == "enum":
        value = f"static_cast<decltype(to.{field.name}())>({value})"
    return f"{when}to.set_{field.name}({value}{'.count()' if field.is_time else ''});"


def _writer(schema: Schema, message: Message, local: bool = False) -> list[str]:
    into = "auto" if local else f"v1::{message.name}"
    return ["", f"{'static ' * local}void write(const {called(message.name)}& from, {into}& to) {{",
            *(f"  {_write(field)}" for field in fields_of(schema, message)), "}"]


def _conversion(schema: Schema, header: str, messages: list[Message],
                roots: tuple[str, ...]) -> list[str]:
    body = []
    for message in messages:
        local, name = message.name not in roots, called(message.name)
        got = "auto" if local else f"v1::{message.name}"  # a message in another has a longer name
        body += ["", f"{'static ' * local}void read(const {got}& from, {name}& to) {{",
                 *(f"  {_read(schema, field)}" for field in fields_of(schema, message)), "}",
                 *_writer(schema, message, local)]
    return source([f'#include "{header}"'], "haptic::client", body)


def state_conversion(schema: Schema) -> list[str]:
    return _conversion(schema, "convert_state.hpp", schema.state, ("DeviceState",))


def facts_conversion(schema: Schema) -> list[str]:
    return _conversion(schema, "convert.hpp", schema.with_held(*_FACTS), _FACTS)


def plane_conversion(schema: Schema) -> list[str]:
    told = [f"  to.{field.name} = from.{field.name}{' / coupling' if field.by_coupling else ''};"
            for field in schema.told]
    return source(['#include "convert.hpp"', '#include "told.hpp"'], "haptic::client", [
        *_writer(schema, schema.plane), "",
        "void tell(const Contact& from, double coupling, Plane& to) {", *told, "}"])


KINDS = {
    "cpp": state_header,                    # client::DeviceState
    "cpp_convert": state_conversion,        # to and from v1::DeviceState
    "cpp_facts": facts_header,              # client::DeviceInfo, ServerInfo, LinkReport, Event
    "cpp_facts_convert": facts_conversion,  # to and from their messages
    "cpp_enums": enums_header,              # the enums in all of these
    "cpp_plane": plane_header,              # client::Plane
    "cpp_contact": contact_members,         # what client::Contact has of it
    "cpp_plane_convert": plane_conversion,  # to v1::Plane, and contact_at()'s part of it
}
