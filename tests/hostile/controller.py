"""A simulation that presses: 100 samples per second with the shipped Python client. Asks for force,
asks again after a loss, and opens another session if it lost one. Each session is free until it has
force for the first time, because force does not begin with a held proxy. Ends when it is killed.

    controller.py ADDRESS DEVICE MCP PIP [relative]

MCP and PIP: rad, where the joints are held; relative to the first state. Prints a line whenever the
device's state changes.
"""

import contextlib
import os
import sys
import time

import haptic

PERIOD = 0.010  # s


def press(connection, device, x, relative):
    with connection.session(device=device, client_name="simulation", nominal_rate_hz=1 / PERIOD,
                            carriers=haptic.Carriers.STREAM) as session:
        if relative:
            x = tuple(a + b for a, b in zip(session.wait_for_state().x_probe, x))
        said, due, met = "", time.monotonic(), False
        while True:
            session.publish(haptic.held(x) if met else haptic.FREE)
            state = session.state
            met = met or state is not None and state.gain > 0
            if state is not None and state.state != said:
                said = state.state
                print(said, flush=True)
                if said == "ARMED":  # at first, and after a loss or a cleared fault
                    session.engage_when_ready()
            for event in session.events():
                if event.kind == "LOST":
                    said = ""  # ARMED again, whether or not the states between were seen
                if event.reason in ("LEASE_PREEMPTED", "LEASE_EXPIRED"):
                    raise haptic.ClientError(event.reason, "another session is needed")
            due = max(due + PERIOD, time.monotonic() - PERIOD)
            time.sleep(max(0.0, due - time.monotonic()))


def main():
    with contextlib.suppress(OSError):  # so that a loss of force is the daemon's, not the host's
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(1))
    x = tuple(map(float, sys.argv[3:5]))
    while True:
        try:
            with haptic.Connection(sys.argv[1]) as connection:
                press(connection, sys.argv[2], x, len(sys.argv) > 5)
        except haptic.ClientError as error:
            print("ENDED", error.reason, flush=True)
            time.sleep(0.1)


if __name__ == "__main__":
    main()
