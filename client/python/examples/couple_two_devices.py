#!/usr/bin/env python3
"""Two devices of one kind that feel each other: the proxy of each is where the other one is.

The device that is led is moved by its proxy on and on, which takes energy. The energy tank of its
scene gives out no more than its user put in, so the led hand feels little of what the leading hand
feels, unless the scene of the led device says how much power its user may be given:

    hapticd --scene finger_soft_grasp
    hapticd --scene finger_constant --listen unix:/run/led.sock \\
        --set 'device[0].passivity.tank={allowed_power_w: 1}'
    couple_two_devices.py --other unix:/run/led.sock

With allowed_power_w: 0, the default, the second hand feels nothing, and its limiter ENERGY_TANK is
there all the time.
"""

import argparse

import haptic

RATE_HZ = 200
ENERGY_TANK = 1 << 5  # of DeviceState.limiters (proto/README.md)
APPROACH_S = 1.0  # from each device's own place to the other's, once both have force

parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
parser.add_argument("--server", default=haptic.DEFAULT_SERVER, help="of the first device")
parser.add_argument("--device", default="", help="its name, if the server has several")
parser.add_argument("--other", help="server of the second device; default: the same")
parser.add_argument("--other-device", default="")
parser.add_argument("--seconds", type=float, default=10.0)
arguments = parser.parse_args()


def between(share: float, own: haptic.DeviceState, other: haptic.DeviceState) -> haptic.Proxy:
    if share <= 0:
        return haptic.FREE
    return haptic.held([x + share * (y - x) for x, y in zip(own.x_probe, other.x_probe)])


with haptic.Connection(arguments.server) as server, \
        haptic.Connection(arguments.other or arguments.server) as other, \
        server.session(device=arguments.device, client_name="couple_two_devices, first",
                       nominal_rate_hz=RATE_HZ, re_engage=True) as a, \
        other.session(device=arguments.other_device, client_name="couple_two_devices, second",
                      nominal_rate_hz=RATE_HZ, re_engage=True) as b:
    sides = (a, b)
    for side in sides:
        side.engage_when_ready()
    share, force, held_back = 0.0, [0.0, 0.0], [0, 0]
    for step in range(1, int(arguments.seconds * RATE_HZ) + 1):
        states = [side.wait_for_state() for side in sides]
        if all(state.gain > 0 for state in states):
            share = min(1.0, share + 1 / (APPROACH_S * RATE_HZ))
        a.publish(between(share, *states))
        b.publish(between(share, *reversed(states)))
        for i, state in enumerate(states):
            force[i] += abs(state.tau_a[0])
            held_back[i] += state.limiters & ENERGY_TANK != 0
        if step % RATE_HZ == 0:
            for i, side in enumerate(sides):
                waits = side.engage_refusal
                print(f"{'first' if i == 0 else 'second'}: mean force {force[i] / RATE_HZ:5.2f}, "
                      f"held back by the energy tank in {100 * held_back[i] // RATE_HZ} % of it"
                      + (f", waits: {waits}" if waits else ""), flush=True)
            force, held_back = [0.0, 0.0], [0, 0]
