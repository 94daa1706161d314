"""The suite's own judgement: what must be noticed is noticed, what may be is not; frames and codecs
say what their documents say. Without a daemon, in a second."""

import dataclasses
import pathlib
import re
import shutil
import subprocess
import tempfile
import time
import unittest

import board
import daemon
import frames
from daemon import MB
from judge import (Measured, Tick, failures, judge_ticks, median_interval, read_record, skipped,
                   skips_allowed)
from rows import ROWS
from signals import DIRTY, dirty
from suite import all_rows

HERE = pathlib.Path(__file__).parent
MS = 1_000_000


def pressed(count=300, tau=-3.0):
    """Ticks under a steady force."""
    return [Tick(at=MS * i, seq=i + 1, state="ENGAGED", mode="HELD", faults="", age=0.005, gain=1.0,
                 elastic=tau, tau=tau, skipped=0) for i in range(count)]


def change(ticks, begin, end=None, **fields):
    for i in range(begin, end or len(ticks)):
        ticks[i] = dataclasses.replace(ticks[i], **fields)
    return ticks


def good(**fields):
    return Measured(**{"before": 60 * MB, "owner": 60 * MB, "stops": [0.002] * 20, "realtime": True,
                       "punctual": True, **fields})


class Force(unittest.TestCase):
    def wrong(self, ticks, *causes):
        return judge_ticks(ticks, causes)

    def test_steady_force_is_right(self):
        self.assertEqual(self.wrong(pressed()), ("", []))

    def test_a_step_is_seen(self):
        force, _ = self.wrong(change(pressed(), 100, tau=5.0, elastic=5.0))
        self.assertIn("force changed by 8.00 N", force)

    def test_a_step_within_the_slew_limit_is_right(self):
        self.assertEqual(self.wrong(change(pressed(), 100, tau=-5.4, elastic=-5.4))[0], "")

    def test_force_without_samples_is_seen(self):
        ticks = [dataclasses.replace(t, age=0.005 + 0.001 * i, gain=1.0)
                 for i, t in enumerate(pressed())]
        self.assertIn("at an age of", self.wrong(ticks)[0])
        stuck = change(pressed(), 0, age=0.25, gain=0.0, elastic=0.0, tau=0.0)
        self.assertEqual(self.wrong(stuck)[0], "")
        self.assertTrue(self.wrong(change(stuck, 0, elastic=0.1, tau=0.1))[0])

    def test_a_jumping_gain_is_seen(self):
        ticks = change(pressed(), 0, 100, gain=0.2)
        self.assertIn("gain rose", self.wrong(ticks)[0])

    def test_force_in_a_fault_is_seen(self):
        ticks = change(pressed(), 100, faults="EMERGENCY_STOP", state="FAULT")
        self.assertIn("in a fault", self.wrong(ticks, "EMERGENCY_STOP")[0])

    def test_a_fault_may_take_all_force(self):
        ticks = change(pressed(), 100, faults="EMERGENCY_STOP", state="FAULT", tau=0.0, elastic=0.0,
                       gain=0.0)
        self.assertEqual(self.wrong(ticks, "EMERGENCY_STOP"), ("", []))
        self.assertEqual(self.wrong(ticks), ("", ["EMERGENCY_STOP"]))

    def test_what_is_not_finite_is_seen(self):
        self.assertIn("not finite", self.wrong(change(pressed(), 50, 51, tau=float("nan")))[0])

    def test_a_lost_proxy_is_silence(self):
        ticks = change(pressed(), 100, mode="NONE", elastic=-3.0)
        self.assertEqual(self.wrong(ticks)[0], "")  # it fades from where it is
        ticks = change(pressed(tau=0.0), 100, mode="NONE", elastic=-1.0, tau=-1.0)
        self.assertIn("without a proxy", self.wrong(ticks)[0])

    def test_skipped_deadlines_are_counted(self):
        self.assertEqual(skipped(change(pressed(), 100, 110, skipped=3), 0.0, 0.105), 15)

    def test_half_a_row_is_left_out(self):
        header = ("seq,server_time_ns,state,mode,faults,proxy_age_us,gain,tau_elastic_l_x_n,"
                  "tau_a_l_x_n,skipped")
        row = "1,1000,ENGAGED,HELD,,5000,1,-3,-3,0"
        with tempfile.NamedTemporaryFile("w", suffix=".csv") as file:
            file.write(f"{header}\n{row}\n2,2000,ENG")
            file.flush()
            ticks = read_record(file.name)
        self.assertEqual([(t.seq, t.age, t.tau) for t in ticks], [(1, 0.005, -3.0)])


