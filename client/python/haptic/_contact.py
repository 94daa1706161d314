"""Contacts from a simulation's geometry: where a point of the tool is, how near an object is to it,
and how that object gives way.

Frame: any one that point, normal and curvature share and that does not move with the coordinates:
the world, or the hand if the joints' angles are all that X has. Vectors have three values."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Iterable, Sequence
from typing import Any

from ._facts import Coordinate
from ._library import compute, doubles, ffi, floats, lib, lists, new
from ._messages import Plane, Told
from ._types import FREE, Proxy, behind

Vector = Iterable[float]
_EXPECTED_CONTACTS = 64  # of haptic_solve(), for which there is room at first

FASTEST_POINT = 0.5
"""m/s. Fingertips in recorded grasps move at 0.29 to 0.54 m/s (99 %); what is told too early costs
nothing but a place among the 8 nearest of its block."""


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


def _made(function: Callable[..., int], *arguments: Any) -> PointMap:
    c = new("haptic_point")
    compute(function, *arguments, c)
    second = c.count * (c.count + 1) // 2 if c.has_second else 0
    return PointMap(c.first_coordinate, lists(c.position, 3),
                    tuple(lists(c.jacobian[j], 3) for j in range(c.count)),
                    tuple(lists(c.second[k], 3) for k in range(second)))


def point_on_joints(joints: Iterable[JointAxis], point: Vector,
                    first_coordinate: int = 0) -> PointMap:
    """Coordinates: the joints of a serial chain, rad or m, from the base on, at most 8; `point` is
    on the last one's link. dp/dx_j = a_j x (p - o_j) and d2p/dx_j dx_k = a_j x dp/dx_k for j <= k;
    a prismatic joint k has dp/dx_k = a_k, and d2p/dx_j dx_k = 0 for a prismatic j."""
    chain = ffi.new("haptic_joint[]", [
        (floats(joint.origin, 3, "origin"), floats(joint.axis, 3, "axis"), joint.prismatic)
        for joint in joints])
    return _made(lib.haptic_point_on_joints, chain, len(chain), doubles(point, 3, "point"),
                 first_coordinate)


def point_on_finger(lengths: Vector, x: Vector, phalanx: int, along: float, palmar: float = 0.0,
                    first_coordinate: int = 0) -> PointMap:
    """Coordinates: the flexions of a planar finger (MCP, PIP), rad, from `first_coordinate` of x
    on. Frame: the finger's hand frame, origin on the first axis, +x distal, +y dorsal, so that at
    zero all phalanges lie along +x, and flexion turns them to -y. The point is `along` phalanx
    number `phalanx` (0, 1, ...) from its joint, and `palmar` of its line, m."""
    phalanges, place = doubles(lengths), doubles(x)
    return _made(lib.haptic_point_on_finger, phalanges, len(phalanges), place, len(place), phalanx,
                 along, palmar, first_coordinate)


def point_itself(x: Vector, first_coordinate: int = 0) -> PointMap:
    """Coordinates: x, y, z of the point itself (an output of kind point), m."""
    place = doubles(x)
    return _made(lib.haptic_point_itself, place, len(place), first_coordinate)


def point_on_pose(x: Vector, offset: Vector, first_coordinate: int = 0) -> PointMap:
    """Coordinates: x, y, z, m, and a quaternion qx, qy, qz, qw (an output of kind frame, a palm, a
    stylus). `offset`: the point in that frame, m. Derivatives are those of the normalised
    quaternion's map."""
    place = doubles(x)
    return _made(lib.haptic_point_on_pose, place, len(place), doubles(offset, 3, "offset"),
                 first_coordinate)


def sphere_curvature(normal: Vector, distance: float) -> tuple[float, ...]:
    """Second derivative of a ball's gap by the point, 1/m: lower triangle xx, yx, yy, zx, zy, zz.
    `distance` of the point from its centre, m, != 0; < 0: the point is inside a hollow one, and the
    normal points inwards."""
    curvature = ffi.new("double[6]")
    compute(lib.haptic_sphere_curvature, doubles(normal, 3, "normal"), distance, curvature)
    return lists(curvature, 6)


