"""The role tracker against a running hapticd: poses, their age, and what other clients see."""

import csv
import json
import math
import os
import pathlib
import subprocess
import sys
import tempfile
import time
import unittest
from collections.abc import Callable

import haptic
from hapticd_process import eventually
from one_server import OneServer

TURN = 0.4  # rad about z
POSE = haptic.Pose((0.1, -0.2, 0.3), (0.0, 0.0, math.sin(TURN / 2), math.cos(TURN / 2)))
PALM = (0.1, -0.2, 0.3, 0.0, 0.0, TURN)  # the same as position and rotation vector
PATIENCE_S = 20.0
EXAMPLES = os.path.join(os.environ["HAPTIC_SCENES"], "../../client/python/examples")


class OnATrackedPalm(OneServer):
    scene = "chain_on_tracked_palm"

    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.recording = pathlib.Path(folder.name, "recording.csv")
        self.settings = (f'record.file="{self.recording}"',)
        super().setUp()

    def while_told(self, session: haptic.Session, tracker: haptic.Session,
                   until: Callable[[haptic.DeviceState], bool]) -> haptic.DeviceState:
        return self.hold(session, until, lambda: tracker.publish_pose(POSE))

    def hapticctl(self, *arguments: str) -> str:
        command = [os.environ["HAPTICCTL"], "--server", self.server.address, *arguments]
        return subprocess.run(command, check=True, capture_output=True, text=True,
                              timeout=60).stdout


