"""A whole client written from proto/README.md: session, UDP path, samples, force, fallback."""

import queue
import sys
import threading
import time

import grpc

from server_process import argument, eventually

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
        held = self.state.gain > 0  # force begins with a free proxy
        self.sample = session_pb2.ProxySample(
            seq=self.seq, position=position,
            mode=session_pb2.PROXY_MODE_HELD if held else session_pb2.PROXY_MODE_FREE,
            source_time_ns=self.clock(), device_seq_used=self.state.seq)
        if not (self.path and self.path.send_sample(self.sample)):
            self.send_by_stream(self.sample)

    def publish_until(self, condition, what, position=None, seconds=20.0):
        """`position` None: the proxy is where the device is."""
        def once():
            self.publish(position or list(self.state.x_probe))
            time.sleep(1 / RATE_HZ)
            return condition()
        eventually(once, what, seconds)

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
