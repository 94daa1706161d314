"""The owner: what a tick's record says, as a v1::DeviceState.

The option (from) of a field says where its value is. In DeviceState that is a path in
core::TickRecord, or "owner.NAME" for the function NAME of server/owner/state/values.hpp. In a
message that DeviceState holds it is a path in the part of the record that this message is from;
the message is present if that part's member `on` is true.
"""

from schema import Field, Message, Schema


def _value(field: Field, message: Message) -> str:
    if not field.source:
        raise SystemExit(f"{message.name}.{field.name}: needs (from): where the owner has it "
                         "at the end of a tick")
    if message.name != "DeviceState":
        return f"from.{field.source}"
    of_owner = field.source.removeprefix("owner.")
    return f"from.record.{field.source}" if of_owner == field.source else f"{of_owner}(from)"


def _write(field: Field, message: Message) -> str:
    value = _value(field, message)
    if field.kind == "message":
        if field.repeated:
            raise SystemExit(f"{message.name}.{field.name}: a list of messages has no place in a "
                             "state")
        return (f"  if ({value}.on) {{\n    write({value}, *to.mutable_{field.name}());\n"
                f"  }} else {{\n    to.clear_{field.name}();\n  }}")
    if field.repeated:
        return f"  put({value}, *to.mutable_{field.name}());"
    plain = f"plain({value})"
    if field.kind == "enum":
        plain = f"static_cast<v1::{field.type}>({value})"
    return f"  to.set_{field.name}({plain});"


def write_state(schema: Schema) -> list[str]:
    lines = ["// Made of proto/haptic/v1/session.proto by proto/generate: nothing to edit here.",
             '#include "server/owner/state/state_message.hpp"',
             '#include "server/owner/state/values.hpp"', "", "namespace haptic::server {"]
    for message in schema.reachable("DeviceState"):
        top = message.name == "DeviceState"
        kind = "const TickTold&" if top else "const auto&"
        local = "" if top else "static "
        lines += ["", f"{local}void write({kind} from, v1::{message.name}& to) {{",
                  *(_write(field, message) for field in message.fields), "}"]
    return lines + ["", "}  // namespace haptic::server"]
