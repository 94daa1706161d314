"""Runs the rows of rows.py: CSV and a table (README.md)."""

import argparse
import contextlib
import csv
import json
import multiprocessing
import os
import resource
import signal
import statistics
import subprocess
import sys
import tempfile
import time
import traceback

import inside
from daemon import MB, STOP, Controller, Daemon, Probe, control, end_all, resident
from frames import served
from judge import (DEADLINES, Measured, failures, judge_ticks, late_stop, losses, median_interval,
                   read_record, skipped)
from rows import ROWS

LEAST_S = 1.5  # of an attack: one that is over sooner is made again
MOST_SENT = 32 * MB  # by an attack that is made again
AGAIN = 6  # pairs of blocks, for a row that skipped deadlines
GIVEN_UP_S = 6.0  # for service or force to come back
SILENT_FRONT = "gave no sign of life"  # hapticd's log, of a front that it takes for one that hangs
COLUMNS = ("row", "kind", "finding", "expected", "got", "verdict", "seconds", "sent_mb",
           "owner_before_mb", "owner_growth_mb", "front_mb", "front_limit_mb", "skipped_quiet",
           "skipped_attack", "force_losses", "served_ms", "force_again_ms", "stops",
           "stop_ms", "sigterm_ms", "notes")


def in_child(work, *arguments):
    """`work` as a process of its own, so that it cannot disturb what is measured here; the process
    and the end of a pipe on which its answer comes."""
    here, there = multiprocessing.Pipe(duplex=False)

    def run():
        here.close()
        signal.signal(signal.SIGTERM, signal.SIG_DFL)
        files = resource.getrlimit(resource.RLIMIT_NOFILE)[1]
        resource.setrlimit(resource.RLIMIT_NOFILE, (min(files, 20_000),) * 2)
        try:
            answer = work(*arguments) or {}
        except Exception:  # noqa: BLE001  what an attack could not do is part of its report
            answer = {"wrong": ["the row itself failed: " +
                                traceback.format_exc(limit=-3).replace("\n", " | ")]}
        there.send(json.dumps(answer))
        there.close()
        os._exit(0)  # sockets close here; what libraries would do at an exit is not wanted

    child = multiprocessing.get_context("fork").Process(target=run)
    child.start()
    there.close()
    return child, here


def answer_of(child, pipe, seconds):
    answer = {}
    with contextlib.suppress(EOFError, OSError):
        if pipe.poll(seconds):
            answer = json.loads(pipe.recv())
        else:
            answer = {"wrong": [f"the row did not end within {seconds:.0f} s"]}
    child.join(0.5 if answer else 0.1)
    if child.is_alive():
        end_all(child.pid)
        child.join()
    return answer


def attacked(row, daemon):
    """The answers of the attack, again and again until it lasted for LEAST_S, as one."""
    whole, began = {"sent": 0, "wrong": [], "notes": [], "silent": False}, time.monotonic()
    while True:
        answer = answer_of(*in_child(row.attack, daemon), row.seconds)
        whole["sent"] += answer.get("sent", 0)
        whole["wrong"] += answer.get("wrong", [])
        whole["notes"] = answer.get("notes", [])
        whole["silent"] |= answer.get("silent", False)
        enough = time.monotonic() > began + LEAST_S or whole["sent"] > MOST_SENT
        if enough or whole["wrong"] or daemon.process.poll() is not None:
            return whole


def back_within(daemon, seconds):
    """How long until both addresses serve a new connection; None: not within `seconds`."""
    began = time.monotonic()
    for address in (daemon.tcp, daemon.unix):
        while not served(address, 0.5):
            if time.monotonic() > began + seconds or daemon.process.poll() is not None:
                return None
    return time.monotonic() - began


