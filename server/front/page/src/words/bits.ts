// Faults and limiters in words, by the names that the protocol gives their bits
// (proto/README.md#faults-and-limiters).

import { bitNames } from "hapticd";

export interface Words {
  name: string; // the protocol's: "SLEW"
  title: string;
  help: string;
}

const WORDS: Record<string, [title: string, help: string]> = {
  // Faults.
  DEVICE_SILENT: ["The device is silent", "It sent no sample for too long. Check its cable."],
  DEVICE_LOST: ["The device is gone", "The device, or the link to it, does not answer."],
  SAMPLE_NOT_FINITE: ["A sensor gave no number", "A position of the device was not a number."],
  SAMPLE_OUT_OF_RANGE: [
    "A position is out of range",
    "A sensor said that the device stands where it cannot stand.",
  ],
  LOOP_LATE: ["The control loop was late", "The computer was too busy to keep time once."],
  LATE_BUCKET_FULL: ["The control loop is late often", "The computer is too busy to keep time."],
  EMERGENCY_STOP: ["Emergency stop", "A person or a program pressed stop."],
  FORCE_OVER_LIMIT: ["Too much force", "The device measured more force than it may give."],
  OUTPUT_NOT_FINITE: [
    "The computed force was no number",
    "This is a defect of hapticd. Please report it.",
  ],
  FORCE_OUT_OF_RANGE: ["Force sensor out of range", "It reads more than it can measure."],
  FORCE_TOO_FAST: ["Force sensor jumped", "Its reading grew faster than a force can."],
  FORCE_STUCK: ["Force sensor is stuck", "It gives the same reading while the drive moves."],
  FORCE_DISAGREES: [
    "Force sensor disagrees",
    "It is further from what the drive gives than friction explains.",
  ],

  // Limiters.
  SATURATION: ["At the force limit", "More force was asked for than the scene allows."],
  SLEW: ["Force rises as fast as allowed", "It would have changed faster than the scene allows."],
  ENVELOPE: ["Force is being faded in or out", "It is held under its share of the limit."],
  DIRECTION_GUARD: [
    "Direction guard",
    "Force that would have pushed away from the proxy, or into a contact, was withheld.",
  ],
  RANGE_CLAMP: ["At the end of the range", "The device cannot move to where the spring pulls."],
  ENERGY_TANK: ["Energy tank is empty", "A change that it cannot pay for was held back."],
  PASSIVITY: ["Damping added", "The passivity controller takes energy out."],
  INFEASIBLE_PLANES: ["Surfaces contradict each other", "The least bad position is used."],
  POWER: ["At the rated power", "The actuator would have given out more than its rated power."],
  RATE: ["At the rated speed", "The actuator does not push beyond its rated speed."],
  TEMPERATURE: ["Windings are warm", "Force is held at what their temperature allows."],
  DRIVE_LIMIT: ["Drive at its limit", "Output, rate or travel of the drive is at its limit."],
  CONTACTS: [
    "Held back between contacts",
    "What one contact asks for would push the tool into another.",
  ],
  SINGULAR: ["Near a singular pose", "The motion of the device is damped there."],
  BRANCH: ["Two poses are equally near", "The spring stays with one, or changes in steps."],
  NEVER_FREE: [
    "Force waits for free space",
    "The tool was in contact from the beginning. Move the simulation's tool into the open once.",
  ],
  DERATED: ["Softer, because of delay", "A stiffer spring would shake at this delay."],
};

/** Words of each bit that is set. */
export function bitWords(field: "faults" | "limiters", bits: number): Words[] {
  return bitNames(field, bits).map((name) => {
    const newer = [`Bit ${name}`, "This page does not know it: it is newer."] as const;
    const [title, help] = WORDS[name] ?? newer;
    return { name, title, help };
  });
}
