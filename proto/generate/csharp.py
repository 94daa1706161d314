"""C#: DeviceState and HapticEvent with their enums, HapticPlane, and what Contact has of it;
and how HapticSession reads and writes them."""

from schema import MADE, Enum, Field, Message, Schema, pascal, wrapped

_TYPES = {"double": "double", "uint32": "uint", "uint64": "ulong", "int64": "long",
          "string": "string"}
_READ = {"double": "from.Real()", "uint32": "(uint)from.Number()", "uint64": "from.Number()",
         "int64": "(long)from.Number()", "string": "from.Text()"}


def _type(schema: Schema, field: Field) -> str:
    if field.kind == "enum":
        return schema.enums[field.type].called or field.type
    kind = field.type if field.kind == "message" else _TYPES[field.kind]
    return kind + ("[]" if field.repeated else "?" if field.optional else "")


def _read(schema: Schema, field: Field) -> str:
    to = f"to.{pascal(field.called)}"
    if field.kind == "message":
        return f"{to} = Of(from.Sub(), {to} ?? new {field.type}())"
    if field.repeated:
        return f"{to} = from.{'Reals' if field.kind == 'double' else 'Numbers'}({to})"
    if field.kind == "enum":
        return f"{to} = ({_type(schema, field)})from.Number()"
    return f"{to} = {_READ[field.kind]}"


def _write(field: Field) -> str:
    got = f"from.{pascal(field.called)}"
    if field.optional:
        return f"if ({got}.HasValue) to.Present({field.number}, {got}.Value);"
    kind = {"double": "Real", "uint32": "Number"}[field.kind] + "s" * field.repeated
    return f"to.{kind}({field.number}, {got});"


def _enum(enum: Enum) -> list[str]:
    names = [pascal(name) if name != "UNSPECIFIED" else "None" for name, _ in enum.values]
    values = ", ".join(f"{name} = {number}" for name, (_, number) in zip(names, enum.values))
    return ["", *wrapped(enum.comment, "/// "),
            *wrapped(f"public enum {enum.called or enum.name} {{ {values} }}", "", "  ")]


def _class(schema: Schema, name: str, comment: str, fields: list[Field], note,
           more: list[str]) -> list[str]:
    lines = ["", *wrapped(comment, "/// "), f"public sealed {name} {{"]
    for field in fields:
        kind = _type(schema, field)
        empty = f" = new {kind[:-1]}0]" if field.repeated else \
            ' = ""' if field.kind == "string" else ""
        lines += wrapped(note(field), "  /// ")
        lines.append(f"  public {kind} {pascal(field.called)}{empty};")
    return [*lines, *more, "}"]


def _name(message: Message) -> str:
    return "HapticEvent" if message.name == "Event" else message.name


def _reader(schema: Schema, message: Message) -> list[str]:
    name = _name(message)
    return ["", f"  static {name} Of(Reader from, {name} to) {{", "    while (from.Next()) {",
            "      switch (from.Field) {",
            *(f"        case {field.number}: {_read(schema, field)}; break;"
              for field in message.fields),
            "        default: from.Skip(); break;", "      }", "    }", "    return to;", "  }"]


def _file(types: list[str], session: list[str]) -> list[str]:
    """`session`: members of HapticSession."""
    return [f"// {MADE}", "namespace Haptic {", *types, "",
            "public sealed partial class HapticSession {", *session, "}", "",
            "}  // namespace Haptic"]


def state(schema: Schema) -> list[str]:
    messages = [*schema.state, schema.messages["Event"]]
    enums = [*schema.state_enums, schema.enums["Kind"]]
    types = [line for enum in enums for line in _enum(enum)]
    for message in messages:
        arrived = ["  internal long Arrived;  // by HapticSession's clock"]
        types += _class(schema, f"class {_name(message)}", message.comment, message.fields,
                        Field.about, arrived if message.name == "DeviceState" else [])
    waits = ", ".join(f'"{name}"' for name, number in schema.enums["EngageWait"].values if number)
    curable = ["", *wrapped(schema.enums["EngageWait"].comment, "  // "),
               "  static readonly System.Collections.Generic.HashSet<string> Curable =",
               *wrapped(f"new System.Collections.Generic.HashSet<string> {{ {waits} }};",
                        "      ", "          ")]
    readers = [line for message in messages for line in _reader(schema, message)]
    return _file(types, [*curable, *readers])


def plane(schema: Schema) -> list[str]:
    tells = [f"    to.{pascal(field.name)} = from.{pascal(field.name)}"
             f"{' / coupling' if field.by_coupling else ''};" for field in schema.told]
    tell = ["", "  internal static void Tell(Contact from, double coupling, HapticPlane to) {",
            *tells, "  }"]
    fields = schema.plane.fields
    types = [*_class(schema, "class HapticPlane", schema.plane.comment, fields, Field.of_plane, []),
             *_class(schema, "partial class Contact", "", schema.told, Field.of_contact, tell)]
    return _file(types, ["  static Message Of(HapticPlane from) {", "    var to = new Message();",
                         *(f"    {_write(field)}" for field in fields), "    return to;", "  }"])


KINDS = {
    "csharp": state,        # DeviceState and HapticEvent, and how they are read
    "csharp_plane": plane,  # HapticPlane, and what Contact has of it
}
