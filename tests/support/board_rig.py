"""Runs an emulated board, and a hapticd on its pseudo-terminal: for tests that are scripts."""

from __future__ import annotations

import contextlib
import os
import pathlib
import subprocess
import time
from collections.abc import Callable, Sequence

import haptic

PATIENCE_S = 60.0


def first_in_line() -> None:
    """Raises the emulator's priority, if permitted: a real board never waits for a processor."""
    with contextlib.suppress(PermissionError):
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(60))


def until(what: str, condition: Callable[[], bool]) -> None:
    latest = time.monotonic() + PATIENCE_S
    while not condition():
        if time.monotonic() > latest:
            raise AssertionError(f"not within {PATIENCE_S:g} s: {what}")
        time.sleep(0.02)


class Board:
    """The emulator. rows() gives its true state: (time_s, l_x_m, q_B_rad, force_n)."""

    def __init__(
        self, emulator: str, folder: pathlib.Path, *arguments: str, watchdog_ms: int = 1000
    ) -> None:
        folder.mkdir(exist_ok=True)
        self.port, self.truth, self.log = (
            folder / "board",
            folder / "truth.csv",
            folder / "board.log",
        )
        self.truth.unlink(missing_ok=True)
        with open(self.log, "w", encoding="utf-8") as log:
            self.process = subprocess.Popen(
                [
                    emulator,
                    "--link",
                    self.port,
                    "--hand",
                    "--truth",
                    self.truth,
                    "--watchdog-ms",
                    str(watchdog_ms),
                    *arguments,
                ],
                stdin=subprocess.PIPE,
                stdout=subprocess.DEVNULL,
                stderr=log,
                text=True,
                preexec_fn=first_in_line,
            )
        until("the emulator's port", self.port.exists)

    def stop(self) -> None:
        assert self.process.stdin is not None
        self.process.stdin.close()
        self.process.terminate()
        self.process.wait()

    def tell(self, where: str) -> None:
        """Sends the hand there."""
        assert self.process.stdin is not None
        self.process.stdin.write(where + "\n")
        self.process.stdin.flush()

    def rows(self, seconds: float) -> list[tuple[float, ...]]:
        """The newest so many seconds of the board's time."""
        lines = self.truth.read_text().splitlines()[1:-1]  # the last one may be half written
        rows = [tuple(map(float, line.split(","))) for line in lines[-int(100 * seconds) :]]
        return rows if len(rows) >= 100 * seconds else []

    def hand(self, where: str) -> None:
        """Takes the finger there, and waits until the rod has followed and all is at rest."""
        began = self.rows(0.01)[-1][0] if self.rows(0.01) else 0.0
        self.tell(where)

        def rests() -> bool:
            rows = self.rows(0.5)
            return (
                bool(rows)
                and rows[0][0] > began + 1.0
                and all(
                    max(row[i] for row in rows) - min(row[i] for row in rows) < most
                    for i, most in ((1, 5e-5), (2, 2e-3))
                )
            )

        until(f"the hand at rest at {where}", rests)


class Server:
    """hapticd on these boards, with the longest limits on silence and lateness that its scene
    allows."""

    def __init__(
        self,
        hapticd: str,
        scene: str,
        folder: pathlib.Path,
        boards: Board | Sequence[Board],
        *settings: str,
    ) -> None:
        self.address = f"unix:{folder}/socket"
        self.log = folder / "hapticd.log"
        socket = folder / "socket"
        socket.unlink(missing_ok=True)
        arguments = [hapticd, "--scene", scene, "--listen", self.address]
        for i, board in enumerate([boards] if isinstance(boards, Board) else boards):
            arguments += [
                "--set",
                f"device[{i}].board.port={board.port}",
                "--set",
                f"device[{i}].board.max_silence={{nanos: 100000000}}",
            ]
        for setting in (
            "loop.loop_late_fault={nanos: 500000000}",
            "loop.late_bucket_full=1000000",
            *settings,
        ):
            arguments += ["--set", setting]
        with open(self.log, "w", encoding="utf-8") as log:
            self.process = subprocess.Popen(arguments, stderr=log)
        until(
            "hapticd serves or refuses", lambda: socket.exists() or self.process.poll() is not None
        )

    def stop(self) -> None:
        self.process.terminate()
        self.process.wait()


def sound(state: haptic.DeviceState) -> haptic.DeviceState:
    if state.state == "FAULT":
        raise AssertionError(f"the device went into FAULT: {state}")
    return state
