#!/usr/bin/env python3
"""A client that joins while the finger is anywhere, also inside an object, feels the same as one
that was there first.

    joining_test.py HAPTICD SCENE STARTS CLIENT...

A CLIENT is a number and a command, with SERVER for the address. It has a hapticd of its own that
replays SCENE's motion. It runs for two rounds of the motion, and is then started STARTS times at
random moments, for 4 to 6 s and NUMBER. Every tick is recorded. At the same place of the motion the
force must be that of the first run: rms difference at most 1.5 times that among the first run's
rounds and 0.1 N, from NUMBER seconds after force began; and never above 0.3 N if the first run had
none within 0.1 s. A press that the client joins gives back no more energy than the tank began with
(core/METHOD.md#safe-by-default): ticks in which the tank shortens the spring do not count for the
rms difference, if the force is not above the first run's, and are counted apart."""

import bisect
import concurrent.futures
import csv
import math
import pathlib
import random
import shlex
import statistics
import subprocess
import sys
import tempfile
import time

ROUND_S, BIN_S = 20.5, 0.01  # reach_and_grasp.csv, and the pause of a replay
BINS = round(ROUND_S / BIN_S)
NEAR = 10  # bins: samples of the proxy are at most so much earlier or later
FOR_S = 4.0


def run(words, seconds):
    """The client for so long, then killed: no farewell. Its (begin, end) on the steady clock."""
    begin = time.monotonic()
    client = subprocess.Popen(words, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                              stderr=subprocess.DEVNULL)
    time.sleep(seconds)
    if client.poll() is not None:
        raise SystemExit(f"{words} ended with status {client.returncode}")
    client.kill()
    client.wait()
    return begin, time.monotonic()


def read(path):
    """Of every tick with full force: (steady clock, place in the motion as a bin, N, whether the
    tank shortens the spring)."""
    ticks = []
    with open(path, newline="") as file:
        for row in csv.DictReader(file):
            if row["state"] == "ENGAGED" and row["gain"] == "1":
                place = round(float(row["time_s"]) / BIN_S) % BINS
                ticks.append((float(row["server_time_ns"]) * 1e-9, place,
                              float(row["tau_elastic_l_x_n"]),
                              float(row["passivity_scale"]) < 1.0))
    return ticks


def rms(values):
    return math.sqrt(statistics.fmean(v * v for v in values)) if values else 0.0


def compare(ticks, runs, settled):
    """What is wrong with the runs after the first, and a line that says what was measured."""
    times = [tick[0] for tick in ticks]

    def between(begin, end):
        return ticks[bisect.bisect(times, begin):bisect.bisect(times, end)]

    places = [[] for _ in range(BINS)]
    first = between(*runs[0])
    for _, place, force, _ in first:
        places[place].append(force)
    usual = [statistics.median(forces) if forces else None for forces in places]
    touched = [any(abs(f) > 0.05 for n in range(-NEAR, NEAR + 1)
                   for f in places[(place + n) % BINS]) for place in range(BINS)]
    own = rms([force - usual[place] for _, place, force, _ in first])
    wrong, worst, felt, short = [], 0.0, 0, 0
    for number, (begin, end) in enumerate(runs[1:], start=1):
        known = [tick for tick in between(begin, end) if usual[tick[1]] is not None]
        from_then = known[0][0] + settled if known else 0.0
        counted = [(f, usual[p]) for t, p, f, shortened in known if t >= from_then
                   and not (shortened and abs(f) < abs(usual[p]))]
        error = rms([force - by_first for force, by_first in counted])
        alone = max((abs(f) for _, p, f, _ in known if not touched[p]), default=0.0)
        worst, felt = max(worst, error), felt + bool(known)
        short = max(short, sum(t >= from_then for t, *_ in known) - len(counted))
        if error > 1.5 * own + 0.1:
            wrong.append(f"start {number}: rms difference {error:.2f} N")
        if alone > 0.3:
            wrong.append(f"start {number}: {alone:.2f} N outside contact")
    if felt < len(runs[1:]) / 2:
        wrong.append(f"force in {felt} of {len(runs) - 1} starts only")
    return wrong, (f"{len(runs) - 1} starts, {felt} with force; rms difference at most "
                   f"{worst:.3f} N, {own:.3f} N among the rounds of the first run; shortened by "
                   f"the tank for at most {short} ms of a start")


def study(hapticd, scene, starts, client):
    with tempfile.TemporaryDirectory() as folder:
        socket, record = pathlib.Path(folder, "socket"), pathlib.Path(folder, "run.csv")
        settled, *words = shlex.split(client.replace("SERVER", f"unix:{socket}"))
        server = subprocess.Popen(
            [hapticd, "--scene", scene, "--listen", f"unix:{socket}", "--log-level", "warn",
             "--realtime", "off", "--set", f'record.file="{record}"',
             "--set", "loop.late_bucket_full=1000000",
             "--set", "loop.loop_late_fault={seconds: 10}"],
            stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        try:
            while not socket.exists():
                time.sleep(0.02)
            runs = [run(words, 2 * ROUND_S + 2.0)]
            for _ in range(starts):
                time.sleep(random.uniform(2.5, 4.0))  # the lease of the one that was killed ends
                runs.append(run(words, float(settled) + random.uniform(FOR_S, 1.5 * FOR_S)))
        finally:
            server.terminate()
            server.wait()
        return compare(read(record), runs, float(settled))


def main():
    hapticd, scene, starts, *clients = sys.argv[1:]
    with concurrent.futures.ThreadPoolExecutor(len(clients)) as pool:
        answers = list(pool.map(lambda c: study(hapticd, scene, int(starts), c), clients))
    for client, (wrong, said) in zip(clients, answers):
        print(f"{client}\n  {said}", *(f"\n  WRONG: {w}" for w in wrong))
    return any(wrong for wrong, _ in answers)


if __name__ == "__main__":
    sys.exit(main())
