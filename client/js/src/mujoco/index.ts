/** hapticd/mujoco - makes a simulation by MuJoCo's WebAssembly build (@mujoco/mujoco) haptic: the
 * part of the model that the device moves follows the device by springs, and what it meets is told
 * to hapticd as contacts. The counterpart of haptic::mujoco (client/mujoco).
 *
 *   import loadMujoco from "@mujoco/mujoco";
 *   import { Tool, joint } from "hapticd/mujoco";
 *   const mujoco = await loadMujoco();
 *   const model = mujoco.MjModel.from_xml_string(xml), data = new mujoco.MjData(model);
 *   const finger = new Tool(mujoco, model, data, [joint("q_o1_mcp", 0), joint("q_o2_pip", 1)],
 *                           { coupling: 0.15 });
 *   session.engageWhenReady();
 *   for await (const { xProbe } of session.states()) {
 *     session.publish(finger.step(xProbe, 1000 / 60, session.roundTripMs));
 *   }
 *
 * The coupling. In each bound coordinate a spring c w (xProbe - x) pulls the tool, with critical
 * damping against the probe's own rate, so that the tool does not lag in free motion; c is
 * `coupling`, w the scene's metric. They are generalised forces (qfrc_applied) and not a mocap body
 * with a weld: a weld's stiffness depends on the masses that it meets, and c must be known, because
 * the server solves the same balance. Weight and passive forces of the bound joints are taken off,
 * so only contacts hold the tool back. Their limits, friction and actuators are taken off too: the
 * hand that wears the device is where it is, whatever the model thinks.
 *
 * Equalities and tendons that couple joints (a DIP that follows its PIP, a closed chain) carry on
 * the force of a contact. What bound joints move by them is the tool, with all of the above. Once a
 * second what is told is compared with what holds the tool back (ToolOptions.warn).
 *
 * The published proxy is the balance x = xProbe + W^-1 sum J_i^T n_i f_i / c, with the normal
 * forces f_i that MuJoCo computed (mj_contactForce): the proxy of a tool without mass. In free
 * motion it is xProbe to the bit. Friction is not told.  Units are SI: m, rad, N, kg. Frame:
 * MuJoCo's world. */
export { byName, joint, point, pose } from "./binding.js";
export type { Binding } from "./binding.js";
export { ContactSpring } from "./contact_spring.js";
export { Engine } from "./engine.js";
export type { Jumps, ToolOptions } from "./options.js";
export { Tool } from "./tool.js";
