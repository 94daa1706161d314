#!/usr/bin/env python3
"""How old samples from Python are when the loop uses them.

Publishes at a steady rate, and reads the age of the sample in use from the states.

No force is asked for. The server needs `server.udp_listen` for samples to go by UDP.
"""

import argparse
import statistics
import threading
import time

import haptic

STATE_RATE_HZ = 100

parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
parser.add_argument("--server", default=haptic.DEFAULT_SERVER, help="host:port or unix:/path")
parser.add_argument("--seconds", type=float, default=60.0)
parser.add_argument("--rate", type=float, default=1000.0, help="samples per second")
arguments = parser.parse_args()


def publish(session: haptic.Session) -> None:
    """On absolute deadlines; a deadline that passed is skipped."""
    begin = time.monotonic()
    deadline = 0
    while (now := time.monotonic() - begin) < arguments.seconds:
        deadline = max(deadline + 1, int(now * arguments.rate))
        time.sleep(max(begin + deadline / arguments.rate - time.monotonic(), 0.0))
        session.publish(haptic.FREE)


with haptic.Connection(arguments.server) as server:
    with server.session(client_name="ages.py", nominal_rate_hz=arguments.rate,
                        state_rate_hz=STATE_RATE_HZ) as session:
        time.sleep(1.0)  # the UDP path, if there is one, is in use by then
        publisher = threading.Thread(target=publish, args=(session,))
        begin = time.monotonic()
        publisher.start()
        ages, by_udp = [], 0
        while publisher.is_alive():
            state = session.wait_for_state()
            if state.proxy_seq_used > 0:
                ages.append(state.proxy_age_s * 1e3)
                by_udp += state.carrier == "UDP"
        took = time.monotonic() - begin
        time.sleep(0.5)  # the last acknowledgement
        counts = session.statistics()

p50, p99 = (statistics.quantiles(ages, n=100, method="inclusive")[i - 1] for i in (50, 99))
print(f"published {counts.published} in {took:.1f} s ({counts.published / took:.0f} Hz), "
      f"accepted {counts.accepted}, by UDP {by_udp / len(ages):.1%}")
print(f"age at use: p50 {p50:.2f} ms, p99 {p99:.2f} ms, {len(ages)} states")
