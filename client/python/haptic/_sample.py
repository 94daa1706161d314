"""A sample as it goes up: the planes that fit, and how two places in X differ."""

from __future__ import annotations

import dataclasses
import math
import time
from collections.abc import Sequence

from ._types import Plane, Proxy
from .v1 import session_pb2 as wire

# Of one sample, proto/README.md.
MAX_PLANES, MAX_CONTACTS_OF_BLOCK, MAX_CURVATURES, MAX_NUMBERS_OF_PLANE = 32, 8, 320, 80


def difference(kinds: Sequence[str], x_probe: Sequence[float],
               x: Sequence[float]) -> list[float]:
    """x_probe (-) x, as the server takes it, by the coordinates' kinds: an angle the short way
    round, a quaternion with the sign that is nearer to x."""
    away = [p - a for p, a in zip(x_probe, x, strict=True)]
    quaternion: list[int] = []
    for i, kind in enumerate(kinds):
        if kind == "angle":
            away[i] = math.remainder(away[i], math.tau)
        quaternion = [*quaternion, i] if kind == "quaternion" else []
        if len(quaternion) == 4:
            if sum(x_probe[k] * x[k] for k in quaternion) < 0.0:
                for k in quaternion:
                    away[k] = -x_probe[k] - x[k]
            quaternion = []
    return away


def deepest(planes: Sequence[Plane], position: Sequence[float], x_probe: Sequence[float],
            kinds: Sequence[str]) -> list[Plane]:
    """The planes that x_probe is deepest beyond, or nearest to, in their order. From the deepest on
    it takes up to 32; a contact (a plane with compliance, curvature or id) only if fewer than 8 of
    those taken share a coordinate with it. A curvature that has no room left becomes 0. `position`:
    where they are linearised, and the probe if that is not known (empty)."""
    probe = list(position)
    if len(position) == len(x_probe) == len(kinds):
        probe = [x + d for x, d in zip(position, difference(kinds, x_probe, position),
                                       strict=True)]

    def depth(plane: Plane) -> float:
        length = math.hypot(*plane.normal)
        beyond = sum(n * p for n, p in zip(plane.normal, probe, strict=False)) - plane.offset
        return beyond / length if length > 0.0 and math.isfinite(beyond) else -math.inf

    def is_contact(plane: Plane) -> bool:
        return plane.compliance > 0.0 or bool(plane.curvature) or plane.id != 0

    def share(a: Plane, b: Plane) -> bool:
        return any(x and y for x, y in zip(a.normal, b.normal, strict=False))

    chosen: dict[int, Plane] = {}
    curvatures = 0
    for i in sorted(range(len(planes)), key=lambda i: -depth(planes[i])):
        plane = planes[i]
        near = sum(is_contact(other) and share(other, plane) for other in chosen.values())
        if len(chosen) == MAX_PLANES or (is_contact(plane) and near >= MAX_CONTACTS_OF_BLOCK):
            continue
        count = len(plane.curvature)
        if (curvatures + count > MAX_CURVATURES or
                len(plane.normal) + count > MAX_NUMBERS_OF_PLANE):
            plane, count = dataclasses.replace(plane, curvature=(), uncertainty=None), 0
        chosen[i] = plane
        curvatures += count
    return [chosen[i] for i in sorted(chosen)]


def with_deepest(proxy: Proxy, x_probe: Sequence[float], kinds: Sequence[str]) -> Proxy:
    """`proxy` as it can be sent; x_probe: empty if it is not known."""
    planes = deepest(proxy.planes, proxy.position, x_probe, kinds)
    return dataclasses.replace(proxy, planes=tuple(planes))


def to_sample(proxy: Proxy, seq: int, used: int) -> wire.ProxySample:
    """`used`: number of the state that it was computed from."""
    return wire.ProxySample(
        seq=seq, source_time_ns=time.monotonic_ns(), mode=proxy.mode, position=proxy.position,
        device_seq_used=used,
        planes=[wire.Plane(**dataclasses.asdict(plane)) for plane in proxy.planes])
