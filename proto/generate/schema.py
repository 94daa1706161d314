"""The messages and enums of a descriptor set, with their comments and field options."""

import dataclasses
import textwrap

from google.protobuf import descriptor_pb2 as pb
from google.protobuf import descriptor_pool, message_factory

MADE = "Made of the messages in proto/haptic/v1 by proto/generate: nothing to edit here."
# Field numbers of descriptor.proto.
_FILE_MESSAGE, _FILE_ENUM, _ENUM_VALUE = 4, 5, 2
_MESSAGE_FIELD, _MESSAGE_MESSAGE, _MESSAGE_ENUM = 2, 3, 4
_PICTURES = "haptic/v1/drawing.proto"  # of the page alone
AXES = {"": "", "DOF": "per DoF", "ACTUATED": "per actuated DoF", "COORDINATE": "per coordinate"}


@dataclasses.dataclass(frozen=True)
class Field:
    """kind: double, uint32, enum, message, ...; type: name of the enum or message.

    axis: "", DOF, ACTUATED or COORDINATE. optional: its absence can be told from 0. The rest are
    options of field_options.proto.
    """

    message: str
    name: str
    number: int
    kind: str
    type: str
    repeated: bool
    optional: bool
    axis: str
    unit: str
    bits: str
    source: str
    called: str
    comment: str
    allowed: str
    by_coupling: bool
    of_geometry: bool
    placed: bool

    @property
    def is_time(self) -> bool:
        """Whole microseconds."""
        return self.kind == "uint64" and self.name.endswith("_us")

    def about(self, unit: str | None = None) -> str:
        """The comment, and [unit and axis]; `unit` if the language has it in another one."""
        unit = self.unit if unit is None else unit
        if "POSITION" in unit or "EFFORT" in unit:
            unit = " or ".join(unit.replace("POSITION", position).replace("EFFORT", effort)
                               for position, effort in (("m", "N"), ("rad", "N m")))
        return self._noted(" ".join(filter(None, [unit, AXES[self.axis]])))

    def of_plane(self) -> str:
        """The comment of a field of Plane, and [what the server takes]."""
        return self._noted(self.allowed)

    def of_contact(self) -> str:
        """The same of a contact, and [unit]."""
        return self._noted(self.unit)

    def _noted(self, note: str) -> str:
        return " ".join(filter(None, [self.comment, f"[{note}]" if note else ""]))


@dataclasses.dataclass(frozen=True)
class Message:
    name: str
    comment: str
    fields: list[Field]


@dataclasses.dataclass(frozen=True)
class Enum:
    """called: its name in the clients, "" if C++ has none. values: (NAME, number), without the
    enum's name before NAME; notes: a comment on each."""

    name: str
    called: str
    comment: str
    values: list[tuple[str, int]]
    notes: list[str]


