#!/usr/bin/env python3
"""The soak: hapticd under a client for as long as is asked, by its own metrics, and a bare loop
beside it.

    soak.py --programs BUILD --scene FILE [--minutes 30] [--csv FILE]

A hapticd with the soft grasp over UDP as its client; at the same time, on the same machine and with
the same wishes of real time, haptic-bare-loop: nothing but clock_nanosleep. A row a second:
resident memory, ticks, missed deadlines and p99 of the lateness within that second. The first
seconds, until everything is mapped, do not count. Judged by soak_verdict.py. Ends with 0 where all
holds, 1 where not. Run it on a machine that does nothing else.
"""

import argparse
import csv
import dataclasses
import pathlib
import re
import subprocess
import sys
import tempfile
import time
import urllib.request

from soak_verdict import Second, verdicts

SETTLING_S = 10
BUCKET = re.compile(r'^haptic_loop_lateness_seconds_bucket\{le="([^"]+)"\} (\S+)$', re.M)


@dataclasses.dataclass
class Reading:
    ticks: float
    missed: float
    resident: float
    by_udp_s: float
    lateness: list[tuple[float, float]]  # (upper bound in s, ticks so far up to it)


def read(url: str) -> Reading:
    with urllib.request.urlopen(url, timeout=10) as answer:
        page = answer.read().decode()

    def value(name: str, labels: str = "") -> float:
        found = re.search(rf"^{name}(?:\{{{labels}\}})? (\S+)$", page, re.M)
        if found is None:
            sys.exit(f"soak.py: no {name} in the metrics")
        return float(found[1])

    return Reading(
        value("haptic_loop_ticks_total"),
        value("haptic_loop_skipped_deadlines_total"),
        value("process_resident_memory_bytes", 'process="owner"')
        + value("process_resident_memory_bytes", 'process="front"'),
        value("haptic_carrier_seconds_total", '.*carrier="udp".*'),
        [(float(bound), float(n)) for bound, n in BUCKET.findall(page)],
    )


def p99_us(before: Reading, after: Reading) -> float:
    """p99 of the lateness between two readings, linear within a bucket; beyond the last finite
    bound: that bound."""
    grown = [(bound, n - m) for (bound, n), (_, m) in zip(after.lateness, before.lateness)]
    wanted = 0.99 * grown[-1][1]
    low_bound = low_count = 0.0
    for bound, count in grown:
        if count >= wanted and bound != float("inf"):
            share = (wanted - low_count) / (count - low_count) if count > low_count else 0.0
            return 1e6 * (low_bound + share * (bound - low_bound))
        if bound != float("inf"):
            low_bound, low_count = bound, count
    return 1e6 * low_bound


def started(programs: pathlib.Path, scene: str, folder: str) -> tuple[subprocess.Popen, str]:
    """hapticd and the address of its metrics."""
    log = open(f"{folder}/hapticd.log", "w+", encoding="utf-8")
    server = subprocess.Popen(
        [
            programs / "server/hapticd",
            "--scene",
            scene,
            "--listen",
            f"unix:{folder}/socket",
            "--set",
            "server.metrics_listen=127.0.0.1:0",
            "--set",
            "server.udp_listen=127.0.0.1:0",
            # Late ticks are counted here; they must not end the run by a fault.
            "--set",
            "loop.late_bucket_full=1000000",
            "--set",
            "loop.loop_late_fault={seconds: 10}",
        ],
        stderr=log,
    )
    latest = time.monotonic() + 60
    while time.monotonic() < latest and server.poll() is None:
        text = pathlib.Path(log.name).read_text(encoding="utf-8")
        found = re.search(r"metrics on port (\d+)", text)
        if found and pathlib.Path(folder, "socket").exists():
            return server, f"http://127.0.0.1:{found[1]}/metrics"
        time.sleep(0.1)
    sys.exit(
        "soak.py: hapticd did not start:\n" + pathlib.Path(log.name).read_text(encoding="utf-8")
    )


def run(programs: pathlib.Path, scene: str, seconds: int) -> tuple[list[Second], float]:
    """The seconds after settling; and the share of them in which UDP led the samples."""
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        server, url = started(programs, scene, folder)
        client = subprocess.Popen(
            [programs / "client/haptic-example-soft-grasp", "--server", f"unix:{folder}/socket"],
            stdout=subprocess.DEVNULL,
        )
        bare = subprocess.Popen(
            [programs / "tests/bench/haptic-bare-loop", str(SETTLING_S + seconds)],
            stdout=subprocess.PIPE,
            text=True,
        )
        try:
            before = first = read(url)
            for i, line in enumerate(bare.stdout):  # a line a second: the clock of this loop
                bare_missed, bare_p99 = line.split(",")
                now = read(url)
                if i == SETTLING_S:
                    first = before
                if i >= SETTLING_S:
                    rows.append(
                        Second(
                            now.resident,
                            int(now.missed - before.missed),
                            p99_us(before, now),
                            int(bare_missed),
                            float(bare_p99),
                        )
                    )
                before = now
            if client.poll() is not None:
                sys.exit(f"soak.py: the client ended with {client.returncode}")
            udp = (before.by_udp_s - first.by_udp_s) / max(len(rows), 1)
        finally:
            for process in (client, bare, server):
                process.terminate()
                process.wait(timeout=30)
    return rows, udp


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--programs", type=pathlib.Path, required=True)
    parser.add_argument("--scene", required=True)
    parser.add_argument("--minutes", type=float, default=30.0)
    parser.add_argument("--csv", help="where every second goes")
    arguments = parser.parse_args()
    rows, udp = run(arguments.programs, arguments.scene, max(int(arguments.minutes * 60), 20))
    if arguments.csv:
        with open(arguments.csv, "w", newline="", encoding="utf-8") as file:
            table = csv.writer(file)
            table.writerow(field.name for field in dataclasses.fields(Second))
            table.writerows(map(dataclasses.astuple, rows))
    print(f"{len(rows)} s, samples by UDP in {udp:.1%} of them")
    judged = verdicts(rows)
    for verdict in judged:
        print(verdict)
    return 0 if all(v.held for v in judged) else 1


if __name__ == "__main__":
    sys.exit(main())