def attack(row, folder):
    """One row against a daemon with a controller in contact."""
    m = Measured()
    few = [(resource.RLIMIT_NOFILE, row.descriptors)] if row.descriptors else []
    if row.user is not None:
        few += [(resource.RLIMIT_RTPRIO, 95), (resource.RLIMIT_MEMLOCK, resource.RLIM_INFINITY)]
    daemon = Daemon(folder, *row.options, server=row.server, limits=few, web=row.web,
                    user=row.user,
                    env=inside.environment(folder, row.landlock) if row.inside else None)
    m.realtime = bool(daemon.realtime())
    controller = Controller(daemon.address)
    try:
        if controller.engaged_within(20.0) is None:
            raise RuntimeError("no force before the attack: " + daemon.text()[-1000:])
        time.sleep(0.7)
        quiet = Probe(daemon)
        quiet_began = time.monotonic()
        time.sleep(row.quiet)
        quiet_ended = time.monotonic()
        m.quiet_stops = quiet.end().stops
        m.before = resident(daemon.pid)
        probe = Probe(daemon)
        began = time.monotonic()
        answer = attacked(row, daemon)
        ended = time.monotonic()
        m.served = back_within(daemon, GIVEN_UP_S)
        if probe.unanswered:  # a stop that was given up stops every device
            control(daemon, "--device", "finger", "clear-fault")
        if daemon.process.poll() is None:
            m.regained = controller.engaged_within(GIVEN_UP_S) if row.regains else 0.0
            time.sleep(0.3)
        probe.end()
        m.seconds = ended - began
        m.owner, m.front, m.front_limit = probe.owner, probe.front, probe.front_limit
        m.stops, m.unanswered = probe.stops, probe.unanswered
        m.punctual = probe.punctual and (row.user is None or m.realtime)
        m.wrong, m.notes, m.sent = answer["wrong"], answer["notes"], answer["sent"]
        if daemon.process.poll() is not None:
            m.died = f"hapticd died, status {daemon.process.returncode}"
        controller.kill()
        time.sleep(0.35)  # force is gone by then
        again = in_child(row.attack, daemon) if row.term_under and not m.died else None
        if again:
            time.sleep(0.7)
        m.term, m.status = daemon.stop()
        if again:
            end_all(again[0].pid)
            answer_of(*again, 0.1)
        if not row.regains and m.regained is None:
            m.regained = 0.0
        ticks = read_record(daemon.record)
        m.force, m.faults = judge_ticks(
            ticks, (*row.causes, *(["EMERGENCY_STOP"] if m.unanswered else [])))
        m.quiet_skipped = skipped(ticks, quiet_began, quiet_ended)
        m.quiet_skipped = round(m.quiet_skipped * m.seconds / (quiet_ended - quiet_began))
        m.skipped = skipped(ticks, began, ended)
        m.lost = losses(ticks, began, ended)
        m.false_alarm = not (row.silent or answer["silent"]) and SILENT_FRONT in daemon.text()
    finally:
        controller.kill()
        daemon.kill()
    return m


def alone(row, folder):
    """One row that runs daemons of its own."""
    m = Measured(alone=True)
    began = time.monotonic()
    answer = answer_of(*in_child(row.attack, folder), row.seconds)
    m.seconds = time.monotonic() - began
    m.wrong, m.notes, m.sent = (answer.get("wrong", []), answer.get("notes", []),
                                answer.get("sent", 0))
    return m


def confirmed(row, m, found):
    """`found` without the deadlines that one block skipped, unless blocks with the attack skip more
    than blocks without one, in turns: one stall of the host tells nothing of the attack."""
    pairs = []
    for _ in range(AGAIN):
        with tempfile.TemporaryDirectory(prefix="haptic-hostile-") as folder:
            os.chmod(folder, 0o755)
            again = attack(row, folder)
        pairs.append((again.skipped - again.quiet_skipped) / again.seconds)
    median, low, high = median_interval(pairs)
    m.notes.append(f"again {AGAIN} pairs of blocks: {median:+.2f} [{low:+.2f}, {high:+.2f}] "
                   "deadlines per second more")
    return found if low > 0.0 else [words for words in found if DEADLINES not in words]


def run_row(row):
    with tempfile.TemporaryDirectory(prefix="haptic-hostile-") as folder:
        os.chmod(folder, 0o755)
        try:
            m = (alone if row.alone else attack)(row, folder)
        except (OSError, RuntimeError) as error:
            m = Measured(alone=True, wrong=[f"the row did not run: {error}"])
    found = failures(m, row.grows)
    if any(DEADLINES in words for words in found):
        found = confirmed(row, m, found)
    if row.must_fail:
        if any(row.must_fail in words for words in found):
            m.notes.append("seen: " + "; ".join(found))
            found = []
        else:
            found = ["the suite did not see what this row does, only: " + "; ".join(found)]
    return m, found


def cells(row, m, found):
    def mb(value):
        return f"{value / MB:.1f}" if value else ""

    def ms(value):
        return "never" if value is None else f"{1e3 * value:.0f}"
    skipped_row = any(note.startswith("not on this host") for note in m.notes)
    verdict = "FAILED" if found else "skipped" if skipped_row else "held"
    got = "; ".join(found) or "; ".join(m.notes) or "nothing of the kind"
    measured = ["", "", "", "", "", "", "", "", "", "", "", ""] if m.alone else [
        mb(m.before), f"{m.growth_mb:.1f}", mb(m.front), mb(m.front_limit),
        str(m.quiet_skipped) if m.realtime else "", str(m.skipped) if m.realtime else "",
        str(m.lost), ms(m.served), ms(m.regained), str(len(m.stops)), ms(late_stop(m.stops)),
        ms(m.term)]
    return [row.name, row.kind, row.finding, row.expected, got, verdict, f"{m.seconds:.1f}",
            mb(m.sent), *measured, "; ".join(m.notes)]