class Schema:
    """`files`: the bytes that protoc --descriptor_set_out --include_imports --include_source_info
    makes."""

    def __init__(self, files: bytes) -> None:
        descriptors = pb.FileDescriptorSet.FromString(files)
        self._pool = descriptor_pool.DescriptorPool()
        for file in descriptors.file:
            self._pool.Add(file)
        self.messages: dict[str, Message] = {}
        self.enums: dict[str, Enum] = {}
        for file in descriptors.file:
            if file.package == "haptic.v1" and file.name != _PICTURES:
                self._read(file)

    def with_held(self, *names: str) -> list[Message]:
        """The messages, each after those that it holds."""
        unique = {}
        for name in names:
            held = [field.type for field in self.messages[name].fields
                    if field.type in self.messages]
            unique |= {message.name: message for message in self.with_held(*held)}
            unique[name] = self.messages[name]
        return list(unique.values())

    @property
    def state(self) -> list[Message]:
        """DeviceState, and before it the messages that it holds."""
        top = self.messages["DeviceState"]
        lists = [field.name for field in top.fields if field.kind == "message" and field.repeated]
        if lists:
            raise SystemExit(f"DeviceState.{lists[0]}: a list of messages has no place in a state")
        held = [field.type for field in top.fields if field.kind == "message"]
        return [*(self.messages[name] for name in held), top]

    @property
    def state_enums(self) -> list[Enum]:
        used = {field.type for message in self.state for field in message.fields
                if field.kind == "enum"}
        return [enum for enum in self.enums.values() if enum.name in used]

    @property
    def plane(self) -> Message:
        return self.messages["Plane"]

    @property
    def told(self) -> list[Field]:
        """Fields that a contact has as well: those that contact_at() does not make of its
        geometry."""
        return [field for field in self.plane.fields if not field.of_geometry]

    def _read(self, file: pb.FileDescriptorProto) -> None:
        places = file.source_code_info.location
        comments = {tuple(place.path): _joined(place) for place in places}
        for index, message in enumerate(file.message_type):
            self._message(message, (_FILE_MESSAGE, index), comments)
        for index, enum in enumerate(file.enum_type):
            self._enum(enum, (_FILE_ENUM, index), comments)

    def _message(self, message: pb.DescriptorProto, path: tuple[int, ...],
                 comments: dict[tuple[int, ...], str]) -> None:
        fields = [self._field(message.name, field, comments.get((*path, _MESSAGE_FIELD, i), ""))
                  for i, field in enumerate(message.field)]
        self.messages[message.name] = Message(message.name, comments.get(path, ""), fields)
        for i, held in enumerate(message.nested_type):
            self._message(held, (*path, _MESSAGE_MESSAGE, i), comments)
        for i, enum in enumerate(message.enum_type):
            self._enum(enum, (*path, _MESSAGE_ENUM, i), comments)

    def _enum(self, enum: pb.EnumDescriptorProto, path: tuple[int, ...],
              comments: dict[tuple[int, ...], str]) -> None:
        prefix = capitals(enum.name) + "_"
        self.enums[enum.name] = Enum(
            enum.name, self._options(enum, "EnumOptions")("called_enum"), comments.get(path, ""),
            [(value.name.removeprefix(prefix), value.number) for value in enum.value],
            [comments.get((*path, _ENUM_VALUE, i), "") for i in range(len(enum.value))])

    def _field(self, message: str, field: pb.FieldDescriptorProto, comment: str) -> Field:
        said = self._options(field, "FieldOptions")
        axes = self._pool.FindEnumTypeByName("haptic.v1.Axis").values_by_number
        axis = axes[said("axis")].name.removeprefix("AXIS_")
        kind = pb.FieldDescriptorProto.Type.Name(field.type).removeprefix("TYPE_").lower()
        if field.type_name == ".google.protobuf.Duration":
            kind = "duration"
        return Field(message, field.name, field.number, kind,
                     field.type_name.split(".")[-1], field.label == field.LABEL_REPEATED,
                     field.proto3_optional, "" if axis == "UNSPECIFIED" else axis, said("unit"),
                     said("bits"), said("from"), said("called") or field.name, comment,
                     said("allowed"), said("by_coupling"), said("of_geometry"), said("placed"))

    def _options(self, owner, name: str):
        """Reads an option of the field or enum by its name."""
        made = message_factory.MessageFactory(self._pool).GetPrototype(
            self._pool.FindMessageTypeByName(f"google.protobuf.{name}"))
        said = made.FromString(owner.options.SerializeToString()).Extensions
        return lambda option: said[self._pool.FindExtensionByName(f"haptic.v1.{option}")]


def wrapped(text: str, first: str, then: str = "", end: str = "") -> list[str]:
    """`text` in lines of at most 100 characters, which begin with `first` and `then`."""
    return textwrap.wrap(text + end, 100, initial_indent=first, subsequent_indent=then or first)


def pascal(name: str) -> str:
    return "".join(word.capitalize() for word in name.split("_"))


def _joined(place: pb.SourceCodeInfo.Location) -> str:
    return " ".join((place.leading_comments + place.trailing_comments).split())


def capitals(name: str) -> str:
    """"DEVICE_STATE_NAME" of DeviceStateName."""
    return "".join("_" + c if c.isupper() and i else c for i, c in enumerate(name)).upper()
