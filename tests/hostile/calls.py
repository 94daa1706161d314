"""Calls that a library would make, and nearly such, through Debian's gRPC. Import it inside a row
only: gRPC does not survive a fork."""

import queue
import threading
import time

import grpc
from haptic.v1 import haptic_service_pb2 as service
from haptic.v1 import haptic_service_pb2_grpc as stubs
from haptic.v1 import session_pb2 as wire

HELD, FREE, PLANES = wire.PROXY_MODE_HELD, wire.PROXY_MODE_FREE, wire.PROXY_MODE_PLANES
CONTROLLER, OBSERVER, TRACKER = wire.ROLE_CONTROLLER, wire.ROLE_OBSERVER, wire.ROLE_TRACKER
TEST, PRIMARY, OPERATOR = 1, 2, 3


def channel(daemon):
    return grpc.insecure_channel(daemon.address, options=[
        ("grpc.use_local_subchannel_pool", 1), ("grpc.initial_reconnect_backoff_ms", 100),
        ("grpc.max_send_message_length", -1)])


def stub(daemon):
    return stubs.HapticServiceStub(channel(daemon))


def raw(daemon, method):
    """A call whose request is any bytes."""
    return channel(daemon).unary_unary("/haptic.v1.HapticService/" + method)


def outcome(call, *arguments, seconds=2.0):
    """"OK", or the name of the status."""
    try:
        call(*arguments, timeout=seconds)
        return "OK"
    except grpc.RpcError as error:
        return error.code().name
    except ValueError as error:  # this library refuses to send it
        return f"not sent: {error}"


class Session:
    """A session stream by hand."""

    def __init__(self, calls, raw_open=None, **fields):
        self.queue, self.seq, self.opened, self.error = queue.Queue(), 0, None, None
        self.answers, self.state, self.events, self.ack = 0, None, [], None
        self.was_free = False
        fields = {"role": CONTROLLER, "client_name": "attacker", "nominal_rate_hz": 100.0,
                  "device": "finger", **fields}
        self.queue.put(raw_open or wire.SessionRequest(open=wire.OpenSession(**fields)))
        self.call = calls.Session(iter(self.queue.get, None))

    def open(self, seconds=3.0):
        """True if the server agreed; then its answers are read in the background."""
        watchdog = threading.Timer(seconds, self.call.cancel)
        watchdog.start()
        try:
            self.opened = next(self.call).opened
            self.seq = max(self.seq, self.opened.newest_seq)
            threading.Thread(target=self.read, daemon=True).start()
            return True
        except (grpc.RpcError, StopIteration) as error:
            self.error = error
            return False
        finally:
            watchdog.cancel()

    @property
    def status(self):
        """Why it was refused or ended."""
        return self.error.code().name if isinstance(self.error, grpc.RpcError) else ""

    def read(self):
        try:
            for answer in self.call:
                self.answers += 1
                which = answer.WhichOneof("message")
                if which == "state":
                    self.state = answer.state
                elif which == "event":
                    self.events.append(answer.event.reason)
                elif which == "ack":
                    self.ack = answer.ack
        except grpc.RpcError as error:
            self.error = error

    def publish(self, position=(0.5236, 0.5236), mode=None, **more):
        """Held, if `mode` is not given; in a new session free until a state says so, because force
        does not begin with a proxy that was held all the time."""
        self.seq += 1
        opened, state = self.opened, self.state
        self.was_free = self.was_free or opened is not None and (
            opened.resumed or state is not None and state.mode == FREE
            and state.lease_epoch == opened.lease_epoch)
        mode = mode or (HELD if self.was_free else FREE)
        sample = {"seq": self.seq, "mode": mode, "position": position, **more}
        self.queue.put(wire.SessionRequest(proxy=wire.ProxySample(**sample)))

    def place(self, seconds=3.0):
        """Where the finger is: the newest state's x_probe."""
        end = time.monotonic() + seconds
        while self.state is None and time.monotonic() < end:
            time.sleep(0.005)
        return tuple(self.state.x_probe)

    def stream(self, seconds, **more):
        """A steady stream at 100 Hz."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            self.publish(**more)
            time.sleep(0.010)

    def end(self):
        self.queue.put(None)
        self.call.cancel()


def controls(calls, name="new", seconds=3.0, **fields):
    """Whether a controller that comes now gets the device, or hears who has it."""
    session = Session(calls, client_name=name, **fields)
    got = session.open(seconds)
    status = session.status
    session.end()
    return "OK" if got else status