class Poses(OnATrackedPalm):
    def test_the_palm_follows_the_tracker(self) -> None:
        session = self.open(client_name="simulation")
        before = session.wait_for_state().tracker
        assert before is not None
        self.assertEqual((before.seq_used, before.staleness), (0, "LOST"))
        tracker = self.open(tracker=True, client_name="camera")
        self.assertFalse(tracker.statistics().udp_in_use)
        state = self.while_told(session, tracker, lambda s: s.tracker.staleness == "FRESH")
        for q, wanted in zip(state.q, PALM):
            self.assertAlmostEqual(q, wanted, places=9)
        self.assertLessEqual(state.tracker.seq_used, tracker.statistics().published)
        self.assertLess(state.tracker.age_s, 0.1)

    def test_the_example_plays_a_recording(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            recording = pathlib.Path(folder, "palm.csv")
            row = ",".join(str(value) for value in PALM)
            recording.write_text("time_s,palm.x,palm.y,palm.z,palm.rx,palm.ry,palm.rz\n"
                                 f"0,{row}\n1,{row}\n")
            session = self.open(client_name="simulation")
            example = subprocess.Popen(
                [sys.executable, os.path.join(EXAMPLES, "palm.py"), str(recording), "--server",
                 self.server.address, "--seconds", "30"])
            try:
                state = self.hold(session, lambda s: s.tracker.staleness == "FRESH", lambda: None)
            finally:
                example.terminate()
                example.wait(PATIENCE_S)
            for q, wanted in zip(state.q, PALM):
                self.assertAlmostEqual(q, wanted, places=9)

    def test_a_silent_tracker_grows_old(self) -> None:
        session = self.open(client_name="simulation")
        tracker = self.open(tracker=True, client_name="camera")
        tracker.publish_pose(POSE)
        self.assertTrue(eventually(lambda: session.wait_for_state().tracker.seq_used > 0))
        self.assertTrue(eventually(lambda: session.state.tracker.staleness == "LOST"))
        state = session.wait_for_state()
        self.assertGreaterEqual(state.tracker.age_s, 0.18)
        self.assertAlmostEqual(state.q[0], PALM[0], places=9)  # held, not forgotten

    def test_force_needs_it(self) -> None:
        session = self.open(client_name="simulation")
        tracker = self.open(tracker=True, client_name="camera")
        session.engage_when_ready()
        self.while_told(session, tracker, lambda s: s.state == "ENGAGED")
        latest = time.monotonic() + PATIENCE_S
        place = session.wait_for_state().x
        events: list[haptic.Event] = []
        # The proxies go on, the poses do not.
        while not any(e.reason == "TRACKER_LOST" for e in events):
            session.publish(haptic.held(place))
            state = session.wait_for_state()
            events += session.events()
            self.assertLess(time.monotonic(), latest, state)
        self.assertEqual(session.wait_for_state().tau_elastic, (0.0, 0.0))

    def test_an_impossible_pose_is_counted(self) -> None:
        tracker = self.open(tracker=True, client_name="camera")
        tracker.publish_pose(haptic.Pose((5.0, 0.0, 0.0)))
        self.assertTrue(eventually(lambda: tracker.statistics().rejected_invalid > 0))
        self.assertIn("position", tracker.statistics().last_rejection)


class Role(OnATrackedPalm):
    def test_it_publishes_poses_and_nothing_else(self) -> None:
        device, = self.connection.devices()
        self.assertEqual((device.wants_tracker, device.tracker), (True, ""))
        tracker = self.open(tracker=True, client_name="camera")
        device, = self.connection.devices()
        self.assertEqual((device.tracker, device.controller), ("camera", ""))
        with self.assertRaises(haptic.ClientError) as refused:
            self.open(tracker=True, client_name="another camera")
        self.assertEqual(refused.exception.reason, "TRACKER_HELD")
        self.assertIn("camera", str(refused.exception))
        with self.assertRaises(haptic.ClientError) as refused:
            tracker.engage()
        self.assertEqual(refused.exception.reason, "NOT_CONTROLLER")
        with self.assertRaises(haptic.ClientError) as refused:
            tracker.publish(haptic.FREE)
        self.assertIn("publishes poses", str(refused.exception))
        with self.assertRaises(haptic.ClientError) as refused:
            self.open(client_name="simulation").publish_pose(POSE)
        self.assertIn("`tracker`", str(refused.exception))

    def test_it_is_not_an_observer_too(self) -> None:
        with self.assertRaises(haptic.ClientError) as refused:
            self.open(observer=True, tracker=True, client_name="both")
        self.assertEqual(refused.exception.reason, "INVALID_ARGUMENT")


class Seen(OnATrackedPalm):
    def test_hapticctl_and_recording_name_it(self) -> None:
        self.assertIn("palm by a tracker: none", self.hapticctl("info"))
        session = self.open(client_name="simulation")
        tracker = self.open(tracker=True, client_name="camera")
        self.while_told(session, tracker, lambda s: s.tracker.seq_used > 3)
        self.assertIn("palm by a tracker: camera", self.hapticctl("info"))
        device, = json.loads(self.hapticctl("info", "--json"))["devices"]
        self.assertEqual((device["wants_tracker"], device["tracker"]), (True, "camera"))
        last = self.hapticctl("watch", "--json", "--seconds", "1").splitlines()[-1]
        told = json.loads(last)["tracker"]
        self.assertEqual(told["staleness"], "LOST")  # nobody publishes while this test reads
        self.assertGreater(told["seq_used"], 3)
        self.assertGreater(told["age_us"], 180000)
        line = self.hapticctl("watch", "--seconds", "1").splitlines()[-1]
        self.assertRegex(line, r"  pose LOST, age \d")

        self.assertTrue(eventually(
            lambda: any(row["tracker_staleness"] == "FRESH" for row in self.rows())))
        rows = self.rows()
        first = [rows[0]["tracker_" + name] for name in ("seq_used", "age_us", "staleness")]
        self.assertEqual(first, ["0", "0", "LOST"])
        fresh = next(row for row in rows if row["tracker_staleness"] == "FRESH")
        self.assertGreater(int(fresh["tracker_seq_used"]), 0)
        self.assertLess(float(fresh["tracker_age_us"]), 100e3)
        for name, wanted in zip(("x", "y", "z", "rx", "ry", "rz"), PALM):
            self.assertAlmostEqual(float(fresh["palm." + name]), wanted, places=9)

    def rows(self) -> list[dict[str, str]]:
        lines = self.recording.read_text().splitlines()
        return list(csv.DictReader(lines[:-1]))  # the last one may be half written


if __name__ == "__main__":
    unittest.main()
