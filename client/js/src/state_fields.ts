/** The fields of a device's state by name, with their labels and units: for tables, as `hapticctl
 * watch` shows them. All of it comes from the descriptor of DeviceState. */
import { getOption, hasOption } from "@bufbuild/protobuf";
import type { DescEnum, DescField, DescMessage, Message } from "@bufbuild/protobuf";
import { reflect } from "@bufbuild/protobuf/reflect";
import type { ReflectMessage } from "@bufbuild/protobuf/reflect";
import { Axis, axis, bits, unit, words } from "./gen/haptic/v1/field_options_pb.js";
import type { Device } from "./gen/haptic/v1/haptic_service_pb.js";
import { DeviceStateSchema } from "./gen/haptic/v1/session_pb.js";
import type { DeviceState } from "./gen/haptic/v1/session_pb.js";

export interface StateField {
  /** Name in session.proto: "tau_a". */
  name: string;
  kind: "number" | "name" | "bits" | "message";
  repeated: boolean;
  /** Things that the values of a repeated field belong to; "": nothing that has a name. */
  axis: "dof" | "actuated" | "coordinate" | "";
  /** Per value: names of DoFs or virtual coordinates; empty without an axis. */
  labels: string[];
  /** Per label, or one without an axis: "N m/rad"; "": none. */
  units: string[];
  /** number: itself; name: "ENGAGED"; bits: names apart by "|". Empty if the field is absent. */
  values: (number | bigint | string)[];
  /** message: its fields; without values if it is absent. */
  fields: StateField[];
}

interface Label {
  name: string;
  unit: string;
}
type Labels = (axis: Axis) => Label[];

const AXES = { [Axis.UNSPECIFIED]: "", [Axis.DOF]: "dof", [Axis.ACTUATED]: "actuated",
  [Axis.COORDINATE]: "coordinate" } as const;

/** Every field that the protocol has, in its order. */
export function stateFields(device: Device, state: DeviceState): StateField[] {
  const labels: Labels = (which) =>
    which === Axis.DOF ? device.dofs
      : which === Axis.ACTUATED ? device.dofs.filter(({ actuated }) => actuated)
        : which === Axis.COORDINATE ? device.coordinates : [];
  return fieldsOf(DeviceStateSchema, state, labels);
}

function fieldsOf(type: DescMessage, message: Message | undefined, labels: Labels): StateField[] {
  const held = message && reflect(type, message);
  return type.fields.map((field) => {
    const which = getOption(field, axis), named = labels(which);
    const values = valuesOf(field, held);
    return {
      name: field.name,
      kind: kindOf(field),
      repeated: field.fieldKind === "list",
      axis: AXES[which],
      labels: named.map(({ name }) => name),
      units: which === Axis.UNSPECIFIED ? [unitOf(field, "")]
                                        : named.map((label) => unitOf(field, label.unit)),
      values: field.message ? [] : values.map((value) => shown(field, value)),
      fields: !field.message ? []
        : fieldsOf(field.message, (values[0] as ReflectMessage | undefined)?.message, labels),
    };
  });
}

function kindOf(field: DescField): StateField["kind"] {
  if (field.message) return "message";
  return field.enum ? "name" : hasOption(field, bits) ? "bits" : "number";
}

function valuesOf(field: DescField, held: ReflectMessage | undefined): unknown[] {
  if (held === undefined || field.fieldKind === "map") return [];
  if (field.fieldKind === "list") return [...held.get(field)];
  return field.fieldKind === "message" && !held.isSet(field) ? [] : [held.get(field)];
}

function shown(field: DescField, value: unknown): number | bigint | string {
  if (field.enum) return enumName(field.enum, value as number);
  if (hasOption(field, bits)) return namesOf(field, value as number).join("|");
  return value as number | bigint | string;
}

/** Unit of the force on what slides ("m"), and of the torque on what turns. */
export const effortUnit = (position: string): string => (position === "m" ? "N" : "N m");

const unitOf = (field: DescField, position: string): string =>
  getOption(field, unit).replace("POSITION", position).replace("EFFORT", effortUnit(position));

/** "ENGAGED" for DeviceStateName.ENGAGED; a number that the library does not know is itself. */
export function enumName(type: DescEnum, value: number): string {
  const name = type.value[value]?.name;
  if (name === undefined) return String(value);
  const short = name.slice(type.sharedPrefix?.length ?? 0);
  return short.toUpperCase() === "UNSPECIFIED" ? "NONE" : short;
}

/** The names of bits of a state: bitNames("faults", state.faults) is ["LOOP_LATE"], for example. A
 * bit without a name is its number. */
export function bitNames(field: "faults" | "limiters" | "activePlanes", value: number): string[] {
  return namesOf(DeviceStateSchema.field[field], value);
}

/** A bit that is set, in words. */
export interface BitWords {
  name: string;  // "SLEW"
  title: string;
  help: string;
}

/** The same with words for people. */
export function bitWords(field: "faults" | "limiters", value: number): BitWords[] {
  const type = DeviceStateSchema.field[field], told = getOption(type, words);
  return setBits(value).map((bit) => {
    const name = nameOf(type, bit);
    const [, title, help] = /^(.*?): (.*)$/.exec(told[bit] ?? "") ??
      ["", `Bit ${name}`, "This program does not know it: it is newer."];
    return { name, title: title!, help: help! };
  });
}

const setBits = (value: number): number[] =>
  Array.from({ length: 32 }, (_, bit) => bit).filter((bit) => (value >>> bit) & 1);

function nameOf(field: DescField, bit: number): string {
  const name = getOption(field, bits).split(" ")[bit] ?? "-";
  return name === "-" ? String(bit) : name;
}

const namesOf = (field: DescField, value: number): string[] =>
  setBits(value).map((bit) => nameOf(field, bit));
