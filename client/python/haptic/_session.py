"""A session: samples up, states and events down, force."""

from __future__ import annotations

import time
from collections.abc import Iterable
from typing import Any

from ._facts import Device
from ._library import ClientError, Handle, ask, call, doubles, ffi, floats, lib, new, put
from ._library import refusal
from ._messages import PROXY_MODE, RENDERER, DeviceState
from ._types import Event, Pose, Proxy, Settings, Statistics, read

_SLICE_S = 0.1  # of a wait, after which Ctrl-C is heard
_MODES = {name: mode for mode, name in PROXY_MODE.items()}
_RENDERERS = {name: number for number, name in RENDERER.items()}


class Session(Handle):
    """Connection.session() makes one; `with` or close() ends it. Every method may be called from
    any thread.

    publish() never waits: the newest sample wins. Of the states only the newest is kept. Without
    re_engage force never comes back by itself: after an event LOST call engage_when_ready()
    again."""

    def __init__(self, c: Any) -> None:
        super().__init__(c, lib.haptic_close)
        device = new("haptic_device")
        call(lib.haptic_device_of, self._c, device)
        self._device = Device.of(device)

    # The way up.

    def publish(self, proxy: Proxy) -> None:
        """Sends where the proxy is, computed from the last state that wait_for_state() or `state`
        gave. Raises if the session has ended, or is an observer's or a tracker's."""
        count = len(self._device.coordinates)
        if proxy.mode not in _MODES:
            raise ValueError(f"mode: {proxy.mode!r}, must be one of " + ", ".join(_MODES))
        sample, x = new("haptic_proxy"), doubles(proxy.position)
        sample.mode, sample.valid_for_us = _MODES[proxy.mode], round(proxy.valid_for_s * 1e6)
        sample.x, sample.count = x, len(x)
        planes = ffi.new("haptic_plane[]", len(proxy.planes))
        for i, plane in enumerate(proxy.planes):
            if len(plane.normal) != count:
                raise ValueError(f"planes[{i}].normal: has {len(plane.normal)} values, must have "
                                 f"{count}, one per coordinate")
            planes[i].size = ffi.sizeof("haptic_plane")
            plane.fill(planes[i])
        sample.planes, sample.plane_count = planes, len(planes)
        call(lib.haptic_publish, self._c, sample)

    def publish_pose(self, pose: Pose) -> None:
        """Sends the pose of a tracker. Raises if the session has ended, or is no tracker's.
        statistics() counts the poses that the server cannot use."""
        sample = new("haptic_pose")
        sample.position = floats(pose.position, 3, "position")
        sample.orientation = floats(pose.orientation, 4, "orientation")
        sample.valid_for_us = round(pose.valid_for_s * 1e6)
        call(lib.haptic_publish_pose, self._c, sample)

    # Force.

    def engage(self) -> None:
        """Asks for force once. Raises ClientError and says what is missing."""
        ask(lib.haptic_engage, self._c)

    def engage_when_ready(self) -> None:
        """Asks for force in the background, every 50 ms, until the server agrees, a fault, a
        refusal that waiting does not change, release() or the session's end."""
        call(lib.haptic_engage_when_ready, self._c)

    @property
    def engage_refusal(self) -> ClientError | None:
        """Why engage_when_ready() has no force yet, or why it gave up; None after the server
        agreed."""
        return refusal(lib.haptic_engage_refusal, self._c)

    def release(self) -> None:
        """Gives force up; it fades out. Ends engage_when_ready()."""
        ask(lib.haptic_release, self._c)

    def update_settings(self, *, stiffness: Iterable[float] = (), damping: Iterable[float] = (),
                        force_limit: Iterable[float] = (), slew_limit: Iterable[float] = (),
                        renderer: str = "NONE", direction_guard: bool | None = None) -> Settings:
        """Changes settings within the limits of the scene, per actuated DoF; an empty one stays as
        it is. `renderer`: "SUBSPACE_LINEAR", ... of session.proto; it changes without force only.
        Returns what was applied."""
        if renderer not in _RENDERERS:
            raise ValueError(f"renderer: {renderer!r}, must be one of " + ", ".join(_RENDERERS))
        wanted, applied = new("haptic_settings"), new("haptic_settings")
        for name, values in (("stiffness", stiffness), ("damping", damping),
                             ("force_limit", force_limit), ("slew_limit", slew_limit)):
            getattr(wanted, name).count = put(getattr(wanted, name).value, floats(values), name)
        wanted.renderer = _RENDERERS[renderer]
        if direction_guard is not None:
            wanted.direction_guard = 1 if direction_guard else 2
        ask(lib.haptic_update, self._c, wanted, applied)
        return Settings.of(applied)

    # The way down.

    @property
    def device(self) -> Device:
        """As it was when the session opened."""
        return self._device

    @property
    def state(self) -> DeviceState | None:
        """The newest state; None before the first."""
        state = new("haptic_state")
        call(lib.haptic_newest_state, self._c, state)
        return DeviceState.of(state) if state.seq > 0 else None

    def wait_for_state(self, timeout: float = 5.0) -> DeviceState:
        """Waits for a state newer than the last one that this gave. Raises TIMEOUT, or why the
        session ended."""
        state, end = new("haptic_state"), time.monotonic() + timeout
        while True:
            left = end - time.monotonic()
            wait_ms = max(0, round(min(left, _SLICE_S) * 1e3))
            try:
                call(lib.haptic_wait_for_state, self._c, wait_ms, state)
                return DeviceState.of(state)
            except ClientError as error:
                if error.reason != "TIMEOUT":
                    raise
            if left <= _SLICE_S:
                raise ClientError("TIMEOUT", f"no state within {timeout:g} s")

    def events(self) -> list[Event]:
        """The events since the last call, at most the newest 256."""
        events, event = [], new("haptic_event")
        while call(lib.haptic_next_event, self._c, event) == lib.HAPTIC_OK:
            events.append(Event.of(event))
        return events

    def statistics(self) -> Statistics:
        return read(Statistics, self._statistics())

    @property
    def round_trip_s(self) -> float:
        """From publish() to the arrival of the first state that used the sample, by whatever
        carrier: rises at once, falls slowly. 0: not known yet. For contact_horizon()."""
        return float(self._statistics().round_trip_ns * 1e-9)

    @property
    def connected(self) -> bool:
        """Whether the session has a stream; not while it reconnects."""
        return bool(self._statistics().connected == 1)

    @property
    def lease_epoch(self) -> int:
        """Rises with every lease; 0: none."""
        return int(self._statistics().lease_epoch)

    def _statistics(self) -> Any:
        counted = new("haptic_statistics")
        call(lib.haptic_statistics_of, self._c, counted)
        return counted
