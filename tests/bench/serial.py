#!/usr/bin/env python3
"""The serial link as a whole, by the counters of its two ends.

    serial.py --programs BUILD --root SOURCES [--minutes 10] [--mode streaming|500hz] [--paced]

haptic-board-emulator on a pseudo-terminal, its user moved by the motion that ships; hapticd on it;
the soft grasp as its client. Rates and ages are of the time after settling; frames of the whole
run, as both ends say when they close: hapticd in its log, the emulator on standard error. Judged by
serial_verdict.py.
"""

import argparse
import pathlib
import re
import sys
import tempfile
import time

from serial_verdict import Run, verdicts
from served import Failed, Page, between, running, soft_grasp, until

SETTLING_S = 5.0
MODES = {"streaming": ("0", 2.0), "500hz": ("2", 4.0)}  # link period in ms, target of p99 in ms
PACED = "haptic_loop_sample_paced_ticks_total"


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
        port = folder / "board"
        emulator = [programs / "hw/haptic-board-emulator", "--link", port, "--watchdog-ms", 1000]
        emulator += ["--link-period-ms", link_period_ms]
        emulator += ["--motion", root / "server/scenes/motion/reach_and_grasp.csv"]
        settings = (
            f'device[0].board={{ port: "{port}" max_effort: 40 '
            "max_silence { nanos: 100000000 } }",
            "loop.loop_late_fault={nanos: 500000000}",
            *(("loop.paced_by=finger",) if paced else ()),
            # The observer's settings of server/demo.sh.
            "device[0].passivity.observer.inertia_kg=0.02",
            "device[0].passivity.device_damping_n_s_per_m=0.5",
        )
        with running(emulator, folder / "board.log"):
            until("the emulator's port", port.exists)
            scene = root / "server/scenes/finger_soft_grasp.textproto"
            with soft_grasp(programs, scene, folder, *settings) as url:
                time.sleep(SETTLING_S)
                first = Page(url)
                time.sleep(seconds)
                last = Page(url)
        # Both have ended. The board's own count of drops is the last that hapticd received: once
        # the port is closed every frame is dropped.
        log = (folder / "hapticd.log").read_text()
        host, board = host_counters(log), board_counters((folder / "board.log").read_text())
        board["without_room"] = numbers(log.rpartition("link closed")[2])["board_without_room"]
    ages = between(first, last, "haptic_device_sample_age_seconds")
    if paced:
        begun = last.value(PACED, ".*") - first.value(PACED, ".*")
        print(f"  ticks begun by a sample: {begun:.0f} of {ages[-1][1]}, the others by the timer")
    received = [
        int(page.value("haptic_link_frames_total", '.*end="host",what="received"'))
        for page in (first, last)
    ]
    faults = {fault: int(n) for fault, n in last.by_label("haptic_faults_total", "fault")}
    return Run(last.at - first.at, received[1] - received[0], ages, host, board, faults)


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
