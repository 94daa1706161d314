#!/usr/bin/env python3
"""The serial link as a whole, by the counters of its two ends.

    serial.py --programs BUILD --root SOURCES [--minutes 10] [--mode streaming|500hz] [--paced]

haptic-board-emulator on a pseudo-terminal, its user moved by the motion that ships; hapticd on it;
the soft grasp as its client. Rates and ages are of the time after settling; frames of the whole
run, as both ends say when they close: hapticd in its log, the emulator on standard error. Judged by
serial_verdict.py.
"""

import argparse
import contextlib
import pathlib
import re
import subprocess
import sys
import tempfile
import time
import urllib.request
from collections.abc import Callable, Iterator

from serial_verdict import Run, verdicts

SETTLING_S = 5.0
MODES = {"streaming": ("0", 2.0), "500hz": ("2", 4.0)}  # link period in ms, target of p99 in ms
FRAMES = re.compile(r'^haptic_link_frames_total\{.*end="host",what="received"\} (\S+)$', re.M)
AGES = re.compile(r'^haptic_device_sample_age_seconds_bucket\{.*le="([^"]+)"\} (\S+)$', re.M)
METRICS = re.compile(r"metrics on port (\d+)")
PACED = re.compile(r"^haptic_loop_sample_paced_ticks_total\{.*\} (\S+)$", re.M)
FAULTS = re.compile(r'^haptic_faults_total\{.*fault="([^"]+)"\} (\S+)$', re.M)


class Failed(Exception):
    pass


def until(what: str, condition: Callable[[], bool], seconds: float = 30.0) -> None:
    latest = time.monotonic() + seconds
    while not condition():
        if time.monotonic() > latest:
            raise Failed(f"not within {seconds:g} s: {what}")
        time.sleep(0.05)


@contextlib.contextmanager
def running(arguments: list[object], log: pathlib.Path) -> Iterator[subprocess.Popen[bytes]]:
    """Ends it by SIGTERM if it still runs; its output is in `log`."""
    with open(log, "wb") as file:
        process = subprocess.Popen(
            [str(a) for a in arguments], stdout=subprocess.DEVNULL, stderr=file
        )
    try:
        yield process
    finally:
        process.terminate()
        process.wait(timeout=30)


class Page:
    """One scrape."""

    def __init__(self, url: str) -> None:
        with urllib.request.urlopen(url, timeout=10) as answer:
            text = answer.read().decode()
        self.at = time.monotonic()
        frames = FRAMES.search(text)
        if frames is None:
            raise Failed("no haptic_link_frames_total in the metrics")
        self.frames = int(float(frames[1]))
        self.ages = [(float(bound), int(float(n))) for bound, n in AGES.findall(text)]
        paced = PACED.search(text)
        self.paced = int(float(paced[1])) if paced else 0
        self.faults = {name: int(float(n)) for name, n in FAULTS.findall(text)}


def numbers(text: str) -> dict[str, int]:
    """The counters of "name 12, other name 3"."""
    return {
        name.replace(" ", "_"): int(n)
        for name, n in re.findall(r"([A-Za-z][A-Za-z _]*?) (\d+)", text)
    }


def host_counters(log: str) -> dict[str, int]:
    found = re.search(r"link closed, frames: (.*)$", log, re.M)
    if found is None:
        raise Failed("hapticd did not say what became of its frames:\n" + log)
    return {
        name.removeprefix("host_"): n
        for name, n in numbers(found[1]).items()
        if name.startswith("host_")
    }


def board_counters(log: str) -> dict[str, int]:
    found = re.search(r"^accepted \d.*$", log, re.M)
    if found is None:
        raise Failed("the emulator did not say what became of its frames:\n" + log)
    all_of_them = {name.lower(): n for name, n in numbers(found[0]).items()}
    return {"without_room": all_of_them.pop("frames_without_room"), **all_of_them}


