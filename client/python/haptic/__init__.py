"""Client of hapticd for Python 3.11, over the C library libhaptic0.

    with haptic.Connection() as server:
        with server.session(client_name="my simulation", nominal_rate_hz=60) as session:
            session.engage_when_ready()
            while running:
                state = session.wait_for_state()
                x = simulate(state.x_probe)  # where the object lets the finger be
                session.publish(haptic.held(x) if touching else haptic.FREE)

SI units; arrays in the order of Connection.devices(), and any sequence of numbers is taken, arrays
of numpy too. A call that fails raises ClientError, whose `reason` is for programs; functions of
geometry raise ValueError. Ctrl-C ends every wait. proto/README.md is the protocol.

Values, each with help() of its own: DeviceState, PassivityState and TrackerState come down; Proxy,
Plane and Pose go up; Device, DegreeOfFreedom, Coordinate, ServerInfo, RealtimeGrant,
LoopStatistics, Settings, Event and Statistics are answers; Tls, Priority and Carriers are options;
Contact, PointMap, JointAxis and Solution are geometry.
"""

from ._connection import Connection
from ._contact import (
    FASTEST_POINT,
    contact,
    contact_at,
    contact_horizon,
    cylinder_curvature,
    derive_planes,
    point_itself,
    point_on_finger,
    point_on_joints,
    point_on_pose,
    solve,
    sphere_curvature,
)
from ._contact import Contact as Contact
from ._contact import JointAxis as JointAxis
from ._contact import PointMap as PointMap
from ._contact import Solution as Solution
from ._facts import Coordinate as Coordinate
from ._facts import DegreeOfFreedom as DegreeOfFreedom
from ._facts import Device as Device
from ._facts import LoopStatistics as LoopStatistics
from ._facts import RealtimeGrant as RealtimeGrant
from ._facts import ServerInfo as ServerInfo
from ._library import ClientError as ClientError
from ._messages import DeviceState as DeviceState
from ._messages import PassivityState as PassivityState
from ._messages import Plane as Plane
from ._messages import Told as Told
from ._messages import TrackerState as TrackerState
from ._ports import DEFAULT_SERVER
from ._session import Session
from ._types import FREE, behind, held
from ._types import Carriers as Carriers
from ._types import Event as Event
from ._types import Pose as Pose
from ._types import Priority as Priority
from ._types import Proxy as Proxy
from ._types import Settings as Settings
from ._types import Statistics as Statistics
from ._types import Tls as Tls
from ._version import __version__

__all__ = [
    "DEFAULT_SERVER", "FASTEST_POINT", "FREE", "Connection", "Session", "__version__", "behind",
    "contact", "contact_at", "contact_horizon", "cylinder_curvature", "derive_planes", "held",
    "point_itself", "point_on_finger", "point_on_joints", "point_on_pose", "solve",
    "sphere_curvature",
]