def cylinder_curvature(normal: Vector, axis: Vector, distance: float) -> tuple[float, ...]:
    """The same of a cylinder with this axis (of length 1); `distance` from the axis."""
    curvature = ffi.new("double[6]")
    compute(lib.haptic_cylinder_curvature, doubles(normal, 3, "normal"), doubles(axis, 3, "axis"),
            distance, curvature)
    return lists(curvature, 6)


@dataclasses.dataclass(frozen=True, slots=True)
class Contact(Told):
    """A point of the tool against an object. It has the fields of Told as well, by name: velocity,
    id, mass and what else a Plane tells, in the units of the object. An empty object_direction is
    the normal, of a body that does not turn; say it yourself if the points of contacts on one
    object have different frames, as those of two fingers' point_on_finger() have."""

    point: PointMap
    normal: Vector  # of the object at the nearest point, outwards, of length 1
    gap: float  # from the object to the point along the normal, m; below 0 inside
    stiffness: float = math.inf  # of point and object in series, N/m; infinite is rigid
    curvature: Vector = (0.0,) * 6  # of the object, as sphere_curvature() gives it; 0 is flat

    def fill(self, c: Any) -> None:
        point, n, second = c.point, len(self.point.jacobian), len(self.point.second)
        if n > lib.HAPTIC_MAX_POINT_COORDINATES or second not in (0, n * (n + 1) // 2):
            raise ValueError(f"point: has {n} coordinates, must have at most "
                             f"{lib.HAPTIC_MAX_POINT_COORDINATES}; second: has {second} vectors, "
                             f"must have 0 or {n * (n + 1) // 2}")
        point.first_coordinate, point.count = self.point.first_coordinate, n
        point.has_second = second > 0
        point.position = floats(self.point.position, 3, "point.position")
        point.jacobian[0:n] = [floats(each, 3, "point.jacobian") for each in self.point.jacobian]
        point.second[0:second] = [floats(each, 3, "point.second") for each in self.point.second]
        if self.stiffness == 0.0:  # C takes it for rigid
            raise ValueError("stiffness: 0, must be > 0")
        c.normal = floats(self.normal, 3, "normal")
        c.curvature = floats(self.curvature, 6, "curvature")
        c.gap, c.stiffness = self.gap, self.stiffness
        self.tell(c)


def contact_at(x: Vector, contact: Contact, coupling: float) -> Plane:
    """The contact as the server takes it, linearised at the sample's position x. `coupling`: of the
    simulation's own coupling, whose energy is coupling / 2 |x - x_probe|^2: N/m if x is in m, N
    m/rad if in rad. Raises ValueError if the point's coordinates do not lie within x."""
    c, place, plane = new("haptic_contact"), doubles(x), new("haptic_plane")
    c.point.size = ffi.sizeof("haptic_point")
    contact.fill(c)
    compute(lib.haptic_contact_at, place, len(place), c, coupling, plane)
    return Plane.of(plane, len(place))


@dataclasses.dataclass(frozen=True, slots=True)
class Solution:
    x: tuple[float, ...]  # the proxy
    planes: tuple[Plane, ...]  # contact_at() of all contacts at x
    converged: bool  # False: x is the best that was found; the next step goes on from there
    iterations: int

    def proxy(self) -> Proxy:
        """For publish()."""
        return behind(self.planes, self.x) if len(self.planes) > 0 else FREE


def solve(contacts: Callable[[tuple[float, ...]], Iterable[Contact]], x_probe: Vector,
          coupling: float, *, start: Vector | None = None, weights: Vector | None = None,
          iterations: int = 50, tolerance: float = 1e-10) -> Solution:
    """The proxy of a simulation that has contacts and no solver of its own: the x near `start` that
    minimises coupling / 2 |x - x_probe|^2 + stiffness / 2 sum of gap^2 over what is touched, with
    gap >= 0 where a contact is rigid. contacts(x): those at x, touched or near; it is called 5 to
    20 times as a rule. `start`: the last proxy, so that the tool stays on the side of each object
    that it came from; None: the probe. Let a probe that jumped come in pieces of a few mm or 0.05
    rad. `weights`: of each coordinate's distance. Raises ValueError, and what contacts() raises."""
    probe, raised = doubles(x_probe), []

    @ffi.callback("haptic_contacts_at")  # type: ignore[misc]
    def told(x: Any, count: int, made: Any, capacity: int, _: Any) -> int:
        try:
            found = list(contacts(lists(x, count)))
            for i, contact in enumerate(found[:capacity]):
                contact.fill(made[i])
            return len(found)
        except BaseException as error:
            raised.append(error)
            return -1

    options, solution = new("haptic_solve_options"), new("haptic_solution")
    kept = [doubles(start, len(probe), "start") if start is not None else ffi.NULL,
            doubles(weights, len(probe), "weights") if weights is not None else ffi.NULL]
    options.start, options.weights = kept
    options.iterations, options.tolerance = iterations, tolerance
    solution.plane_count = _EXPECTED_CONTACTS
    planes: Any = ()
    while solution.plane_count > len(planes):
        planes = ffi.new("haptic_plane[]", solution.plane_count)
        planes[0].size = ffi.sizeof("haptic_plane")
        try:
            compute(lib.haptic_solve, told, ffi.NULL, probe, len(probe), coupling, options,
                    solution, planes, len(planes))
        except ValueError:
            if len(raised) > 0:
                raise raised[0] from None
            raise
    return Solution(lists(solution.x.value, len(probe)),
                    tuple(Plane.of(planes[i], len(probe)) for i in range(solution.plane_count)),
                    bool(solution.converged == 1), solution.iterations)


def contact(position: Vector, gap: float, gradient: Vector, **law: Any) -> Plane:
    """The contact with this gap (>= 0: not touched) and gradient of the gap at `position`, the
    sample's. `law`: the other fields of Plane, compliance, velocity, id, ..."""
    place, c = doubles(position), new("haptic_plane")
    compute(lib.haptic_contact_of_gap, place, doubles(gradient, len(place), "gradient"), len(place),
            gap, c)
    return dataclasses.replace(Plane.of(c, len(place)), **law)


def contact_horizon(round_trip_s: float, period_s: float, v_max: float = FASTEST_POINT) -> float:
    """Contacts with a gap up to this, m, should be told before they are touched: v_max (round trip
    + period), how far a point may get until the next sample's law is in use. round_trip_s:
    Session.round_trip_s; 0, not known yet: 200 ms are assumed."""
    return float(lib.haptic_contact_horizon(round(round_trip_s * 1e9), round(period_s * 1e9),
                                            v_max))


def derive_planes(coordinates: Sequence[Coordinate], x: Vector, x_probe: Vector,
                  blocks: Iterable[tuple[int, int]] = (), least: float = 1e-9) -> list[Plane]:
    """One plane per block (first coordinate, how many), through the proxy x and with the normal
    x_probe - x; none for a block whose proxy is within `least` (m or rad) of its probe. No blocks:
    all coordinates are one. `coordinates`: of Session.device. session(derive_planes=True) does this
    by itself, and adds how the object gives way."""
    n = len(coordinates)
    kinds = ffi.new("haptic_coordinate[]", n)
    for c, coordinate in zip(kinds, coordinates):
        c.kind = coordinate.kind.encode()
    pairs = ffi.new("haptic_block[]", [tuple(map(int, block)) for block in blocks])
    planes, count = ffi.new("haptic_plane[]", n), ffi.new("size_t *")
    if n > 0:
        planes[0].size = ffi.sizeof("haptic_plane")
    compute(lib.haptic_derive_planes, kinds, doubles(x, n, "x"), doubles(x_probe, n, "x_probe"), n,
            pairs, len(pairs), least, planes, n, count)
    return [Plane.of(planes[i], n) for i in range(count[0])]
