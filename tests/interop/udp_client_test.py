"""A whole client written from proto/README.md: session, UDP path, samples, force, and the fallback."""

import queue
import sys
import threading
import time

import grpc

from server_process import Server, argument, eventually

sys.path.insert(0, argument("HAPTIC_PYTHON_PROTO"))
from haptic.v1 import haptic_service_pb2, haptic_service_pb2_grpc, session_pb2  # noqa: E402

from udp_path import UdpPath  # noqa: E402

RATE_HZ = 100.0


class Client:
    def __init__(self, channel, stream_host):
        self.stub = haptic_service_pb2_grpc.HapticServiceStub(channel)
        self.outgoing, self.state, self.opened = queue.Queue(), None, None
        self.events, self.by, self.seq, self.sample, self.refused = [], set(), 0, None, None
        self.path, self.stream_host, self.lock = None, stream_host, threading.Lock()
        self.turned = lambda now: 0
        self.stream = self.stub.Session(iter(self.outgoing.get, None))
        request = session_pb2.SessionRequest()
        request.open.role = session_pb2.ROLE_CONTROLLER
        request.open.client_name = "python"
        request.open.nominal_rate_hz = RATE_HZ
        request.open.udp_wanted = True
        self.outgoing.put(request)
        self.reader = threading.Thread(target=self.read)
        self.reader.start()

    def read(self):
        try:
            for response in self.stream:
                which = response.WhichOneof("message")
                if which == "opened":
                    self.opened = response.opened
                elif which == "state":
                    self.take(response.state, "stream")
                elif which == "event":
                    self.events.append(response.event.reason)
        except grpc.RpcError as error:
            assert error.code() == grpc.StatusCode.CANCELLED, error

    def take(self, state, by):
        with self.lock:
            if self.state is None or state.seq > self.state.seq:  # whatever carried it
                self.state = state
                self.by.add(by)

    def start_udp(self):
        self.path = UdpPath(
            self.opened.udp, self.stream_host, 1 / RATE_HZ,
            lambda payload: self.take(session_pb2.DeviceState.FromString(payload), "udp"),
            lambda: self.send_by_stream(self.sample), self.clock)

    def clock(self):
        """This client's steady clock, ns; where it does what a clock must not, by `turned`."""
        return time.monotonic_ns() + int(self.turned(time.monotonic()))

    def send_by_stream(self, sample):
        self.outgoing.put(session_pb2.SessionRequest(proxy=sample))

    def publish(self, position):
        self.seq += 1
        self.sample = session_pb2.ProxySample(
            seq=self.seq, mode=session_pb2.PROXY_MODE_HELD, position=position,
            source_time_ns=self.clock(), device_seq_used=self.state.seq)
        if not (self.path and self.path.send_sample(self.sample)):
            self.send_by_stream(self.sample)

    def publish_until(self, condition, what, position=None):
        """`position` None: the proxy is where the device is."""
        def once():
            self.publish(position or list(self.state.x_probe))
            time.sleep(1 / RATE_HZ)
            return condition()
        eventually(once, what)

    def engage(self):
        try:
            self.stub.Engage(haptic_service_pb2.EngageRequest(session_id=self.opened.session_id))
            return True
        except grpc.RpcError as error:
            assert error.code() == grpc.StatusCode.FAILED_PRECONDITION, error
            self.refused = error.details()
            return False  # normal at first: wait a little, ask again

    def close(self):
        if self.path:
            self.path.close()
        self.outgoing.put(None)
        self.stream.cancel()
        self.reader.join()


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
    """WIRE 6: steps of +-1 s, and a drift of 200 ppm. Age counts from arrival: nothing is felt."""
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
