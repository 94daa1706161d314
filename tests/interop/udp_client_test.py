"""The client of udp_client.py against a running hapticd: force by UDP, clocks that step and drift,
the fallback."""

import sys
import time

from server_process import Server, argument, eventually

sys.path.insert(0, argument("HAPTIC_PYTHON_PROTO"))
from haptic.v1 import haptic_service_pb2, session_pb2  # noqa: E402

from udp_client import Client  # noqa: E402


def main():
    with Server(argument("HAPTICD")) as server:
        client = Client(server.channel, "127.0.0.1")
        try:
            run(client)
        except AssertionError as failed:
            raise AssertionError(f"{failed}; last refusal: {client.refused}; "
                                 f"state: {client.state}") from failed
        finally:
            client.close()


def turn_the_clock(client, pressed):
    """Steps of +-1 s and a drift of 200 ppm (tests/relay/README.md#rows). Age counts from arrival,
    so that nothing is felt."""
    begin = time.monotonic()
    for turned in (lambda now: 1e9, lambda now: -1e9, lambda now: 200e-6 * (now - begin) * 1e9):
        client.turned = turned
        end = time.monotonic() + 0.7
        before = client.state.proxy_seq_used
        client.publish_until(lambda e=end: time.monotonic() > e, "time passes", pressed)
        assert client.state.state == session_pb2.DEVICE_STATE_NAME_ENGAGED, client.state
        assert client.state.gain == 1.0 and client.state.proxy_seq_used > before, client.state
    assert "LOST" not in client.events, client.events


def run(client):
    eventually(lambda: client.opened and client.state, "the session opens, and a state comes")
    assert client.opened.HasField("udp"), client.opened.udp_refused
    client.start_udp()
    UDP = session_pb2.TRANSPORT_UDP
    client.publish_until(lambda: client.state.transport == UDP and "udp" in client.by,
                         "samples go up, and states come down, by UDP")
    client.publish_until(client.engage, "force is granted")
    pressed = [x - 0.2 for x in client.state.x_probe]
    client.publish_until(
        lambda: client.state.state == session_pb2.DEVICE_STATE_NAME_ENGAGED and
        abs(client.state.tau_elastic[0]) > 0.5, "force is felt", pressed)
    assert client.state.proxy_age_us < 1_000_000, client.state
    for reason in ("SAMPLES GRPC -> UDP", "STATES GRPC -> UDP"):
        eventually(lambda r=reason: r in client.events, reason)
    turn_the_clock(client, pressed)
    # The client leaves the path: the stream carries at once, and nobody loses the lease.
    client.path.close()
    client.path = None
    client.publish_until(lambda: client.state.transport == session_pb2.TRANSPORT_GRPC,
                         "samples go up by the stream again", pressed)
    eventually(lambda: "STATES UDP -> GRPC" in client.events, "states come by the stream again")
    assert "LEASE_EXPIRED" not in client.events, client.events
    client.stub.Release(haptic_service_pb2.ReleaseRequest(session_id=client.opened.session_id))
    print(f"{client.seq} samples, {len(client.events)} events")


main()
