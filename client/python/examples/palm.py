#!/usr/bin/env python3
"""A tracker of the palm that plays a recording.

It is what a camera would be, for a scene with `tracker {}`: a session of its own that publishes
the palm's pose. The recording is a CSV of poses in the world, columns time_s, palm.x, palm.y,
palm.z in m and palm.rx, palm.ry, palm.rz, a rotation vector in rad; other columns are left alone.
Between two rows it moves so that it rests at each. It is played by the device's own clock, the
number of the tick, so that it stays beside fingers that play the same file.
"""

import argparse
import csv
import math
from collections.abc import Sequence

import haptic

RATE_HZ = 120
BACK_S = 0.5  # from the last row to the first
TICK_S = 1e-3
COLUMNS = ("palm.x", "palm.y", "palm.z", "palm.rx", "palm.ry", "palm.rz")


def at(t: float, times: Sequence[float], rows: Sequence[Sequence[float]]) -> list[float]:
    t %= times[-1] + BACK_S
    k = sum(1 for time in times if time <= t) - 1
    end, target = (times[k + 1], rows[k + 1]) if k + 1 < len(rows) else (times[k] + BACK_S, rows[0])
    s = (t - times[k]) / (end - times[k])
    s = s * s * s * (10.0 - 15.0 * s + 6.0 * s * s)
    return [a + s * (b - a) for a, b in zip(rows[k], target, strict=True)]


def quaternion(vector: Sequence[float]) -> tuple[float, float, float, float]:
    angle = math.hypot(*vector)
    scale = math.sin(0.5 * angle) / angle if angle > 0.0 else 0.5
    return (scale * vector[0], scale * vector[1], scale * vector[2], math.cos(0.5 * angle))


parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
parser.add_argument("recording",
                    help="such as server/scenes/motion/hand_touch_stroke_grasp.csv")
parser.add_argument("--server", default=haptic.DEFAULT_SERVER, help="host:port or unix:/path")
parser.add_argument("--seconds", type=float, default=math.inf)
arguments = parser.parse_args()

with open(arguments.recording, newline="") as file:
    table = list(csv.DictReader(file))
times = [float(row["time_s"]) for row in table]
poses = [[float(row[name]) for name in COLUMNS] for row in table]

with haptic.Connection(arguments.server) as server:
    with server.session(tracker=True, client_name="palm.py", nominal_rate_hz=RATE_HZ) as tracker:
        begun = None
        while True:
            now = TICK_S * tracker.wait_for_state().seq
            begun = now if begun is None else begun
            if now - begun > arguments.seconds:
                break
            pose = at(now, times, poses)
            tracker.publish_pose(haptic.Pose(tuple(pose[:3]), quaternion(pose[3:])))
