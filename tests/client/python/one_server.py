"""Tests of the package `haptic` against a hapticd of their own."""

from __future__ import annotations

import time
import unittest
from collections.abc import Callable

import haptic
from hapticd_process import Hapticd, eventually


def reasons_until(session: haptic.Session, last: str) -> list[str]:
    """The reasons of the events up to `last`. It may come after the state that shows its effect:
    states and events go from the owner to the front by two ways."""
    reasons: list[str] = []

    def told() -> bool:
        reasons.extend(event.reason for event in session.events())
        return last in reasons

    if not eventually(told):
        raise AssertionError(f"no event {last!r} among {reasons}")
    return reasons


class OneServer(unittest.TestCase):
    """A hapticd per test, and a connection to it."""
    scene = "finger_constant"
    udp = False
    lease_s = 2
    settings: tuple[str, ...] = ()

    def setUp(self) -> None:
        self.server = Hapticd(self.scene, udp=self.udp, lease_s=self.lease_s,
                              settings=self.settings)
        self.addCleanup(self.server.stop)
        self.connection = haptic.Connection(self.server.address)
        self.addCleanup(self.connection.close)

    def open(self, *, client_name: str = "test", **options: object) -> haptic.Session:
        session = self.connection.session(client_name=client_name, nominal_rate_hz=100, **options)
        self.addCleanup(session.close)
        return session

    def hold(self, session: haptic.Session, until: Callable[[haptic.DeviceState], bool],
             each_time: Callable[[], object] = lambda: None) -> haptic.DeviceState:
        """Publishes a proxy per state, until `until`: free, and as soon as there is force held at
        the place where force began."""
        place, force = session.wait_for_state().x_probe, False
        latest = time.monotonic() + 20
        while time.monotonic() < latest:
            each_time()
            session.publish(haptic.held(place) if force else haptic.FREE)
            state = session.wait_for_state()
            if until(state):
                return state
            force = state.gain > 0
            if not force:
                place = state.x_probe
        self.fail(f"still {state}")
