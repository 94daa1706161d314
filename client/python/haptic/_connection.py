"""A connection to hapticd: facts about the server and its devices, sessions, emergency stop."""

from __future__ import annotations

import threading
from collections.abc import Iterator, Sequence
from typing import Any

import grpc

from ._errors import ClientError, ask, to_error
from ._ports import DEFAULT_SERVER
from ._session import Session
from ._state import DeviceState
from ._types import Carriers, Device, Event, ServerInfo
from .v1 import haptic_service_pb2 as service
from .v1 import haptic_service_pb2_grpc as stubs

_OPTIONS = [
    ("grpc.use_local_subchannel_pool", 1),
    # A connection over which nothing comes back is given up: a ping after 1 s of silence, 2 s for
    # an answer or for TCP's acknowledgement.
    ("grpc.keepalive_time_ms", 1000),
    ("grpc.keepalive_timeout_ms", 2000),
    ("grpc.http2.max_pings_without_data", 0),
    # An attempt takes 1.5 s at most ("min_reconnect_backoff"), and the next follows within 0.5 s.
    ("grpc.initial_reconnect_backoff_ms", 100),
    ("grpc.min_reconnect_backoff_ms", 1500),
    ("grpc.max_reconnect_backoff_ms", 500),
]


class Connection:
    """A connection to "host:port" or "unix:/path". Does not wait for the server. A call that needs
    an answer raises ClientError if none comes within 5 s."""

    def __init__(self, address: str = DEFAULT_SERVER) -> None:
        host, colon, port = address.rpartition(":")
        if not (address.startswith("unix:/") or (host and colon and port.isdigit())):
            raise ClientError("INVALID_ARGUMENT",
                              f"server address '{address}': must be host:port or unix:/path")
        self._address = address
        self._channel = grpc.insecure_channel(address, options=_OPTIONS)
        # Without a call under way grpc looks after a connection every 5 s: one that the network
        # has just given back would stay half made for so long. Watching it makes it look at once.
        before = set(threading.enumerate())
        self._channel.subscribe(self._watch)
        self._watchers = set(threading.enumerate()) - before
        self._stub = stubs.HapticServiceStub(self._channel)

    def __enter__(self) -> Connection:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    @staticmethod
    def _watch(_: object) -> None:
        pass

    def close(self) -> None:
        # grpc's watcher asks every 0.2 s whether it is still wanted. If the channel is closed
        # earlier, the watcher ends with a traceback.
        self._channel.unsubscribe(self._watch)
        for watcher in self._watchers:
            watcher.join(1.0)
        self._channel.close()

    def server_info(self) -> ServerInfo:
        return ServerInfo.of(ask(self._stub.GetServerInfo, service.GetServerInfoRequest()))

    def devices(self) -> list[Device]:
        answer = ask(self._stub.ListDevices, service.ListDevicesRequest())
        return [Device.of(device) for device in answer.devices]

    def session(self, *, client_name: str, nominal_rate_hz: float, device: str = "",
                observer: bool = False, tracker: bool = False, state_rate_hz: float | None = None,
                carriers: Carriers = Carriers.BEST) -> Session:
        """Opens a session and waits until the server agrees. Close it, or use it in `with`. States
        come at `state_rate_hz`; None: at the nominal rate; 0: every tick, which is much for Python.
        An `observer` only receives; a `tracker` publishes poses of the palm that carries the device
        (publish_pose()). A session is not both."""
        rate = nominal_rate_hz if state_rate_hz is None else state_rate_hz
        return Session(self._stub, self._address, service_device=device, client_name=client_name,
                       nominal_rate_hz=nominal_rate_hz, observer=observer, tracker=tracker,
                       state_rate_hz=rate, carriers=carriers)

    def watch(self, device: str = "", rate_hz: float = 30.0) -> Iterator[DeviceState | Event]:
        """States and events of a device until the server ends, or the iterator is closed."""
        call = self._stub.Watch(service.WatchRequest(device=device, rate_hz=rate_hz))
        try:
            for response in call:
                if response.HasField("state"):
                    yield DeviceState.of(response.state)
                elif response.HasField("event"):
                    yield Event.of(response.event)
        except grpc.RpcError as error:
            raise to_error(error) from None
        finally:
            call.cancel()

    def emergency_stop(self, device: str = "", reason: str = "") -> list[str]:
        """Stops `device`, or all devices if it is empty; needs no session. Returns the devices that
        are in FAULT now."""
        request = service.EmergencyStopRequest(device=device, reason=reason)
        return list(ask(self._stub.EmergencyStop, request).stopped)

    def clear_fault(self, device: str = "", faults: Sequence[int] = ()) -> list[int]:
        """Clears faults by number; empty: all that are active. Returns what was cleared. Raises
        FAULT_PERSISTS if a cause persists."""
        request = service.ClearFaultRequest(device=device, fault_ids=faults)
        return list(ask(self._stub.ClearFault, request).cleared)
