/** Prints the fields that only a test declares: of a state's bytes as members and in the list of
 * stateFields(), and of a contact of 3 N with a coupling of 2 N/m. */
import { readFileSync } from "node:fs";
import { create, fromBinary } from "@bufbuild/protobuf";
import { DeviceSchema } from "./gen/haptic/v1/haptic_service_pb.js";
import { DeviceStateSchema } from "./gen/haptic/v1/session_pb.js";
import { type Contact, contactAt, pointItself } from "./contact.js";
import { stateFields } from "./state_fields.js";

const state = fromBinary(DeviceStateSchema, readFileSync(process.argv[2]!));
const device = create(DeviceSchema, { dofs: [{ name: "slide", unit: "m", actuated: true }] });
const listed = stateFields(device, state).filter(({ name }) => name.startsWith("tested"));
console.log(state.tested, state.testedList[0]);
for (const { values, units } of listed) console.log(String(values[0]), units[0]);
const contact: Contact =
  { point: pointItself([0, 0, 0]), normal: [1, 0, 0], gap: 0, stickiness: 3 };
console.log(contactAt([0, 0, 0], contact, 2).stickiness);
