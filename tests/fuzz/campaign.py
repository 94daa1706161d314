#!/usr/bin/env python3
"""Runs a libFuzzer program for a number of executions, in slices, and can go on where it stopped.

    campaign.py PROGRAM CORPUS RECORD.csv EXECUTIONS [MAX_LEN [DICTIONARY]]

DICTIONARY has words for libFuzzer to insert. RECORD.csv has a line per slice: executions and
seconds of processor time so far, covered edges, features, files of the corpus. A run that was ended
goes on after its last line; a run that has its executions does nothing but report. The report, on
standard output, says also what the last tenth of the executions found that was new. Exit status 1
at a finding, whose input is in CORPUS as crash-* or timeout-*, and 3 if the last tenth still found
new edges."""

import csv
import os
import pathlib
import re
import resource
import subprocess
import sys

COLUMNS = ("executions", "seconds", "edges", "features", "corpus")
SLICE_S = 300  # what an interruption may lose
TIMED_OUT = 70  # libFuzzer's exit status
SLOW_S = 20  # of processor time for one input, and it is a finding


def read(record):
    if not record.exists():
        return []
    with open(record, newline="") as file:
        return [{name: float(row[name]) for name in COLUMNS} for row in csv.DictReader(file)]


def at(rows, executions):
    """The newest line that was written at so many executions or before."""
    before = [row for row in rows if row["executions"] <= executions]
    return before[-1] if before else dict.fromkeys(COLUMNS, 0.0)


def report(name, rows, wanted):
    """(what the campaign reached in one line, whether its last tenth found new edges)."""
    last = rows[-1]
    before = at(rows, 0.9 * last["executions"])
    edges, features = (int(last[k] - before[k]) for k in ("edges", "features"))
    text = (f"{name}: {last['executions']:.3g} of {wanted:.3g} executions in "
            f"{last['seconds'] / 3600:.2f} h of a processor, corpus {last['corpus']:.0f}, edges "
            f"{last['edges']:.0f}, features {last['features']:.0f}; in the last tenth "
            f"{max(edges, 0)} new edges, {max(features, 0)} new features")
    return text, edges > 0


def processor_s():
    spent = resource.getrusage(resource.RUSAGE_CHILDREN)
    return spent.ru_utime + spent.ru_stime


def run(program, *arguments):
    # The sanitizers' defaults keep 256 MB of freed memory and 30 frames of each allocation's stack,
    # which costs a third of the executions. Inputs are kept for the edges that they reach, not for
    # how often: the corpus is a fifth, and there are 2 to 4 times as many executions per second.
    # Without weights by rare edges, and inputs that are made shorter, there are 1.3 times as many.
    environment = {"ASAN_OPTIONS": "quarantine_size_mb=16:malloc_context_size=1", **os.environ}
    return subprocess.run([program, "-timeout=300", "-report_slow_units=300", "-rss_limit_mb=2048",
                           "-use_counters=0", "-entropic=0", "-reduce_inputs=0", *arguments],
                          stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, text=True,
                          stderr=subprocess.STDOUT, errors="replace", env=environment)


def is_finding(program, path):
    """Whether one input fails alone, or takes long by processor time: libFuzzer's own clock runs on
    while the host is busy, or the program stopped."""
    before = processor_s()
    status = run(program, str(path)).returncode
    return status not in (0, TIMED_OUT) or processor_s() - before > SLOW_S


def run_slice(program, corpus, executions, longest, more):
    """Executions, edges, features, corpus; None at a finding; empty if it did not get far."""
    done = run(program, str(corpus), f"-artifact_prefix={corpus}/", f"-runs={executions}",
               f"-max_total_time={SLICE_S}", f"-max_len={longest}", "-print_final_stats=1",
               *more)
    if done.returncode == TIMED_OUT:
        for path in corpus.glob("timeout-*"):
            if is_finding(program, path):
                break
            path.unlink()
        else:
            done.returncode = 0
    ran = re.search(r"stat::number_of_executed_units: (\d+)", done.stdout)
    status = re.findall(r"^#\d+\s+\w+\s+cov: (\d+) ft: (\d+) corp: (\d+)", done.stdout, re.M)
    if done.returncode != 0 or ran is None:
        print(done.stdout[-4000:], file=sys.stderr)
        return None
    return (int(ran.group(1)), *map(int, status[-1])) if status else ()


def main():
    if len(sys.argv) < 5:
        print(__doc__)
        return 2
    program, corpus, record = sys.argv[1], pathlib.Path(sys.argv[2]), pathlib.Path(sys.argv[3])
    wanted, longest = int(float(sys.argv[4])), int(sys.argv[5]) if len(sys.argv) > 5 else 16384
    more = [f"-dict={path}" for path in sys.argv[6:]]
    corpus.mkdir(parents=True, exist_ok=True)
    rows = read(record)
    while not rows or rows[-1]["executions"] < wanted:
        so_far = rows[-1] if rows else dict.fromkeys(COLUMNS, 0.0)
        began = processor_s()
        found = run_slice(program, corpus, wanted - int(so_far["executions"]), longest,
                          more)
        if found is None:
            print(f"{corpus.name}: a finding after {so_far['executions']:.3g} executions; "
                  f"its input is in {corpus}")
            return 1
        if not found:
            continue
        executions, edges, features, files = found
        rows.append(dict(zip(COLUMNS, (so_far["executions"] + executions,
                                       so_far["seconds"] + processor_s() - began, edges,
                                       features, files))))
        new = not record.exists()
        with open(record, "a", newline="") as file:
            writer = csv.DictWriter(file, COLUMNS)
            if new:
                writer.writeheader()
            writer.writerow({name: round(value, 1) for name, value in rows[-1].items()})
        print(report(corpus.name, rows, wanted)[0], file=sys.stderr)
    text, grows = report(corpus.name, rows, wanted)
    print(text)
    return 3 if grows else 0


if __name__ == "__main__":
    sys.exit(main())
