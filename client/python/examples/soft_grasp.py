#!/usr/bin/env python3
"""A soft finger on a soft cylinder, for finger_soft_grasp.textproto.

Two phalanges in the plane of the finger press onto a fixed cylinder. Points along them are springs
while they are inside it; the proxy is the joint angles at which these and the pull of the hand are
in balance. The server gets the points as contacts, goes on with them between two frames, and knows
them before they touch: what is felt does not depend on the delay.
"""

import argparse
import math

import haptic

RATE_HZ = 60
PROXIMAL_M, DISTAL_M = 0.045, 0.035  # phalanges
CENTRE, RADIUS_M = (0.050, -0.030), 0.020  # cylinder, below the finger
POINT_N_PER_M = 400.0
JOINT_NM_PER_RAD = 0.05  # how firmly the proxy follows the hand
POINTS = 6  # along each phalanx
PIECE_RAD = 0.05  # of the probe's way per balance


def contacts(q: tuple[float, ...], horizon: float) -> list[haptic.Contact]:
    """The points with a gap up to `horizon` (m), at the joint angles q."""
    found = []
    for phalanx, length in enumerate((PROXIMAL_M, DISTAL_M)):
        for i in range(1, POINTS + 1):
            point = haptic.point_on_finger((PROXIMAL_M,), q, phalanx, length * i / POINTS)
            x, y, _ = point.position
            away = (x - CENTRE[0], y - CENTRE[1])
            distance = math.hypot(*away)
            if distance == 0.0 or distance - RADIUS_M > horizon:
                continue
            normal = (away[0] / distance, away[1] / distance, 0.0)
            found.append(haptic.Contact(
                point, normal, distance - RADIUS_M, stiffness=POINT_N_PER_M, uncertainty=0.0,
                curvature=haptic.cylinder_curvature(normal, (0.0, 0.0, 1.0), distance),
                id=1 + phalanx * POINTS + i))
    return found


def touching(q: tuple[float, ...]) -> bool:
    return any(contact.gap < 0.0 for contact in contacts(q, 0.0))


class Grasp:
    """The proxy of a finger that was open at first, and goes to every probe in small pieces. So it
    stays on the side from which it came, wherever the simulation joins and however far the hand
    pushes: from the probe alone a finger inside the cylinder could be held on the wrong side."""

    def __init__(self) -> None:
        self.probe: tuple[float, ...] = (0.0, 0.0)
        self.x = self.probe

    def step(self, probe: tuple[float, ...], horizon: float) -> haptic.Proxy:
        begin = self.probe
        pieces = max(1, math.ceil(max(abs(p - b) for p, b in zip(probe, begin)) / PIECE_RAD))
        for i in range(1, pieces + 1):
            self.probe = tuple(b + i / pieces * (p - b) for p, b in zip(probe, begin))
            found = haptic.solve(lambda q: contacts(q, horizon), self.probe, JOINT_NM_PER_RAD,
                                 start=self.x)
            self.x = found.x
        return found.proxy()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--server", default=haptic.DEFAULT_SERVER, help="host:port or unix:/path")
    parser.add_argument("--seconds", type=float, default=20.0)
    arguments = parser.parse_args()
    with haptic.Connection(arguments.server) as server:
        with server.session(client_name="soft_grasp.py", nominal_rate_hz=RATE_HZ, reconnect=True,
                            re_engage=True) as session:  # a pause costs no more than the force
            session.engage_when_ready()
            grasp, peak = Grasp(), 0.0
            for frame in range(int(arguments.seconds * RATE_HZ)):
                state = session.wait_for_state()
                horizon = haptic.contact_horizon(session.round_trip_s, 1 / RATE_HZ)
                session.publish(grasp.step(state.x_probe, horizon))
                peak = max(peak, abs(state.tau_elastic[0]))
                if frame % RATE_HZ == 0:
                    print(f"{state.state:9} {'touching' if touching(grasp.x) else 'free':8} "
                          f"{state.tau_a[0]:6.2f} N", flush=True)
            print(f"largest elastic force {peak:.2f} N, "
                  f"{session.statistics().accepted} samples accepted")


if __name__ == "__main__":
    main()
