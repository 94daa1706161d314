"""Contacts from a simulation's geometry: where a point of the tool is, how near an object is to it,
and how that object gives way.

Frame: any one that point, normal and curvature share and that does not move with the coordinates:
the world, or the hand if the joints' angles are all that X has. Vectors have three values."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence

from ._types import Plane, contact

Vector = Sequence[float]

FASTEST_POINT = 0.5
"""m/s. Fingertips in recorded grasps move at 0.29 to 0.54 m/s (99 %); what is told too early costs
nothing but a place among the 8 nearest of its block."""
_UNKNOWN_ROUND_TRIP_S = 0.2


def _cross(a: Vector, b: Vector) -> tuple[float, ...]:
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def _dot(a: Vector, b: Vector) -> float:
    return sum(x * y for x, y in zip(a, b, strict=True))


@dataclasses.dataclass(frozen=True, slots=True)
class PointMap:
    """A point of the tool, and how it moves with n <= 8 consecutive coordinates."""

    first_coordinate: int
    position: Vector  # m
    jacobian: Sequence[Vector]  # n: dp/dx_j, m per unit of x_j
    second: Sequence[Vector] = ()  # d2p/dx_j dx_k: lower triangle, row by row; empty: 0


@dataclasses.dataclass(frozen=True, slots=True)
class JointAxis:
    """A joint as it stands now."""

    origin: Vector  # a point of the axis, m; without a meaning if prismatic
    axis: Vector  # of length 1; right-handed
    prismatic: bool = False


def point_on_joints(joints: Sequence[JointAxis], point: Vector,
                    first_coordinate: int = 0) -> PointMap:
    """Coordinates: the joints of a serial chain, rad or m, from the base on; `point` is on the last
    one's link. dp/dx_j = a_j x (p - o_j) and d2p/dx_j dx_k = a_j x dp/dx_k for j <= k; a prismatic
    joint k has dp/dx_k = a_k, and d2p/dx_j dx_k = 0 for a prismatic j."""
    slope = [tuple(j.axis) if j.prismatic else
             _cross(j.axis, [p - o for p, o in zip(point, j.origin, strict=True)]) for j in joints]
    second = [(0.0, 0.0, 0.0) if joints[j].prismatic else _cross(joints[j].axis, slope[k])
              for k in range(len(joints)) for j in range(k + 1)]
    return PointMap(first_coordinate, tuple(point), slope, second)


def point_on_finger(lengths: Sequence[float], x: Sequence[float], phalanx: int, along: float,
                    palmar: float = 0.0, first_coordinate: int = 0) -> PointMap:
    """Coordinates: the flexions of a planar finger (MCP, PIP), rad, from `first_coordinate` of x
    on. Frame: the finger's hand frame, origin on the first axis, +x distal, +y dorsal, so that at
    zero all phalanges lie along +x, and flexion turns them to -y. The point is `along` phalanx
    number `phalanx` (0, 1, ...) from its joint, and `palmar` of its line, m."""
    joints, origin, angle = [], (0.0, 0.0, 0.0), 0.0
    for k in range(phalanx + 1):
        if k > 0:
            origin = (origin[0] + lengths[k - 1] * math.cos(angle),
                      origin[1] - lengths[k - 1] * math.sin(angle), 0.0)
        angle += x[first_coordinate + k]
        joints.append(JointAxis(origin, (0.0, 0.0, -1.0)))
    c, s = math.cos(angle), math.sin(angle)
    point = (origin[0] + along * c - palmar * s, origin[1] - along * s - palmar * c, 0.0)
    return point_on_joints(joints, point, first_coordinate)


def point_itself(x: Sequence[float], first_coordinate: int = 0) -> PointMap:
    """Coordinates: x, y, z of the point itself (an output of kind point), m."""
    return PointMap(first_coordinate, tuple(x[first_coordinate:first_coordinate + 3]),
                    ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)))


def point_on_pose(x: Sequence[float], offset: Vector, first_coordinate: int = 0) -> PointMap:
    """Coordinates: x, y, z, m, and a quaternion qx, qy, qz, qw (an output of kind frame, a palm, a
    stylus). `offset`: the point in that frame, m. Derivatives are those of the normalised
    quaternion's map."""
    at = point_itself(x, first_coordinate)
    length = math.hypot(*x[first_coordinate + 3:first_coordinate + 7])
    q = [part / length for part in x[first_coordinate + 3:first_coordinate + 7]]
    v, w, r = q[:3], q[3], list(offset)
    # R r is a quadratic form of q with the second derivative 2 M.
    unit = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    twice = [[[0.0] * 3 for _ in range(4)] for _ in range(4)]
    for i in range(3):
        turn = _cross(unit[i], r)
        for k in range(3):
            for j in range(3):
                twice[i][j][k] = 2.0 * ((k == i) * r[j] + (k == j) * r[i] - (i == j) * r[k])
            twice[i][3][k] = twice[3][i][k] = 2.0 * turn[k]
    twice[3][3] = [2.0 * part for part in r]
    turned = [(w * w - _dot(v, v)) * r[k] + 2.0 * v[k] * _dot(v, r) + 2.0 * w * _cross(v, r)[k]
              for k in range(3)]
    # Of q^T M q / q^T q at a q of length 1.
    slope = [[sum(twice[i][j][k] * q[j] for j in range(4)) for k in range(3)] for i in range(4)]
    jacobian = [*at.jacobian,
                *([slope[i][k] - 2.0 * q[i] * turned[k] for k in range(3)] for i in range(4))]
    second = [[0.0, 0.0, 0.0] for _ in range(28)]
    for i in range(4):
        for j in range(i + 1):
            second[(3 + i) * (4 + i) // 2 + 3 + j] = [
                twice[i][j][k] - 2.0 * (slope[i][k] * q[j] + slope[j][k] * q[i]) +
                (8.0 * q[i] * q[j] - 2.0 * (i == j)) * turned[k] for k in range(3)]
    return PointMap(first_coordinate, [p + t for p, t in zip(at.position, turned, strict=True)],
                    jacobian, second)