class Verdict(unittest.TestCase):
    def test_nothing_wrong_is_held(self):
        self.assertEqual(failures(good(owner=60 * MB + MB // 2)), [])

    def test_each_breach_is_seen(self):
        for fields, words in (
                ({"owner": 62 * MB}, "owner grew by 2.0 MB"),
                ({"front": 90 * MB, "front_limit": 80 * MB}, "front has 90 MB"),
                ({"front": 30 * MB}, "front without RLIMIT_DATA"),
                ({"served": None}, "not served again"),
                ({"served": 1.2}, "served again after 1.2 s"),
                ({"unanswered": ["deaf"]}, "1 local stops without answer (deaf)"),
                ({"stops": [0.3] * 20}, "local stop took 300 ms"),
                ({"force": "force changed"}, "force changed"),
                ({"faults": ["LOOP_LATE"]}, "fault LOOP_LATE"),
                ({"regained": None}, "no force again"),
                ({"regained": 4.0}, "force again after 4.0 s"),
                ({"skipped": 40}, "40 deadlines skipped"),
                ({"false_alarm": True}, "taken for one that hangs"),
                ({"term": 5.5}, "SIGTERM took 5.5 s"),
                ({"status": -11}, "hapticd ended with -11"),
                ({"died": "hapticd died, status -11"}, "hapticd died"),
                ({"wrong": ["a thief got it"]}, "a thief got it")):
            self.assertIn(words, "; ".join(failures(good(**fields))), fields)

    def test_deadlines_count_only_in_real_time(self):
        self.assertEqual(failures(good(skipped=400, realtime=False)), [])

    def test_a_busy_host_is_no_finding(self):
        self.assertEqual(failures(good(skipped=110, quiet_skipped=90)), [])
        self.assertLess(skips_allowed(0), 20)


    def test_more_skipped_deadlines_in_all_rows_are_seen(self):
        self.assertGreater(median_interval([1.0, 2.0, 3.0] * 10)[1], 0.0)
        median, low, high = median_interval([-1.0, 0.0, 1.0] * 10)
        self.assertTrue(low <= median <= high and low <= 0.0)

    def test_one_stop_that_took_too_long_is_seen(self):
        for longest, verdict in ((0.049, "held"), (0.051, "FAILED")):
            stops = good(stops=[0.001] * 200 + [longest], punctual=True)
            self.assertEqual([line[5] for line in all_rows([(ROWS[0], stops)])], [verdict])


class Rows(unittest.TestCase):
    def test_names_differ(self):
        names = [row.name for row in ROWS]
        self.assertEqual(len(names), len(set(names)))

    def test_each_finding_and_kind_has_a_row(self):
        findings = {row.finding for row in ROWS}  # "14-20": one of the last ten, without a number
        self.assertEqual({str(i) for i in range(1, 21)} - findings, set())
        kinds = set()
        for row in ROWS:
            first, _, last = row.kind.partition("-")
            if first.isdigit():
                kinds |= set(range(int(first), int(last or first) + 1))
        self.assertEqual(set(range(1, 56)) - kinds, set())
        self.assertIn("new", {row.kind for row in ROWS})

    def test_the_page_lists_every_row(self):
        page = (HERE / "README.md").read_text(encoding="utf-8")
        listed = re.findall(r"^\| `([a-z0-9_]+)` \|", page.split("\n## Rows\n")[1], re.M)
        self.assertEqual(listed, [row.name for row in ROWS])

    def test_each_row_says_what_it_does(self):
        for row in ROWS:
            self.assertTrue(callable(row.attack) and row.expected, row.name)


class Processes(unittest.TestCase):
    def test_a_grandchild_that_faces_the_network_is_found(self):
        with tempfile.TemporaryDirectory() as folder:
            front = pathlib.Path(folder) / "hapticd-front"
            shutil.copy(shutil.which("sleep"), front)
            limit = "ulimit -d 100000; "
            owner = subprocess.Popen(["sh", "-c", f"sh -c '{limit} {front} 60; true'; true"])
            try:
                latest = time.monotonic() + 20.0
                while not daemon.fronts_of(owner.pid) and time.monotonic() < latest:
                    time.sleep(0.01)
                found = daemon.fronts_of(owner.pid)
                self.assertEqual(len(found), 1)
                self.assertEqual(daemon.data_limit(found[0]), 100_000 * 1024)
                self.assertGreater(daemon.resident(found[0]), 0)
            finally:
                daemon.end_all(owner.pid)
                owner.wait()
            latest = time.monotonic() + 20.0
            while daemon.resident(found[0]) and time.monotonic() < latest:
                time.sleep(0.01)
            self.assertEqual(daemon.resident(found[0]), 0)


class Codecs(unittest.TestCase):
    def test_hpack_integers_of_rfc_7541(self):
        self.assertEqual(frames.integer(10, 5), b"\x0a")
        self.assertEqual(frames.integer(1337, 5), b"\x1f\x9a\x0a")
        self.assertEqual(frames.integer(42, 8), b"\x2a")

    def test_a_frame_has_nine_octets_of_header(self):
        self.assertEqual(frames.frame(frames.PING, 0, 0, b"12345678"),
                         b"\0\0\x08\x06\0\0\0\0\0" + b"12345678")

    def test_the_boards_vectors(self):
        page = (HERE.parent.parent / "hw" / "README.md").read_text(encoding="utf-8")
        vectors = re.findall(r"^\w+ ([0-9A-F]{2}) seq (\d+)\n(?:  payload\n((?:    .+\n)+))?"
                             r"  wire\n((?:    .+\n)+)", page, re.M)
        self.assertEqual(len(vectors), 9)
        for kind, seq, payload, wire in vectors:
            payload, wire = bytes.fromhex(payload), bytes.fromhex(wire)
            self.assertEqual(board.frame(int(kind, 16), int(seq), payload), wire)
            self.assertEqual(board.frames(wire), ([(int(kind, 16), int(seq), payload)], b""))

    def test_a_damaged_frame_is_dropped(self):
        wire = bytearray(board.frame(board.ARM, 2, b"abcd"))
        wire[6] ^= 1
        self.assertEqual(board.frames(bytes(wire))[0], [])

    def test_a_dirty_log_is_seen(self):
        self.assertEqual(dirty("2026 info finger: 'süß' €\n".encode()), [])
        self.assertEqual(len(dirty(DIRTY.encode())), 8)


if __name__ == "__main__":
    unittest.main()