FEWEST_PAIRS = 20  # alternating blocks with and without an attack


def all_rows(measured):
    """What only many rows together can say: deadlines skipped with and without an attack, and the
    local stop. As a line of the table each."""
    pairs = [(m.skipped - m.quiet_skipped) / m.seconds for row, m in measured
             if m.realtime and m.seconds and not row.must_fail]
    lines = []

    def line(name, expected, got, verdict):
        lines.append([name, "", "", expected, got, verdict, *[""] * (len(COLUMNS) - 6)])
    if len(pairs) >= FEWEST_PAIRS:
        median, low, high = median_interval(pairs)
        line("all_deadlines", "as many skipped as without attacks",
             f"{median:+.2f} [{low:+.2f}, {high:+.2f}] per second more, {len(pairs)} pairs",
             "FAILED" if low > 0.0 else "held")
    stops = [stop for row, m in measured if m.punctual and not row.must_fail for stop in m.stops]
    if len(stops) >= 100:
        late, longest = late_stop(stops), max(stops)
        line("all_stops", f"p{100 * STOP.share:.0f} at most {1e3 * STOP.limit_s:.0f} ms, each at "
             f"most {1e3 * STOP.longest_s:.0f}",
             f"p50 {1e3 * statistics.median(stops):.1f}, p{100 * STOP.share:.0f} "
             f"{1e3 * late:.1f}, longest {1e3 * longest:.1f} ms of {len(stops)}",
             "FAILED" if late > STOP.limit_s or longest > STOP.longest_s else "held")
    return lines


def table(lines):
    """The rows for people."""
    head = ("row", "verdict", "owner +MB", "front MB", "skipped", "served ms", "stop ms", "got")
    text = [head]
    for line in lines:
        c = dict(zip(COLUMNS, line))
        late = f"{c['skipped_attack']}/{c['skipped_quiet']}" if c["skipped_attack"] else ""
        text.append((c["row"], c["verdict"], c["owner_growth_mb"], c["front_mb"], late,
                     c["served_ms"], c["stop_ms"], c["got"]))
    widths = [max(len(line[i]) for line in text) for i in range(len(head) - 1)]
    return "\n".join("  ".join([*(cell.ljust(w) for cell, w in zip(line, widths)),
                                line[-1][:160]]) for line in text)


@contextlib.contextmanager
def hogs(count):
    """So many processes that compute."""
    running = [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(count)]
    try:
        yield
    finally:
        for hog in running:
            hog.kill()
            hog.wait()


def ended(*_):
    """A row leaves nothing behind, also if it is interrupted."""
    end_all(os.getpid(), itself=False)
    os._exit(1)


def main():
    parser = argparse.ArgumentParser(prog="tests/hostile/run.sh", description=__doc__)
    parser.add_argument("--row", action="append", help="only this row, or rows that begin so and "
                        "end with '*'; may be repeated")
    parser.add_argument("--hogs", action="store_true", help="next to two processes that compute")
    parser.add_argument("--repeat", type=int, default=1, help="run everything so often")
    parser.add_argument("--out", default="hostile.csv", help="the CSV")
    parser.add_argument("--list", action="store_true", help="print the rows and end")
    options = parser.parse_args()
    wanted = [row for row in ROWS if not options.row or any(
        row.name == name or (name.endswith("*") and row.name.startswith(name[:-1]))
        for name in options.row)]
    if options.list:
        print("\n".join(f"{row.name}: {row.expected}" for row in wanted))
        return 0
    if not wanted:
        print("no such row; --list shows them", file=sys.stderr)
        return 2
    signal.signal(signal.SIGTERM, ended)
    signal.signal(signal.SIGINT, ended)
    lines, measured = [], []
    with hogs(2 if options.hogs else 0), open(options.out, "w", newline="") as out:
        writer = csv.writer(out, lineterminator="\n")
        writer.writerow(COLUMNS)
        for _ in range(options.repeat):
            for row in wanted:
                m, found = run_row(row)
                measured.append((row, m))
                lines.append(cells(row, m, found))
                writer.writerow(lines[-1])
                out.flush()
                print(f"{lines[-1][5]:7} {row.name}: {lines[-1][4][:200]}", flush=True)
        together = all_rows(measured)
        lines += together
        writer.writerows(together)
    print("\n" + table(lines))
    verdicts = [line[5] for line in lines]
    print(f"\n{verdicts.count('held')} held, {verdicts.count('FAILED')} failed, "
          f"{verdicts.count('skipped')} skipped; {options.out}")
    return 1 if "FAILED" in verdicts else 0


if __name__ == "__main__":
    sys.exit(main())
