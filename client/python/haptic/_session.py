"""A session: samples up, states and events down, force."""

from __future__ import annotations

import collections
import threading
import time
from collections.abc import Iterator, Sequence
from typing import Any

import grpc

from ._errors import PASSING, ClientError, ask, to_error
from ._round_trip import RoundTrip
from ._sample import to_sample, with_deepest
from ._state import DeviceState
from ._types import Carriers, Event, Pose, Proxy, SampleCounts, Settings
from ._udp import UdpCarrier, open_udp
from .v1 import haptic_service_pb2 as service
from .v1 import session_pb2 as wire

_ENGAGE_EVERY_S = 0.05
_MOST_EVENTS = 256  # kept for a caller who does not ask


class Session:
    """Connection.session() makes one; `with` or close() ends it. Every method may be called from
    any thread.

    publish() never waits: one sample waits to be sent, and a newer one replaces it. Of the states
    only the newest is kept. Force never comes back by itself: after an event LOST call engage()
    again."""

    def __init__(self, stub: Any, address: str, *, service_device: str, client_name: str,
                 nominal_rate_hz: float, observer: bool, tracker: bool, state_rate_hz: float,
                 carriers: Carriers) -> None:
        if observer and tracker:
            raise ClientError("INVALID_ARGUMENT",
                              "observer, tracker: must not be true both, a session has one role")
        self._stub = stub
        self._period_s = 1.0 / nominal_rate_hz if nominal_rate_hz > 0 else 1.0
        self._changed = threading.Condition()
        self._state: DeviceState | None = None
        self._given: DeviceState | None = None  # to the caller, last
        self._events: collections.deque[Event] = collections.deque(maxlen=_MOST_EVENTS)
        self._ack = wire.SampleAck()
        self._tracker = tracker
        self._waiting: wire.SessionRequest | None = None  # to be sent on the stream
        self._newest: wire.ProxySample | None = None
        self._seq = self._replaced = self._planes_left_out = 0
        self._round_trip = RoundTrip()
        self._ended: ClientError | None = None
        self._closing = False
        self._udp: UdpCarrier | None = None
        self._wish: object = None  # of the newest engage_when_ready(), until release() or a fault
        self._engaging = threading.Lock()  # held while engage_when_ready() asks
        opening = wire.OpenSession(
            device=service_device, client_name=client_name, nominal_rate_hz=nominal_rate_hz,
            state_rate_hz=state_rate_hz,
            udp_wanted=carriers is Carriers.BEST and not tracker,  # poses go on the stream
            role=wire.ROLE_TRACKER if tracker else
            wire.ROLE_OBSERVER if observer else wire.ROLE_CONTROLLER)
        self._call = stub.Session(self._requests(opening))
        try:
            self._opened = self._open()
            devices = ask(stub.ListDevices, service.ListDevicesRequest()).devices
            self._kinds = next((tuple(c.kind for c in device.coordinates) for device in devices
                                if device.name == self._opened.device), ())
            self._udp = open_udp(self._opened, address, self._period_s, self._on_udp_state,
                                 self._on_udp_late)
        except BaseException:  # the caller gets no session to close: give the lease back now
            self._stop()
            self._call.cancel()
            raise
        self._reader = threading.Thread(target=self._read, name="haptic session", daemon=True)
        self._reader.start()

    def __enter__(self) -> Session:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Ends the session: force fades out and the lease ends. Idempotent."""
        if not self._stop():
            return
        if self._udp is not None:
            self._udp.close()
        self._reader.join(timeout=1.0)
        self._call.cancel()

    def _stop(self) -> bool:
        """Ends the thread that sends, and every wait; False if that was done before."""
        with self._changed:
            first, self._closing = not self._closing, True
            self._changed.notify_all()
            return first

    # What goes up.

    def publish(self, proxy: Proxy) -> int:
        """Sends where the proxy is, computed from the last state that wait_for_state() or `state`
        gave; returns the sample's number. Raises if the session has ended, or is a tracker's."""
        with self._changed:
            self._check()
            if self._tracker:
                raise ClientError("INVALID_ARGUMENT", "publish: a tracker has publish_pose()")
            used = self._given or self._state
            x_probe = used.x_probe if used else ()
            fitting = with_deepest(proxy, x_probe, self._kinds)
            self._planes_left_out += len(proxy.planes) - len(fitting.planes)
            self._seq += 1
            self._round_trip.published(self._seq)
            self._newest = to_sample(fitting, self._seq, used.seq if used else 0)
            if self._udp is None or not self._udp.send(self._newest.SerializeToString()):
                self._offer(wire.SessionRequest(proxy=self._newest))
            return self._seq

    def publish_pose(self, pose: Pose) -> int:
        """Sends the pose of a tracker; returns its number. Raises if the session has ended, or is
        no tracker's. samples() counts the poses that the server cannot use."""
        with self._changed:
            self._check()
            if not self._tracker:
                raise ClientError("INVALID_ARGUMENT",
                                  "publish_pose: the session must have tracker=True")
            self._seq += 1
            self._offer(wire.SessionRequest(tracker=wire.TrackerSample(
                seq=self._seq, valid_for_us=round(pose.valid_for_s * 1e6), position=pose.position,
                orientation=pose.orientation)))
            return self._seq

    def _offer(self, request: wire.SessionRequest) -> None:
        if self._waiting is not None:
            self._replaced += 1
        self._waiting = request
        self._changed.notify_all()

    def _requests(self, opening: wire.OpenSession) -> Iterator[wire.SessionRequest]:
        """Runs on a thread of grpc, which asks for a message once it wrote the one before."""
        yield wire.SessionRequest(open=opening)
        while True:
            with self._changed:
                self._changed.wait_for(lambda: self._waiting is not None or self._closing)
                request, self._waiting = self._waiting, None
                if self._closing or request is None:
                    return
            yield request

    # Force.

    def engage(self) -> None:
        """Asks for force once. Raises ClientError and says what is missing."""
        ask(self._stub.Engage, service.EngageRequest(session_id=self._opened.session_id))

    def engage_when_ready(self) -> None:
        """Asks for force in the background, every 50 ms, until the server agrees, the device is in
        FAULT, or release() or the session's end. publish() and wait_for_state() raise a refusal
        that time cannot cure."""
        wish = self._wish = object()
        threading.Thread(target=self._engage_when_ready, args=(wish,), name="haptic engage",
                         daemon=True).start()

    def _engage_when_ready(self, wish: object) -> None:
        while not self._closing and self._ended is None:
            try:
                with self._engaging:
                    return self.engage() if wish is self._wish else None
            except ClientError as error:
                state = self._state
                fault = state is not None and state.state == "FAULT"
                if error.reason not in PASSING or fault:
                    return self._end(error) if wish is self._wish else None
            time.sleep(_ENGAGE_EVERY_S)

    def release(self) -> None:
        """Gives force up; it fades out. Ends engage_when_ready()."""
        self._wish = None
        with self._engaging:  # an Engage on its way must not overtake the Release
            ask(self._stub.Release, service.ReleaseRequest(session_id=self._opened.session_id))

    def update_settings(self, *, stiffness: Sequence[float] = (), damping: Sequence[float] = (),
                        force_limit: Sequence[float] = (),
                        slew_limit: Sequence[float] = ()) -> Settings:
        """Changes settings within the limits of the scene, per actuated DoF; an empty one stays as
        it is. Returns what was applied."""
        return Settings.of(ask(self._stub.UpdateSettings, service.UpdateSettingsRequest(
            session_id=self._opened.session_id, stiffness=stiffness, damping=damping,
            force_limit=force_limit, slew_limit=slew_limit)))

    # What comes down.

    @property
    def device(self) -> str:
        return str(self._opened.device)

    @property
    def state(self) -> DeviceState | None:
        """The newest state; None before the first."""
        with self._changed:
            self._given = self._state
            return self._given

    def wait_for_state(self, timeout: float = 5.0) -> DeviceState:
        """Waits for a state newer than the newest now. Raises TIMEOUT, or why the session ended."""
        with self._changed:
            seen = self._state.seq if self._state else 0
            self._changed.wait_for(
                lambda: self._ended or (self._state is not None and self._state.seq > seen),
                timeout)
            self._check()
            if self._state is None or self._state.seq <= seen:
                raise ClientError("TIMEOUT", f"no state within {timeout:g} s")
            self._given = self._state
            return self._given

    def events(self) -> list[Event]:
        """The events since the last call, at most the newest 256."""
        with self._changed:
            events = list(self._events)
            self._events.clear()
            return events

    def samples(self) -> SampleCounts:
        with self._changed:
            a = self._ack
            return SampleCounts(self._seq, self._replaced, a.accepted, a.rejected_old,
                                a.rejected_invalid, a.conflated_backlog, a.last_rejection,
                                self._planes_left_out)

    @property
    def round_trip_s(self) -> float:
        """From publish() to the arrival of the first state that used the sample, by whatever
        carrier: rises at once, falls slowly. 0: not known yet. For contact_horizon()."""
        return self._round_trip.value_s

    @property
    def udp_in_use(self) -> bool:
        """Whether samples go by UDP now."""
        return self._udp is not None and self._udp.in_use

    def _check(self) -> None:
        if self._ended is not None:
            raise self._ended
        if self._closing:
            raise ClientError("CLOSED", "the session was closed")

    def _open(self) -> wire.SessionOpened:
        try:
            response: wire.SessionResponse = next(self._call)
            return response.opened
        except grpc.RpcError as error:
            raise to_error(error) from None
        except StopIteration:
            raise ClientError("CLOSED", "the server ended the stream") from None

    def _read(self) -> None:
        ended = ClientError("CLOSED", "the server ended the session")
        try:
            for response in self._call:
                self._take(response)
        except grpc.RpcError as error:
            ended = to_error(error)
        self._end(ended)

    def _end(self, why: ClientError) -> None:
        with self._changed:
            if not self._closing:
                self._ended = self._ended or why
            self._changed.notify_all()

    def _take(self, response: wire.SessionResponse) -> None:
        if response.HasField("udp") and self._udp is not None:
            self._udp.rekey(response.udp)
        with self._changed:
            if response.HasField("state"):
                if self._state is None or response.state.seq > self._state.seq:
                    self._state = DeviceState.of(response.state)
                    self._round_trip.used(self._state.proxy_seq_used)
            elif response.HasField("event"):
                self._events.append(Event.of(response.event))
                if response.event.kind == wire.Event.KIND_FAULT:
                    self._wish = None  # clearing it must not start a motor
            elif response.HasField("ack"):
                self._ack = response.ack
            self._changed.notify_all()

    # The UDP path's calls, on its thread.

    def _on_udp_state(self, payload: bytes) -> None:
        self._take(wire.SessionResponse(state=wire.DeviceState.FromString(payload)))

    def _on_udp_late(self) -> None:
        """The newest sample may be lost: it goes by the stream too, under the same number."""
        with self._changed:
            if self._newest is not None and not self._closing:
                self._offer(wire.SessionRequest(proxy=self._newest))
