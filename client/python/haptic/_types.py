"""What goes in and out: plain frozen values. Fields as in proto/haptic/v1/*.proto."""

from __future__ import annotations

import dataclasses
import enum
from collections.abc import Sequence

from ._names import name_of
from .v1 import haptic_service_pb2 as service
from .v1 import session_pb2 as wire


class Carriers(enum.Enum):
    """What may carry samples and states."""

    BEST = "best"  # UDP while it proves good, the stream otherwise
    STREAM = "stream"  # the gRPC stream alone


@dataclasses.dataclass(frozen=True, slots=True)
class Plane:
    """What the proxy may not pass, normal . x <= offset, or a contact, which also says how the
    object gives way, curves and moves (proto/README.md, Contacts)."""

    normal: tuple[float, ...]  # per coordinate; minus the gradient of the gap
    offset: float
    compliance: float = 0.0  # coupling / stiffness of the contact; 0: rigid
    velocity: float = 0.0  # of the offset, per s; above 0 the object recedes
    curvature: tuple[float, ...] = ()  # second derivative of the gap: lower triangle, row by row,
    first_coordinate: int = 0  # of the coordinates from this one on
    id: int = 0  # names the contact from sample to sample; 0: none
    # An object that is pushed, as felt along the normal, all by the stiffness of the coupling: its
    # mass, 0 if it is not pushed; damping and stiffness to ground; and the force on it at this
    # sample but for the contact's and the damping's, above 0 if it pushes the object away.
    mass: float = 0.0
    damping: float = 0.0
    ground_stiffness: float = 0.0
    load: float = 0.0
    uncertainty: float | None = None  # relative, of the stiffness; in all planes of a sample: the
    # states say how far the force felt may be off, error_bound
    # Contacts with the same object push the same body: a push at one moves the others too. 0: no
    # other contact is on the body. An object needs a mass and a direction.
    # object_direction: how the contact pushes the body, 1 to 6 numbers, a vector of length 1. Of a
    # body that does not turn it is the outward normal n. Of a body that turns, with inertia M and
    # Jacobian J of the contact's point, it is M^-1/2 J^T n divided by its length.
    object: int = 0
    object_direction: tuple[float, ...] = ()


@dataclasses.dataclass(frozen=True, slots=True)
class Proxy:
    """Where the virtual object lets the tool be. Made by held(), behind(), or FREE."""

    mode: wire.ProxyMode
    position: tuple[float, ...] = ()
    planes: tuple[Plane, ...] = ()


FREE = Proxy(wire.PROXY_MODE_FREE)
"""Nothing in the way: no elastic force, no drag."""


def held(position: Sequence[float]) -> Proxy:
    """The proxy stays here until the next sample; m or rad per virtual coordinate. A coordinate in
    which this is the x_probe of the state that was used follows the probe instead, as if free,
    unless the sample before held it at the same value. Force begins with a held proxy only after a
    FREE one: it does not say on which side of an object the probe is."""
    return Proxy(wire.PROXY_MODE_HELD, tuple(map(float, position)))


def behind(planes: Sequence[Plane | tuple[Sequence[float], float]],
           position: Sequence[float]) -> Proxy:
    """The server keeps the probe out of `planes`, contact()s or (normal, offset) each: normal . x
    <= offset, linearised at `position`. They say which way is out, so force may begin inside. Of
    more than 32, and of more than 8 contacts of a block, the deepest are sent."""
    return Proxy(wire.PROXY_MODE_PLANES, tuple(map(float, position)),
                 tuple(plane if isinstance(plane, Plane) else
                       Plane(tuple(map(float, plane[0])), float(plane[1])) for plane in planes))


def contact(position: Sequence[float], gap: float, gradient: Sequence[float], *,
            compliance: float = 0.0, velocity: float = 0.0, curvature: Sequence[float] = (),
            first_coordinate: int = 0, id: int = 0, mass: float = 0.0, damping: float = 0.0,
            ground_stiffness: float = 0.0, load: float = 0.0,
            uncertainty: float | None = None, object: int = 0,
            object_direction: Sequence[float] = ()) -> Plane:
    """The contact with this gap (>= 0: not touched) and gradient of the gap at `position`, the
    sample's; the other fields as in Plane."""
    offset = gap - sum(g * x for g, x in zip(gradient, position, strict=True))
    return Plane(tuple(-float(g) for g in gradient), float(offset), float(compliance),
                 float(velocity), tuple(map(float, curvature)), first_coordinate, id,
                 float(mass), float(damping), float(ground_stiffness), float(load),
                 uncertainty, object, tuple(map(float, object_direction)))


