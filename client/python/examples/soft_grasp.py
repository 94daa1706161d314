#!/usr/bin/env python3
"""A soft finger on a soft cylinder, for finger_soft_grasp.textproto.

Two phalanges in the plane of the finger press onto a fixed cylinder. The proxy is the joint angles
at which the springs of the finger and of the contact are in balance. The simulation takes a few
damped steps per frame towards that balance.
"""

import argparse
import math

import haptic

RATE_HZ = 60
PROXIMAL_M, DISTAL_M = 0.045, 0.035  # phalanges
CENTRE, RADIUS_M = (0.050, -0.030), 0.020  # cylinder, below the finger
CONTACT_N_PER_M = 600.0
JOINT_NM_PER_RAD = 0.5  # how firmly the proxy follows the hand
PULL_RAD = 0.2  # and from how far at most: more could pull it through the cylinder
SAMPLES = 6  # points along each phalanx that can touch
STEPS, DAMPING = 12, 0.2
PIECE_RAD = 0.05  # of the probe's way per balance


def contact_torque(q: tuple[float, float]) -> tuple[float, float]:
    """Joint torques of the cylinder on the finger, N m; flexion is positive (towards -y)."""
    torque = [0.0, 0.0]
    for phalanx in (0, 1):
        for i in range(1, SAMPLES + 1):
            joints = [(0.0, 0.0)]
            along = (PROXIMAL_M if phalanx == 0 else DISTAL_M) * i / SAMPLES
            if phalanx == 0:
                point = (along * math.cos(q[0]), -along * math.sin(q[0]))
            else:
                pip = (PROXIMAL_M * math.cos(q[0]), -PROXIMAL_M * math.sin(q[0]))
                both = q[0] + q[1]
                point = (pip[0] + along * math.cos(both), pip[1] - along * math.sin(both))
                joints.append(pip)
            dx, dy = point[0] - CENTRE[0], point[1] - CENTRE[1]
            distance = math.hypot(dx, dy)
            depth = RADIUS_M - distance
            if depth <= 0 or distance == 0:
                continue
            force = CONTACT_N_PER_M * depth / SAMPLES
            fx, fy = force * dx / distance, force * dy / distance
            for j, (jx, jy) in enumerate(joints):
                # A flexion turns clockwise: minus the moment about z.
                torque[j] -= (point[0] - jx) * fy - (point[1] - jy) * fx
    return torque[0], torque[1]


def balanced(probe: tuple[float, ...], start: tuple[float, float]) -> tuple[float, float]:
    """Towards the angles where contact and the hand's pull cancel."""
    q = start
    for _ in range(STEPS):
        push = contact_torque(q)
        q = tuple(a + DAMPING * (max(-PULL_RAD, min(p - a, PULL_RAD)) + t / JOINT_NM_PER_RAD)
                  for a, p, t in zip(q, probe, push))
    return q


class Grasp:
    """The proxy of a finger that was open at first, and goes to every probe in small pieces. So it
    stays on the side from which it came, wherever the simulation joins and however far the hand
    pushes: from the probe alone a finger inside the cylinder could be held on the wrong side."""

    def __init__(self) -> None:
        self.probe = self.x = (0.0, 0.0)

    def step(self, probe: tuple[float, ...]) -> haptic.Proxy:
        begin = self.probe
        pieces = max(1, math.ceil(max(abs(p - b) for p, b in zip(probe, begin)) / PIECE_RAD))
        for i in range(1, pieces + 1):
            self.probe = tuple(b + i / pieces * (p - b) for p, b in zip(probe, begin))
            self.x = balanced(self.probe, self.x)
            touching = any(contact_torque(self.x)) or any(contact_torque(self.probe))
            if not touching:
                self.x = self.probe
        away = tuple(p - x for p, x in zip(self.probe, self.x))
        if not touching or math.hypot(*away) < 1e-6:
            return haptic.FREE
        # The surface as a plane: it says which way is out, so force may begin in contact.
        return haptic.behind([(away, sum(a * x for a, x in zip(away, self.x)))], self.x)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--server", default=haptic.DEFAULT_SERVER, help="host:port or unix:/path")
    parser.add_argument("--seconds", type=float, default=20.0)
    arguments = parser.parse_args()
    with haptic.Connection(arguments.server) as server:
        with server.session(client_name="soft_grasp.py", nominal_rate_hz=RATE_HZ) as session:
            session.engage_when_ready()
            grasp, peak = Grasp(), 0.0
            for frame in range(int(arguments.seconds * RATE_HZ)):
                state = session.wait_for_state()
                proxy = grasp.step(state.x_probe)
                session.publish(proxy)
                peak = max(peak, abs(state.tau_elastic[0]))
                if frame % RATE_HZ == 0:
                    print(f"{state.state:9} {'free' if proxy == haptic.FREE else 'touching':8} "
                          f"{state.tau_a[0]:6.2f} N", flush=True)
            print(f"largest elastic force {peak:.2f} N, "
                  f"{session.samples().accepted} samples accepted")


if __name__ == "__main__":
    main()
