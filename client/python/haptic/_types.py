"""What goes in and out: plain frozen values."""

from __future__ import annotations

import dataclasses
import enum
from collections.abc import Iterable
from typing import Any, TypeVar

from ._library import ffi, floats, lists, name_of, text
from ._messages import DEVICE_STATE_NAME, KIND, RENDERER, Plane

T = TypeVar("T")
_DISCONNECTED = {1000: "DISCONNECTED"}  # HAPTIC_EVENT_DISCONNECTED


class Carriers(enum.IntEnum):
    """What may carry samples and states."""

    BEST = 0  # UDP while it proves good, the stream otherwise
    STREAM = 1  # the gRPC stream alone
    UDP = 2  # drops samples while UDP does not work; for measurements


class Priority(enum.IntEnum):
    """A controller takes the device from one with a lower priority."""

    TEST = 1
    PRIMARY = 2
    OPERATOR = 3


@dataclasses.dataclass(frozen=True, slots=True)
class Tls:
    """How to connect with TLS; the files are in PEM format."""

    ca_file: str = ""  # the authority that issued the server's certificate; empty: the system's
    certificate_file: str = ""  # of this client, if the server asks for one
    key_file: str = ""
    server_name: str = ""  # that the server's certificate must have; empty: the host in the address


@dataclasses.dataclass(frozen=True, slots=True)
class Proxy:
    """Where the virtual object lets the tool be. Made by held(), behind(), or FREE."""

    mode: str  # "HELD", "FREE" or "PLANES"
    position: tuple[float, ...] = ()
    planes: tuple[Plane, ...] = ()
    valid_for_s: float = 0.0  # it may count as fresh for so long; 0: as the scene says


FREE = Proxy("FREE")
"""Nothing in the way: no elastic force, no drag."""


def held(position: Iterable[float]) -> Proxy:
    """The proxy stays here until the next sample; m or rad per virtual coordinate. A coordinate in
    which this is the x_probe of the state that was used follows the probe instead, as if free,
    unless the sample before held it at the same value. Force begins with a held proxy only after a
    FREE one: it does not say on which side of an object the probe is."""
    return Proxy("HELD", floats(position))


def behind(planes: Iterable[Plane | tuple[Iterable[float], float]],
           position: Iterable[float]) -> Proxy:
    """The server keeps the probe out of `planes`, contact()s or (normal, offset) each: normal . x
    <= offset, linearised at `position`. They say which way is out, so force may begin inside. Of
    more than 32, and of more than 8 contacts of a block, the deepest are sent."""
    return Proxy("PLANES", floats(position), tuple(
        plane if isinstance(plane, Plane) else Plane(floats(plane[0]), float(plane[1]))
        for plane in planes))


@dataclasses.dataclass(frozen=True, slots=True)
class Pose:
    """Where the tracked body is that carries a device, in the world: what a tracker publishes."""

    position: tuple[float, ...]  # m
    orientation: tuple[float, ...] = (0.0, 0.0, 0.0, 1.0)  # x, y, z, w; norm 1
    valid_for_s: float = 0.0  # 0: the scene's limit alone


@dataclasses.dataclass(frozen=True, slots=True)
class Event:
    """Something that happened once."""

    kind: str  # "STATE", "LOST", "FAULT", ...; "DISCONNECTED": the stream was lost
    reason: str  # stable: "ENGAGED -> ARMED", ...
    message: str  # for people
    state: str  # of DISCONNECTED: "RECONNECTING", or "ENDED"
    server_time_ns: int = 0

    @classmethod
    def of(cls, c: Any) -> Event:
        state = name_of(DEVICE_STATE_NAME, c.state)
        if c.kind in _DISCONNECTED:
            state = "RECONNECTING" if c.state == 1 else "ENDED"
        return cls(name_of(KIND | _DISCONNECTED, c.kind), text(c.reason), text(c.message), state,
                   c.server_time_ns)


@dataclasses.dataclass(frozen=True, slots=True)
class Statistics:
    """What became of the samples of a session, since it was first opened."""

    published: int
    sent: int  # handed to a carrier; one that went by both counts twice
    conflated: int  # replaced by a newer one before they could be sent
    planes_left_out: int  # of a sample, beyond the 32 deepest and 8 contacts of a block
    # Counts of the server.
    accepted: int
    rejected_old: int  # came after a newer one, or without the lease
    rejected_invalid: int  # for last_rejection, the newest reason
    backlog: int  # accepted, but too fast to count as fresh
    last_rejection: str
    udp_in_use: bool  # samples go by the UDP path
    udp_received: int  # datagrams of the server
    udp_lost: int


@dataclasses.dataclass(frozen=True, slots=True)
class Settings:
    """As applied; `clamped` names what was held at a limit of the scene, and why."""

    stiffness: tuple[float, ...]
    damping: tuple[float, ...]
    force_limit: tuple[float, ...]
    slew_limit: tuple[float, ...]
    renderer: str
    direction_guard: bool
    clamped: tuple[str, ...]

    @classmethod
    def of(cls, c: Any) -> Settings:
        return read(cls, c, renderer=name_of(RENDERER, c.renderer),
                    direction_guard=c.direction_guard == 1,
                    clamped=tuple(text(c.why_clamped).splitlines()))


def read(cls: type[T], c: Any, **given: Any) -> T:
    """A value whose fields have the names of the struct's; those that differ are `given`."""
    fields = {field.name: field.type for field in dataclasses.fields(cls)}
    return cls(**given, **{name: _value(getattr(c, name), str(kind))
                           for name, kind in fields.items() if name not in given})


def _value(value: Any, kind: str) -> Any:
    if not isinstance(value, ffi.CData):
        return value != 0 if kind == "bool" else value
    return text(value) if kind == "str" else lists(value.value, value.count)
