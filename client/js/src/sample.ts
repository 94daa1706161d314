/** Samples as they go up. */
import type { MessageInitShape } from "@bufbuild/protobuf";
import type { ProxySampleSchema, TrackerSampleSchema } from "./gen/haptic/v1/session_pb.js";
import type { Given } from "./newest_state.js";
import type { Plane, Pose, Proxy } from "./proxy.js";

/** `planes`: those of `proxy` that fit. `given`: the state that the user was last given. */
export function proxySample(proxy: Proxy, planes: Plane[], seq: bigint, given: Given | undefined,
                            nowMs: number): MessageInitShape<typeof ProxySampleSchema> {
  const used = proxy.deviceSeqUsed ?? given?.seq ?? 0n;
  const holdUs = used !== 0n && used === given?.seq ? (nowMs - given.receivedMs) * 1000 : 0;
  return {
    seq,
    sourceTimeNs: BigInt(Math.round(nowMs * 1e6)),
    deviceSeqUsed: used,
    holdUs: Math.min(Math.max(Math.trunc(holdUs), 0), 0xffffffff),
    validForUs: proxy.validForUs ?? 0,
    position: [...proxy.position],
    mode: proxy.mode,
    planes: planes.map((plane) => ({ ...plane })),
  };
}

export function trackerSample(pose: Pose,
                              seq: bigint): MessageInitShape<typeof TrackerSampleSchema> {
  return { seq, validForUs: pose.validForUs ?? 0, position: [...pose.position],
    orientation: [...pose.orientation] };
}
