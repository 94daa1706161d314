#!/usr/bin/env python3
"""Three boards on three ports in one hapticd. One is unplugged: it goes into FAULT, and to IDLE
when it is plugged in again and its fault is cleared. The others hold their force meanwhile.

    three_boards_test.py HAPTICD HAPTIC-BOARD-EMULATOR SCENE        (package haptic and
    tests/support on PYTHONPATH)
"""

import contextlib
import pathlib
import sys
import tempfile
import time
import unittest

import haptic
from board_rig import PATIENCE_S, Board, Server, sound

HAPTICD, EMULATOR, SCENE = sys.argv[1:4]
SERIALS = ("THUMB", "INDEX", "MIDDLE")  # as the scene wants them
UNPLUGGED_AT_S, FOR_S = 12.0, 2.0  # of the board's time; the others are engaged by then


class ThreeBoards(unittest.TestCase):
    def test_unplugging_one_does_not_disturb_the_others(self) -> None:
        folder = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory()))
        boards = [
            Board(
                EMULATOR,
                folder / str(i),
                "--serial",
                SERIALS[i],
                *(["--fault", f"unplug@{UNPLUGGED_AT_S}+{FOR_S}"] if i == 1 else []),
            )
            for i in range(3)
        ]
        for board in boards:
            self.addCleanup(board.stop)
        server = Server(HAPTICD, SCENE, folder, boards)
        self.addCleanup(server.stop)
        connection = self.enterContext(haptic.Connection(server.address))
        names = [device.name for device in connection.devices()]
        self.assertEqual(sorted(device.serial for device in connection.devices()), sorted(SERIALS))
        held = [
            self.enterContext(
                connection.session(device=names[i], client_name="holder", nominal_rate_hz=50)
            )
            for i in (0, 2)
        ]
        for session in held:
            session.engage_when_ready()
        place = [session.wait_for_state(20.0).x_probe for session in held]
        seen: set[str] = set()
        latest = time.monotonic() + PATIENCE_S
        while "FAULT" not in seen or state_of(connection, names[1]) != "IDLE":
            for session, x in zip(held, place):
                force = session.state.gain > 0  # which begins with a free proxy
                session.publish(haptic.held(x) if force else haptic.FREE)
            states = [sound(session.wait_for_state(20.0)) for session in held]
            before, now = len(seen), state_of(connection, names[1])
            seen.add(now)
            if now == "FAULT":
                if before < len(seen):  # the others do not feel it
                    self.assertEqual([state.state for state in states], ["ENGAGED"] * 2)
                with contextlib.suppress(haptic.ClientError):  # refused while the port is away
                    connection.clear_fault(device=names[1])
            self.assertLess(time.monotonic(), latest, (seen, states))
        for session, x in zip(held, place):
            session.publish(haptic.held(x))
        self.assertEqual(
            [sound(session.wait_for_state(20.0)).state for session in held], ["ENGAGED"] * 2
        )


def state_of(connection: haptic.Connection, name: str) -> str:
    return next(device.state for device in connection.devices() if device.name == name)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
