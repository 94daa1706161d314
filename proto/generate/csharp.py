"""C#: DeviceState with its enums, and how HapticSession reads it."""

from schema import Enum, Field, Message, Schema, pascal, wrapped

_TYPES = {"double": "double", "uint32": "uint", "uint64": "ulong", "int64": "long"}
_READ = {"double": "from.Real()", "uint32": "(uint)from.Number()", "uint64": "from.Number()",
         "int64": "(long)from.Number()"}


def _type(schema: Schema, field: Field) -> str:
    if field.kind == "enum":
        return schema.enums[field.type].called or field.type
    kind = field.type if field.kind == "message" else _TYPES[field.kind]
    return kind + ("[]" if field.repeated else "")


def _read(schema: Schema, field: Field) -> str:
    to = f"to.{pascal(field.called)}"
    if field.kind == "message":
        return f"{to} = Of(from.Sub(), {to} ?? new {field.type}())"
    if field.repeated:
        return f"{to} = from.{'Reals' if field.kind == 'double' else 'Numbers'}({to})"
    if field.kind == "enum":
        return f"{to} = ({_type(schema, field)})from.Number()"
    return f"{to} = {_READ[field.kind]}"


def _enum(enum: Enum) -> list[str]:
    names = [pascal(name) if name != "UNSPECIFIED" else "None" for name, _ in enum.values]
    values = ", ".join(f"{name} = {number}" for name, (_, number) in zip(names, enum.values))
    return ["", *wrapped(enum.comment, "/// "),
            *wrapped(f"public enum {enum.called or enum.name} {{ {values} }}", "", "  ")]


def _class(schema: Schema, message: Message) -> list[str]:
    lines = ["", *wrapped(message.comment, "/// "), f"public sealed class {message.name} {{"]
    for field in message.fields:
        empty = f" = new {_type(schema, field)[:-1]}0]" if field.repeated else ""
        lines += wrapped(field.about(), "  /// ")
        lines.append(f"  public {_type(schema, field)} {pascal(field.called)}{empty};")
    if message.name == "DeviceState":
        lines.append("  internal long Arrived;  // by HapticSession's clock")
    return lines + ["}"]


def _reader(schema: Schema, message: Message) -> list[str]:
    name = message.name
    return ["", f"  static {name} Of(Reader from, {name} to) {{", "    while (from.Next()) {",
            "      switch (from.Field) {",
            *(f"        case {field.number}: {_read(schema, field)}; break;"
              for field in message.fields),
            "        default: from.Skip(); break;", "      }", "    }", "    return to;", "  }"]


def state(schema: Schema) -> list[str]:
    messages = schema.reachable("DeviceState")
    lines = ["// Made of proto/haptic/v1/session.proto by proto/generate: nothing to edit here.",
             "namespace Haptic {"]
    for enum in schema.enums_of("DeviceState"):
        lines += _enum(enum)
    for message in messages:
        lines += _class(schema, message)
    lines += ["", "public sealed partial class HapticSession {"]
    for message in messages:
        lines += _reader(schema, message)
    return lines + ["}", "", "}  // namespace Haptic"]
