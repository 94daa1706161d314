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
import subprocess
import sys
import tempfile

from served import Failed, Page, between, running, soft_grasp
from soak_verdict import Second, verdicts
from verdict import quantile

SETTLING_S = 10
MISSED = "haptic_loop_skipped_deadlines_total"


def resident(page: Page) -> float:
    return sum(
        page.value("process_resident_memory_bytes", f'process="{process}"')
        for process in ("owner", "front")
    )


def p99_us(before: Page, after: Page) -> float:
    """p99 of the lateness between two readings; beyond the last finite bound: that bound."""
    buckets = between(before, after, "haptic_loop_lateness_seconds")
    return 1e6 * min(quantile(buckets, 0.99), buckets[-2][0])


def by_udp_s(page: Page) -> float:
    return page.value("haptic_carrier_seconds_total", '.*carrier="udp".*')


def run(programs: pathlib.Path, scene: pathlib.Path, seconds: int) -> tuple[list[Second], float]:
    """The seconds after settling; and the share of them in which UDP led the samples."""
    rows = []
    bare_loop = [programs / "tests/bench/haptic-bare-loop", SETTLING_S + seconds]
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        with soft_grasp(
            programs,
            scene,
            folder,
            "server.udp_listen=127.0.0.1:0",
            "loop.loop_late_fault={seconds: 10}",
        ) as url, running(bare_loop, folder / "bare.log", subprocess.PIPE) as bare:
            assert bare.stdout is not None
            before = first = Page(url)
            for i, line in enumerate(bare.stdout):  # a line a second: the clock of this loop
                bare_missed, bare_p99 = line.split(b",")
                now = Page(url)
                if i == SETTLING_S:
                    first = before
                if i >= SETTLING_S:
                    rows.append(
                        Second(
                            resident(now),
                            int(now.value(MISSED) - before.value(MISSED)),
                            p99_us(before, now),
                            int(bare_missed),
                            float(bare_p99),
                        )
                    )
                before = now
    return rows, (by_udp_s(before) - by_udp_s(first)) / max(len(rows), 1)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--programs", type=pathlib.Path, required=True)
    parser.add_argument("--scene", type=pathlib.Path, required=True)
    parser.add_argument("--minutes", type=float, default=30.0)
    parser.add_argument("--csv", help="where every second goes")
    arguments = parser.parse_args()
    try:
        rows, udp = run(arguments.programs, arguments.scene, max(int(arguments.minutes * 60), 20))
    except Failed as error:
        sys.exit(f"soak.py: {error}")
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
