#!/usr/bin/env python3
"""A virtual wall for the first joint: it may flex up to 0.3 rad.

A wall that the finger is deep inside would push it at once, more than Engage allows. So the wall
starts where the finger is when force begins, and moves in slowly. A connection that is lost is
taken up again, and force asked for again; with --ca the server is spoken to by TLS.
"""

import argparse
import math

import haptic

WALL_RAD = 0.3
APPROACH_RAD_PER_S = 0.2
RATE_HZ = 60

parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
parser.add_argument("--server", default=haptic.DEFAULT_SERVER, help="host:port or unix:/path")
parser.add_argument("--ca", help="PEM file of the authority that issued the server's certificate")
parser.add_argument("--cert", default="", help="this client's certificate, if the server asks")
parser.add_argument("--key", default="", help="its private key")
parser.add_argument("--seconds", type=float, default=5.0)
arguments = parser.parse_args()
tls = haptic.Tls(arguments.ca, arguments.cert, arguments.key) if arguments.ca else None

with haptic.Connection(arguments.server, tls=tls) as server:
    with server.session(client_name="wall.py", nominal_rate_hz=RATE_HZ, reconnect=True,
                        re_engage=True) as session:
        session.engage_when_ready()
        wall = math.inf
        for frame in range(int(arguments.seconds * RATE_HZ)):
            try:
                state = session.wait_for_state(0.5)
            except haptic.ClientError as error:
                if error.reason != "TIMEOUT":  # none comes while the session reconnects
                    raise
                continue
            if state.gain > 0:
                wall = max(WALL_RAD, wall - APPROACH_RAD_PER_S / RATE_HZ)
            else:
                wall = max(WALL_RAD, state.x_probe[0])
            x = (min(state.x_probe[0], wall), *state.x_probe[1:])
            session.publish(haptic.held(x) if x != state.x_probe else haptic.FREE)
            for event in session.events():
                if event.kind in ("DISCONNECTED", "LEASE", "LOST", "FAULT"):
                    print(f"{event.reason}: {event.message}")
            if frame % 30 == 0:
                print(f"{state.state}, {state.x_probe[0]:6.3f} rad, {state.tau_a[0]:6.2f} N")
