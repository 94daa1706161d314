#!/usr/bin/env python3
"""A virtual wall for the first joint: it may flex up to 0.3 rad.

A wall that the finger is deep inside would push it at once, more than Engage allows. So the wall
starts where the finger is when force begins, and moves in slowly.
"""

import argparse
import math

import haptic

WALL_RAD = 0.3
APPROACH_RAD_PER_S = 0.2
RATE_HZ = 60

parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
parser.add_argument("--server", default=haptic.DEFAULT_SERVER, help="host:port or unix:/path")
parser.add_argument("--seconds", type=float, default=5.0)
arguments = parser.parse_args()

with haptic.Connection(arguments.server) as server:
    with server.session(client_name="wall.py", nominal_rate_hz=RATE_HZ) as session:
        session.engage_when_ready()
        wall = math.inf
        for frame in range(int(arguments.seconds * RATE_HZ)):
            state = session.wait_for_state()
            kinds = [event.kind for event in session.events()]
            if "LOST" in kinds and "FAULT" not in kinds:
                session.engage_when_ready()  # a pause: force never comes back by itself
            if state.gain > 0:
                wall = max(WALL_RAD, wall - APPROACH_RAD_PER_S / RATE_HZ)
            else:
                wall = max(WALL_RAD, state.x_probe[0])
            x = (min(state.x_probe[0], wall), *state.x_probe[1:])
            session.publish(haptic.held(x) if x != state.x_probe else haptic.FREE)
            if frame % 30 == 0:
                print(f"{state.state}, {state.x_probe[0]:6.3f} rad, {state.tau_a[0]:6.2f} N")
