#!/usr/bin/env python3
"""hapticd killed with SIGKILL while it presses: the board stops by its own watchdog
(hw/README.md#the-board-protocol), and so it does where hapticd is only stopped (SIGSTOP). Whole
programs; the times are the board's own.

    killed_test.py HAPTICD HAPTIC-BOARD-EMULATOR SCENE        (package haptic and tests/support on
    PYTHONPATH)
"""

import pathlib
import re
import signal
import sys
import tempfile
import time
import unittest

import haptic
from board_rig import PATIENCE_S, Board, Server, sound, until

HAPTICD, EMULATOR, SCENE = sys.argv[1:4]
WATCHDOG_MS = 200  # a busy machine is no reason for it; loop_late_fault has to be shorter
# The truth's newest row is up to 10 ms old and a moment on its way to the disk; bytes may be in the
# port.
SLACK_S = 0.15


class WhilePressing(unittest.TestCase):
    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def killed_while_pressing(self, server: Server, board: Board, how: signal.Signals) -> float:
        """Presses, and sends the signal when more than 1 N is held; the board's time then, s."""
        with haptic.Connection(server.address) as connection:
            session = connection.session(client_name="presser", nominal_rate_hz=100)
            place: tuple[float, ...] = ()
            latest, asked_at, pressed = time.monotonic() + PATIENCE_S, 0.0, 0
            while pressed < 50:  # for half a second
                session.publish(haptic.held(place) if place else haptic.FREE)
                state = sound(session.wait_for_state(20.0))
                now = time.monotonic()
                self.assertLess(now, latest, state)
                if state.state == "ARMED" and asked_at == 0.0:
                    board.tell("0.4 0.5")  # while the rod follows the hand
                    asked_at = now
                elif state.state == "ARMED" and not place and now > asked_at + 2.0:
                    place = state.x_probe
                    session.engage_when_ready()
                elif state.state == "ENGAGED":
                    if pressed == 0 and abs(state.tau_a[0]) < 0.5:
                        place = tuple(x - 0.15 for x in state.x_probe)  # the object stands in the
                        # finger
                    pressed += abs(state.tau_a[0]) > 1.0 and abs(board.rows(0.01)[-1][3]) > 1.0
            server.process.send_signal(how)  # the session is open still
            return board.rows(0.01)[-1][0]

    def stopped_after(self, how: signal.Signals) -> float:
        """s of the board's time from the signal to the drive's end."""
        board = Board(EMULATOR, self.folder, watchdog_ms=WATCHDOG_MS)
        self.addCleanup(board.stop)
        server = Server(
            HAPTICD, SCENE, self.folder, board, "loop.loop_late_fault={nanos: 150000000}"
        )
        self.addCleanup(server.process.wait)
        self.addCleanup(server.process.kill)
        killed_at = self.killed_while_pressing(server, board, how)
        until("the board stopped", lambda: "STOPPED" in board.log.read_text())
        told = re.findall(r"^([0-9.]+) s: STOPPED, drive off", board.log.read_text(), re.M)
        self.assertEqual(len(told), 1, board.log.read_text())
        return float(told[0]) - killed_at

    def test_the_board_stops_within_its_watchdog(self) -> None:
        for how in (signal.SIGKILL, signal.SIGSTOP):
            with self.subTest(how.name):
                after = self.stopped_after(how)
                self.assertLessEqual(after, 1e-3 * WATCHDOG_MS + SLACK_S)
                self.assertGreater(after, 0.5e-3 * WATCHDOG_MS)  # not before: it was the watchdog
            self.doCleanups()
            self.setUp()


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
