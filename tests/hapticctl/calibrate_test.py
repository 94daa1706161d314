#!/usr/bin/env python3
"""`hapticctl calibrate` between live programs: the board emulator with a potentiometer that has
drifted and stretches, and a load cell with an offset; hapticd on its pseudo-terminal; the command,
with this script as the person, who knows the truth because the emulator writes it down. Then
hapticd with the file that was made, whose readings must be true, and with a board that is not the
file's.

    calibrate_test.py HAPTICD HAPTICCTL HAPTIC-BOARD-EMULATOR SCENE        (package haptic and
    tests/support on PYTHONPATH)

Limits on silence and lateness are as long as the scene allows, and every step waits for its
condition.
"""

import contextlib
import pathlib
import subprocess
import sys
import tempfile
import threading
import unittest

import haptic
from board_rig import PATIENCE_S, Board, Server, until

HAPTICD, HAPTICCTL, EMULATOR, SCENE = sys.argv[1:5]
STRAIGHT, HALFWAY, BENT = "0.2 0.2", "0.4 0.5", "0.7 0.9"  # rad, where the hand takes the joints


def person(process: subprocess.Popen[str], board: Board) -> list[str]:
    """Answers what the command asks; the questions."""
    asked = []
    assert process.stdin is not None and process.stdout is not None
    while question := next_question(process):
        asked.append(question)
        process.stdin.write(answer(question, board) + "\n")
        process.stdin.flush()
    return asked


def next_question(process: subprocess.Popen[str]) -> str:
    """Up to the prompt; empty: the command has ended."""
    assert process.stdout is not None
    text = ""
    while not text.endswith("\n> ") and (letter := process.stdout.read(1)):
        text += letter
    return text.removesuffix("\n> ") if text.endswith("\n> ") else ""


def answer(question: str, board: Board) -> str:
    last = question.splitlines()[-1]
    if last.startswith("Bring "):
        board.hand(STRAIGHT if " first " in last else BENT)
        row = board.rows(0.01)[-1]
        return repr(row[1] if "l_x" in last else row[2])
    if last.startswith("Move "):
        for place in (BENT, STRAIGHT):
            board.hand(place)
        return ""
    if last.startswith("Hold the device"):
        board.hand(HALFWAY)
        return ""
    if last.startswith("Let go"):
        board.hand("let-go")
        return ""
    if last.startswith("Write this to"):
        return "y"
    raise AssertionError(f"a question that the script does not know: {question}")


class Calibrate(unittest.TestCase):
    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.file = self.folder / "finger.textproto"

    def board(self, serial: str, offset_m: float = 0.0) -> Board:
        board = Board(
            EMULATOR,
            self.folder,
            "--serial",
            serial,
            "--l-x-scale",
            "1.04",
            "--force-offset",
            "0.8",
            "--l-x-offset",
            str(offset_m),
            "--fault",
            "drift@0+1=0.001",
        )  # 1 mm within the first second, and there it stays
        self.addCleanup(board.stop)
        return board

    def server(self, board: Board, *settings: str) -> Server:
        server = Server(HAPTICD, SCENE, self.folder, board, *settings)
        self.addCleanup(server.stop)
        return server

    @staticmethod
    def clear(server: Server) -> None:
        def cleared() -> bool:
            with contextlib.suppress(haptic.ClientError):
                connection.clear_fault()
            return connection.devices()[0].faults == 0

        with haptic.Connection(server.address) as connection:
            until("no fault", cleared)

    def calibrate(self, server: Server, board: Board, wanted: int = 0) -> tuple[list[str], str]:
        """The questions, and what it said on standard error; it ends with `wanted`."""
        process = subprocess.Popen(
            [HAPTICCTL, "--server", server.address, "calibrate", "--output", self.file],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        watchdog = threading.Timer(5 * PATIENCE_S, process.kill)
        watchdog.start()
        try:
            asked = person(process, board)
            assert process.stderr is not None
            complaint = process.stderr.read()
            self.assertEqual(process.wait(), wanted, (complaint, asked))
            return asked, complaint
        finally:
            watchdog.cancel()
            process.kill()
            process.communicate()

    def test_the_file_serves_that_board_alone(self) -> None:
        board = self.board("HX-0042")
        server = self.server(board)
        self.clear(server)
        asked, _ = self.calibrate(server, board)
        self.assertEqual(
            len(asked), 9, asked
        )  # two places and the travel of each DoF, off, let go, write
        server.stop()

        stored = f"device[0].board.calibration_file={self.file}"
        server = self.server(board, stored)
        with haptic.Connection(server.address) as connection:
            (device,) = connection.devices()
            with connection.session(
                client_name="reader", nominal_rate_hz=200, observer=True
            ) as session:
                states = [session.wait_for_state() for _ in range(100)]
        _, l_x, q_B, force = board.rows(0.01)[-1]  # the hand has let go: all rests
        self.assertAlmostEqual(states[-1].q[0], l_x, delta=1e-4)
        self.assertAlmostEqual(states[-1].q[1], q_B, delta=5e-3)
        measured = sum(state.tau_measured[0] for state in states) / len(states)
        self.assertAlmostEqual(measured, force, delta=0.02)
        self.assertEqual(device.serial, "HX-0042")
        self.assertIn(f'date: "{device.calibrated}"', self.file.read_text())
        again = subprocess.run(
            [HAPTICCTL, "--server", server.address, "calibrate"],
            input="",
            capture_output=True,
            text=True,
            timeout=60,
        )
        self.assertEqual(again.returncode, 2)
        self.assertIn("start hapticd without board.calibration_file", again.stderr)
        server.stop()
        board.stop()

        other = Server(HAPTICD, SCENE, self.folder, self.board("HX-0043"), stored)
        self.assertNotEqual(other.process.wait(timeout=60), 0)
        self.assertIn("was made with the device 'HX-0042' on", other.log.read_text())
        self.assertIn("this one is 'HX-0043'", other.log.read_text())

    def test_a_sensor_that_leaves_the_scenes_range_is_told_with_what_to_do(self) -> None:
        board = self.board("HX-0044", offset_m=0.018)  # beyond 35.2 mm where the finger is bent
        server = self.server(board)
        board.hand(STRAIGHT)
        self.clear(server)
        _, complaint = self.calibrate(server, board, wanted=5)
        self.assertRegex(complaint, "'finger' is in FAULT, .*SAMPLE_OUT_OF_RANGE")
        self.assertIn("hapticctl clear-fault", complaint)
        self.assertFalse(self.file.exists())


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
