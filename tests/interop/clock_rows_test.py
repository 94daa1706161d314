"""The clock rows of tests/relay/README.md#rows over real sockets: the client of udp_client.py
behind the relay, with a steady clock that steps and drifts as the scenario file says. Neither makes
a sample older or younger.

Rows "network/clock_*" of the matrix are added to $HAPTIC_MATRIX_CSV if that is set
(tests/relay/matrix.sh)."""

import csv
import os
import re
import statistics
import subprocess
import sys
import time

import grpc

from server_process import Server, argument, eventually

sys.path.insert(0, argument("HAPTIC_PYTHON_PROTO"))
from haptic.v1 import session_pb2  # noqa: E402

from udp_client import Client  # noqa: E402

SCENARIOS = os.path.join(os.path.dirname(__file__), "../relay/scenarios")
EXPECTED = ("engaged throughout; stays on UDP; seq never back; median age of the last second "
            "within 2 ms of that of the first")


class Scenario:
    def __init__(self, name):
        self.path = os.path.join(SCENARIOS, name + ".textproto")
        with open(self.path, encoding="utf-8") as file:
            text = file.read()
        self.seconds = float(re.search(r"duration_s: (\S+)", text)[1])
        self.drift = sum(float(ppm) * 1e-6 for ppm in re.findall(r"drift_ppm: (\S+)", text))
        self.steps = [(float(at), float(by))
                      for at, by in re.findall(r"step \{ at_s: (\S+) by_s: (\S+) \}", text)]
        assert self.drift or self.steps, f"{name}: no drift_ppm and no step that this test reads"

    def turned_ns(self, t):
        return 1e9 * (self.drift * t + sum(by for at, by in self.steps if t >= at))


def behind_relay(server, scenario):
    relay = subprocess.Popen(
        [argument("HAPTIC_RELAY"), "--scenario", scenario.path, "--tcp", str(server.port),
         "--udp", str(server.udp_port)], stdout=subprocess.PIPE)
    relay.stdout.readline()  # it listens
    return relay


def press(client, scenario, sign):
    """States of the whole scenario, from the moment force was felt."""
    eventually(lambda: client.opened and client.state, "the session opens, and a state comes")
    client.start_udp()
    udp = session_pb2.TRANSPORT_UDP
    client.publish_until(lambda: client.state.transport == udp, "samples go up by UDP")
    client.publish_until(client.engage, "force is granted")
    pressed = [x - 0.2 for x in client.state.x_probe]
    client.publish_until(lambda: client.state.gain == 1.0, "force is fully on", pressed)
    begin, states = time.monotonic(), []
    client.turned = lambda now: sign * scenario.turned_ns(now - begin)

    def over():
        states.append(client.state)
        return time.monotonic() - begin > scenario.seconds
    client.publish_until(over, "time passes", pressed, seconds=scenario.seconds + 20)
    return states


def judge(states):
    for before, now in zip(states, states[1:]):
        assert now.state == session_pb2.DEVICE_STATE_NAME_ENGAGED, now
        assert now.gain == 1.0 and now.transport == session_pb2.TRANSPORT_UDP, now
        assert now.proxy_seq_used >= before.proxy_seq_used, (before, now)
    ages = [s.proxy_age_us * 1e-3 for s in states]
    first, last = statistics.median(ages[:100]), statistics.median(ages[-100:])
    assert abs(last - first) < 2.0, f"median age {first:.1f} ms at first, {last:.1f} ms in the end"
    return (f"median age {first:.1f} ms at first, {last:.1f} ms in the end, "
            f"oldest {max(ages):.1f} ms")


def row(name, sign):
    scenario = Scenario(name)
    with Server(argument("HAPTICD")) as server:
        relay = behind_relay(server, scenario)
        try:
            with grpc.insecure_channel(f"127.0.0.2:{server.port}") as channel:
                client = Client(channel, "127.0.0.2")
                try:
                    return judge(press(client, scenario, sign))
                finally:
                    client.close()
        finally:
            relay.terminate()
            relay.wait()


def main():
    failed = False
    # A clock that runs slow would make samples old, one that runs fast young: both.
    for name, sign in (("clock_step_forward", 1), ("clock_step_back", 1), ("clock_drift", 1),
                       ("clock_drift", -1)):
        shown = name + ("_reversed" if sign < 0 else "")
        try:
            got, verdict = row(name, sign), "ok"
        except Exception as error:  # whatever it was, the row is there
            got, verdict, failed = " ".join(str(error).split()), "FAILED", True
        print(f"{shown}: {got}: {verdict}", flush=True)
        if os.environ.get("HAPTIC_MATRIX_CSV"):
            with open(os.environ["HAPTIC_MATRIX_CSV"], "a", encoding="utf-8", newline="") as table:
                row_of = csv.writer(table, lineterminator="\n")
                row_of.writerow(["network/" + shown, EXPECTED, got, verdict])
    sys.exit(1 if failed else 0)


main()