def run(
    programs: pathlib.Path, root: pathlib.Path, link_period_ms: str, seconds: float, paced: bool
) -> Run:
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        port, socket, server_log = folder / "board", folder / "socket", folder / "hapticd.log"
        with running(
            [
                programs / "hw/haptic-board-emulator",
                "--link",
                port,
                "--link-period-ms",
                link_period_ms,
                "--watchdog-ms",
                "1000",
                "--motion",
                root / "server/scenes/motion/reach_and_grasp.csv",
            ],
            folder / "board.log",
        ):
            until("the emulator's port", port.exists)
            with running(
                [
                    programs / "server/hapticd",
                    "--scene",
                    root / "server/scenes/finger_soft_grasp.textproto",
                    "--listen",
                    f"unix:{socket}",
                    "--set",
                    "server.metrics_listen=127.0.0.1:0",
                    "--set",
                    f'device[0].board={{ port: "{port}" max_effort: 40 '
                    "max_silence { nanos: 100000000 } }",
                    # Late ticks are counted here; they must not end the run by a fault.
                    "--set",
                    "loop.late_bucket_full=1000000",
                    "--set",
                    "loop.loop_late_fault={nanos: 500000000}",
                    *(("--set", "loop.paced_by=finger") if paced else ()),
                    # The observer's settings of server/demo.sh.
                    "--set",
                    "device[0].passivity.observer.inertia_kg=0.02",
                    "--set",
                    "device[0].passivity.device_damping_n_s_per_m=0.5",
                ],
                server_log,
            ) as server:
                until(
                    "hapticd's start",
                    lambda: socket.exists()
                    and METRICS.search(server_log.read_text())
                    or server.poll() is not None,
                )
                scrapes = METRICS.search(server_log.read_text())
                if scrapes is None or server.poll() is not None:
                    raise Failed("hapticd did not start:\n" + server_log.read_text())
                url = f"http://127.0.0.1:{scrapes[1]}/metrics"
                with running(
                    [programs / "client/haptic-example-soft-grasp", "--server", f"unix:{socket}"],
                    folder / "grasp.log",
                ) as client:
                    time.sleep(SETTLING_S)
                    first = Page(url)
                    time.sleep(seconds)
                    last = Page(url)
                    if client.poll() is not None:
                        raise Failed("the client ended:\n" + (folder / "grasp.log").read_text())
        # Both have ended. The board's own count of drops is the last that hapticd received: once
        # the port is closed every frame is dropped.
        host, board = host_counters(server_log.read_text()), board_counters(
            (folder / "board.log").read_text()
        )
        board["without_room"] = numbers(server_log.read_text().rpartition("link closed")[2])[
            "board_without_room"
        ]
    ages = [(bound, n - before) for (bound, n), (_, before) in zip(last.ages, first.ages)]
    if paced:
        print(
            f"  ticks begun by a sample: {last.paced - first.paced} of {ages[-1][1]}, "
            "the others by the timer"
        )
    return Run(last.at - first.at, last.frames - first.frames, ages, host, board, last.faults)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--programs", type=pathlib.Path, required=True)
    parser.add_argument("--root", type=pathlib.Path, required=True)
    parser.add_argument("--minutes", type=float, default=10.0, help="of each mode")
    parser.add_argument("--mode", choices=MODES, help="one alone")
    parser.add_argument(
        "--paced", action="store_true", help="the board's samples begin the ticks (loop.paced_by)"
    )
    parser.add_argument(
        "--frames-only", action="store_true", help="judge what no busy machine can excuse"
    )
    arguments = parser.parse_args()
    held = True
    for mode, (link_period_ms, target_ms) in MODES.items():
        if arguments.mode not in (None, mode):
            continue
        try:
            seconds = 60 * arguments.minutes
            print(f"{mode}{', paced by the board' if arguments.paced else ''}, {seconds:g} s")
            judged = verdicts(
                run(arguments.programs, arguments.root, link_period_ms, seconds, arguments.paced),
                target_ms,
            )
        except Failed as error:
            print(f"{mode}: {error}")
            return 1
        for verdict in judged:
            print(f"  {verdict}")
        held = held and all(
            v.held for v in judged if v.what.startswith("frames") or not arguments.frames_only
        )
    return 0 if held else 1


if __name__ == "__main__":
    sys.exit(main())
