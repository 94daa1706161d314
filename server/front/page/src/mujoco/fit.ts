// Says before MuJoCo loads a scene if it is for a device.

/** The first coordinate of the device that the model has no joint, site or body for, by the names
 * that `byName` of hapticd/mujoco goes by; empty: it fits. */
export function misfit(xml: string, coordinates: readonly { name: string }[]): string {
  const tags = xml.matchAll(/<(joint|site|body)\s[^>]*?\bname="([^"]*)"/g);
  const joints = new Set<string>(), places = new Set<string>();
  for (const [, kind, name] of tags) (kind === "joint" ? joints : places).add(name!);
  const known = ({ name }: { name: string }): boolean =>
    joints.has(name) || places.has(name.replace(/\.[^.]*$/, ""));
  return coordinates.find((coordinate) => !known(coordinate))?.name ?? "";
}
