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
SAMPLES = 6  # points along each phalanx that can touch
STEPS, DAMPING = 12, 0.2


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
        pull = contact_torque(q)
        q = tuple(a + DAMPING * (p + t / JOINT_NM_PER_RAD - a)
                  for a, p, t in zip(q, probe, pull))
    return q


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--server", default=haptic.DEFAULT_SERVER, help="host:port or unix:/path")
    parser.add_argument("--seconds", type=float, default=20.0)
    arguments = parser.parse_args()
    with haptic.Connection(arguments.server) as server:
        with server.session(client_name="soft_grasp.py", nominal_rate_hz=RATE_HZ) as session:
            session.engage_when_ready()
            x = session.wait_for_state().x_probe
            peak = 0.0
            for frame in range(int(arguments.seconds * RATE_HZ)):
                state = session.wait_for_state()
                touching = any(contact_torque(state.x_probe))
                x = balanced(state.x_probe, x) if touching else state.x_probe
                session.publish(haptic.held(x) if touching else haptic.FREE)
                peak = max(peak, abs(state.tau_elastic[0]))
                if frame % RATE_HZ == 0:
                    print(f"{state.state:9} {'touching' if touching else 'free':8} "
                          f"{state.tau_a[0]:6.2f} N", flush=True)
            print(f"largest elastic force {peak:.2f} N, "
                  f"{session.samples().accepted} samples accepted")


if __name__ == "__main__":
    main()
