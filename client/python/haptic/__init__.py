"""Client of hapticd for Python 3.11 over Debian's python3-grpcio.

    with haptic.Connection() as server:
        with server.session(client_name="my simulation", nominal_rate_hz=60) as session:
            session.engage_when_ready()
            while running:
                state = session.wait_for_state()
                x = simulate(state.x_probe)  # where the object lets the finger be
                session.publish(haptic.held(x) if touching else haptic.FREE)

SI units; arrays in the order of Connection.devices(). proto/README.md is the protocol.
"""

from ._connection import Connection
from ._contact import (
    FASTEST_POINT,
    JointAxis,
    PointMap,
    contact_at,
    contact_horizon,
    cylinder_curvature,
    point_itself,
    point_on_finger,
    point_on_joints,
    point_on_pose,
    sphere_curvature,
)
from ._errors import ClientError
from ._ports import DEFAULT_SERVER
from ._session import Session
from ._state import (
    DeviceState,
    PassivityState,
    TrackerState,
)
from ._types import (
    FREE,
    Carriers,
    Coordinate,
    Device,
    DegreeOfFreedom,
    Event,
    Plane,
    Pose,
    Proxy,
    SampleCounts,
    ServerInfo,
    Settings,
    held,
    behind,
    contact,
)
from ._version import __version__

__all__ = [
    "DEFAULT_SERVER", "FASTEST_POINT", "FREE", "Carriers", "ClientError",
    "Connection", "Coordinate", "DegreeOfFreedom", "Device", "DeviceState",
    "Event", "JointAxis", "PassivityState", "Plane", "PointMap", "Pose", "Proxy", "SampleCounts",
    "ServerInfo", "Session", "Settings", "TrackerState", "__version__", "behind", "contact",
    "contact_at", "contact_horizon", "cylinder_curvature", "held", "point_itself",
    "point_on_finger", "point_on_joints", "point_on_pose", "sphere_curvature",
]