def sphere_curvature(normal: Vector, distance: float) -> tuple[float, ...]:
    """Second derivative of a ball's gap by the point, 1/m: lower triangle xx, yx, yy, zx, zy, zz.
    `distance` of the point from its centre, m, != 0; < 0: the point is inside a hollow one, and the
    normal points inwards."""
    return _across((normal,), distance)


def cylinder_curvature(normal: Vector, axis: Vector, distance: float) -> tuple[float, ...]:
    """The same of a cylinder with this axis (of length 1); `distance` from the axis."""
    return _across((normal, axis), distance)


def _across(directions: Sequence[Vector], distance: float) -> tuple[float, ...]:
    return tuple(((i == j) - sum(a[i] * a[j] for a in directions)) / distance
                 for i in range(3) for j in range(i + 1))


def contact_at(position: Sequence[float], point: PointMap, normal: Vector, gap: float, *,
               coupling: float, stiffness: float = math.inf,
               curvature: Sequence[float] = (0.0,) * 6, velocity: float = 0.0,
               id: int = 0, mass: float = 0.0, damping: float = 0.0,
               ground_stiffness: float = 0.0, load: float = 0.0,
               uncertainty: float | None = None, object: int = 0,
               object_direction: Sequence[float] = ()) -> Plane:
    """The contact of a point of the tool with an object, linearised at the sample's `position`.

    normal: of the object at the nearest point, outwards, of length 1. gap: from the object to the
    point along it, m; below 0 inside. curvature: of the object, as sphere_curvature() gives it; 0
    is flat. stiffness: of point and object in series, N/m; infinite is rigid. coupling: of the
    simulation's own coupling, whose energy is coupling / 2 |x - x_probe|^2: N/m if x is in m, N
    m/rad if in rad. velocity: m/s, above 0 the object recedes. uncertainty: relative, of the
    stiffness, as in Plane. Raises ValueError if the point's coordinates do not lie within position.

    Of an object that is pushed, as felt along the normal (needs an id): mass, kg; damping, N s/m;
    ground_stiffness, N/m; load: the force on it now but for this contact's and the damping's, N,
    above 0 if it points away from the tool. If several contacts push it: object, one number for
    all of them; load is then without their forces, and each has the whole mass. object_direction:
    as in Plane; empty is the normal, of a body that does not turn. Say it yourself if the points of
    these contacts have different frames, as those of two fingers' point_on_finger() have."""
    n, first = len(point.jacobian), point.first_coordinate
    if not 0 <= first <= len(position) - n:
        raise ValueError(f"point.first_coordinate {first}, {n} coordinates: must lie within the "
                         f"{len(position)} of position")
    if len(point.second) not in (0, n * (n + 1) // 2):
        raise ValueError(f"point.second: has {len(point.second)} vectors, must have 0 or "
                         f"{n * (n + 1) // 2} for {n} coordinates")
    gradient = [0.0] * len(position)
    gradient[first:first + n] = [_dot(normal, column) for column in point.jacobian]
    xx, yx, yy, zx, zy, zz = curvature
    bent = [(xx * a + yx * b + zx * c, yx * a + yy * b + zy * c, zx * a + zy * b + zz * c)
            for a, b, c in point.jacobian]
    second = [_dot(point.jacobian[k], bent[j]) for j in range(n) for k in range(j + 1)]
    if point.second:
        second = [a + _dot(normal, b) for a, b in zip(second, point.second, strict=True)]
    return contact(position, gap, gradient, compliance=coupling / stiffness, velocity=velocity,
                   curvature=second if any(second) else (), first_coordinate=first, id=id,
                   mass=mass / coupling, damping=damping / coupling,
                   ground_stiffness=ground_stiffness / coupling, load=load / coupling,
                   uncertainty=uncertainty, object=object,
                   object_direction=object_direction or (tuple(normal) if object else ()))


def contact_horizon(round_trip_s: float, period_s: float, v_max: float = FASTEST_POINT) -> float:
    """Contacts with a gap up to this, m, should be told before they are touched: v_max (round trip
    + period), how far a point may get until the next sample's law is in use. round_trip_s:
    Session.round_trip_s; 0, not known yet: 200 ms are assumed."""
    return v_max * ((round_trip_s if round_trip_s > 0.0 else _UNKNOWN_ROUND_TRIP_S) + period_s)