@dataclasses.dataclass(frozen=True, slots=True)
class Pose:
    """Where the tracked body is that carries a device, in the world: what a tracker publishes."""

    position: tuple[float, float, float]  # m
    orientation: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 1.0)  # x, y, z, w; norm 1
    valid_for_s: float = 0.0  # 0: the scene's limit alone


@dataclasses.dataclass(frozen=True, slots=True)
class Event:
    """Something that happened once."""

    kind: str  # "STATE", "LOST", "FAULT", ...
    reason: str  # stable: "ENGAGED -> ARMED", ...
    message: str  # for people
    state: str
    lease_epoch: int

    @classmethod
    def of(cls, m: wire.Event) -> Event:
        return cls(name_of(wire.Event.Kind, m.kind), m.reason, m.message,
                   name_of(wire.DeviceStateName, m.state), m.lease_epoch)


@dataclasses.dataclass(frozen=True, slots=True)
class SampleCounts:
    """What became of the samples of a session; `replaced`: by newer ones before they were sent;
    `planes_left_out`: of a sample, beyond the 32 deepest and the 8 deepest contacts of a block."""

    published: int
    replaced: int
    accepted: int
    rejected_old: int
    rejected_invalid: int
    conflated_backlog: int
    last_rejection: str
    planes_left_out: int = 0


@dataclasses.dataclass(frozen=True, slots=True)
class DegreeOfFreedom:
    name: str
    unit: str
    actuated: bool
    lower: float
    upper: float
    max_effort: float


@dataclasses.dataclass(frozen=True, slots=True)
class Coordinate:
    name: str
    unit: str
    kind: str


@dataclasses.dataclass(frozen=True, slots=True)
class Device:
    name: str
    kind: str
    model: str
    dofs: tuple[DegreeOfFreedom, ...]
    coordinates: tuple[Coordinate, ...]
    stiffness_limit: tuple[float, ...]
    damping_limit: tuple[float, ...]
    force_limit: tuple[float, ...]
    slew_limit: tuple[float, ...]
    loop_rate_hz: float
    state: str
    faults: int
    controller: str  # empty: nobody
    serial: str  # of a board; empty: it has none
    calibrated: str  # day on which the calibration in use was made; empty: none is
    wants_tracker: bool  # a session in the role tracker says where its palm is
    tracker: str  # name of the client that does; empty: nobody
    unguarded: tuple[str, ...]  # of direction_guard and energy_tank, what the scene leaves out

    @classmethod
    def of(cls, m: service.Device) -> Device:
        dofs = (DegreeOfFreedom(d.name, d.unit, d.actuated, d.lower, d.upper, d.max_effort)
                for d in m.dofs)
        coordinates = (Coordinate(c.name, c.unit, c.kind) for c in m.coordinates)
        return cls(m.name, m.kind, m.model, tuple(dofs), tuple(coordinates),
                   tuple(m.stiffness_limit), tuple(m.damping_limit), tuple(m.force_limit),
                   tuple(m.slew_limit), m.loop_rate_hz, name_of(wire.DeviceStateName, m.state),
                   m.faults, m.controller, m.serial, m.calibrated, m.wants_tracker, m.tracker,
                   tuple(m.unguarded))


@dataclasses.dataclass(frozen=True, slots=True)
class ServerInfo:
    version: str
    scene: str
    realtime_grade: str
    realtime_explanation: str
    insecure: tuple[str, ...]
    ticks: int
    skipped_ticks: int
    lateness_p50_s: float
    lateness_p99_s: float
    paced_by: str  # the device whose samples begin ticks; empty: the timer
    paced_by_sample: int

    @classmethod
    def of(cls, m: service.GetServerInfoResponse) -> ServerInfo:
        return cls(m.version, m.scene, m.realtime.grade, m.realtime.explanation, tuple(m.insecure),
                   m.loop.ticks, m.loop.skipped, m.loop.lateness_p50_us * 1e-6,
                   m.loop.lateness_p99_us * 1e-6, m.loop.paced_by, m.loop.paced_by_sample)


@dataclasses.dataclass(frozen=True, slots=True)
class Settings:
    """As applied; `clamped` names what was held at a limit of the scene, and why."""

    stiffness: tuple[float, ...]
    damping: tuple[float, ...]
    force_limit: tuple[float, ...]
    slew_limit: tuple[float, ...]
    clamped: tuple[str, ...]

    @classmethod
    def of(cls, m: service.UpdateSettingsResponse) -> Settings:
        clamped = (f"{c.field} = {c.asked:g}: {c.applied:g} applied, {c.why}" for c in m.clamped)
        return cls(tuple(m.stiffness), tuple(m.damping), tuple(m.force_limit),
                   tuple(m.slew_limit), tuple(clamped))
