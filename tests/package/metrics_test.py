#!/usr/bin/env python3
"""The metrics of a running hapticd: Prometheus' own opinion of them, and whether they tell what
happened.

    metrics_test.py HAPTICD HAPTICCTL SCENE README

77: promtool (Debian's prometheus) is not there.
"""
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
import unittest
import urllib.error
import urllib.request

HAPTICD, HAPTICCTL, SCENE, README = sys.argv[1:5]
SAMPLE = re.compile(r"^([a-z_]+)(?:\{(.*)\})? (\S+)$")


def parse(page: str) -> dict[tuple[str, str], float]:
    return {(m[1], m[2] or ""): float(m[3]) for m in map(SAMPLE.match, page.splitlines()) if m}


class Metrics(unittest.TestCase):
    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.address = "unix:" + os.path.join(folder.name, "socket")
        self.server = subprocess.Popen(
            [
                HAPTICD,
                "--scene",
                SCENE,
                "--realtime=off",
                "--listen",
                self.address,
                "--set",
                "server.metrics_listen=127.0.0.1:0",
                "--set",
                "server.udp_listen=127.0.0.1:0",
                "--set",
                "loop.late_bucket_full=1000000",
                "--set",
                "loop.loop_late_fault={seconds: 10}",
            ],
            stderr=subprocess.PIPE,
            text=True,
        )
        self.addCleanup(self.end)
        for line in self.server.stderr:
            found = re.search(r"metrics on port (\d+)", line)
            if found:
                self.url = f"http://127.0.0.1:{found[1]}/metrics"
                return
        self.fail("hapticd logged no metrics port")

    def end(self) -> None:
        self.server.kill()
        self.server.wait()
        self.server.stderr.close()

    def scrape(self) -> str:
        with urllib.request.urlopen(self.url, timeout=10) as answer:
            self.assertEqual(
                answer.headers["Content-Type"], "text/plain; version=0.0.4; charset=utf-8"
            )
            return answer.read().decode()

    def test_promtool_finds_nothing(self) -> None:
        judged = subprocess.run(
            ["promtool", "check", "metrics"], input=self.scrape(), text=True, capture_output=True
        )
        self.assertEqual((judged.returncode, judged.stdout + judged.stderr), (0, ""))

    def test_promtool_bites(self) -> None:
        judged = subprocess.run(
            ["promtool", "check", "metrics"],
            input="# TYPE a_milliseconds counter\na_milliseconds 1\n",
            text=True,
            capture_output=True,
        )
        self.assertNotEqual(judged.returncode, 0)

    def test_metrics_show_what_happened(self) -> None:
        before = parse(self.scrape())
        device = 'device="finger"'
        self.assertEqual(before["haptic_device_controlled", device], 0)
        subprocess.run(
            [HAPTICCTL, "--server", self.address, "engage", "--hold", "--seconds", "2"],
            check=True,
            stdout=subprocess.DEVNULL,
        )
        time.sleep(0.5)
        after = parse(self.scrape())

        def grown(name: str, labels: str = "") -> float:
            return after[name, labels] - before[name, labels]

        ticks = grown("haptic_loop_ticks_total")
        self.assertGreater(ticks, 1000)
        self.assertAlmostEqual(grown("haptic_loop_period_seconds_count"), ticks, delta=20)
        self.assertAlmostEqual(grown("haptic_loop_lateness_seconds_count"), ticks, delta=20)
        half, most = (after["haptic_loop_tick_seconds", f'percentile="{p}"'] for p in (50, 99))
        self.assertTrue(0.0 < half <= most < 0.1, (half, most))
        fresh = grown("haptic_staleness_seconds_total", device + ',level="fresh"')
        self.assertGreater(fresh, 0.5)
        # Samples begin on the stream and go by UDP once that has proved good.
        grpc, udp = (
            grown("haptic_carrier_seconds_total", f'{device},carrier="{c}"')
            for c in ("grpc", "udp")
        )
        self.assertGreater(grpc + udp, 0.5)
        self.assertGreater(min(grpc, udp), 0)
        self.assertGreaterEqual(grown("haptic_carrier_changes_total", device), 1)
        self.assertGreater(grown("haptic_proxy_samples_total", device + ',verdict="accepted"'), 10)
        self.assertGreater(grown("haptic_proxy_age_seconds_count", device), 500)
        self.assertEqual(after["haptic_sessions", ""], 0)
        states = {k[1]: v for k, v in after.items() if k[0] == "haptic_device_state"}
        self.assertEqual(sum(states.values()), 1)

    maxDiff = None

    def test_page_lists_what_is_served(self) -> None:
        documented: dict[str, str] = {}
        with open(README, encoding="utf-8") as page:
            for names, kind in re.findall(
                r"^\| (`(?:haptic|process)_[^|]*) \| (\w+) \|", page.read(), re.M
            ):
                documented.update({name: kind for name in re.findall(r"`(\w+)`", names)})
        served = dict(re.findall(r"^# TYPE (\w+) (\w+)$", self.scrape(), re.M))
        # These exist for boards only, and this scene has none.
        for name in ("haptic_link_frames_total", "haptic_loop_sample_paced_ticks_total"):
            self.assertEqual(documented.pop(name), "counter")
        self.assertEqual(documented, served)

    def test_open_session_is_counted(self) -> None:
        labels = 'device="finger"'
        client = subprocess.Popen(
            [HAPTICCTL, "--server", self.address, "engage", "--hold", "--seconds", "60"],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        self.addCleanup(client.wait)
        self.addCleanup(client.kill)
        latest = time.monotonic() + 30
        while True:
            page = parse(self.scrape())
            if (
                page["haptic_device_controlled", labels] == 1
                and page["haptic_device_state", labels + ',state="engaged"'] == 1
                and page["haptic_gain_ratio", labels] == 1
            ):
                break
            self.assertLess(time.monotonic(), latest)
            time.sleep(0.1)
        self.assertEqual(page["haptic_sessions", ""], 1)

    def test_stop_counts_as_one_fault(self) -> None:
        labels = 'device="finger",fault="emergency_stop"'
        self.assertEqual(parse(self.scrape())["haptic_faults_total", labels], 0)
        subprocess.run(
            [HAPTICCTL, "--server", self.address, "estop"], check=True, stdout=subprocess.DEVNULL
        )
        time.sleep(0.3)
        self.assertEqual(parse(self.scrape())["haptic_faults_total", labels], 1)

    def test_nothing_else_is_served(self) -> None:
        with self.assertRaises(urllib.error.HTTPError) as refused:
            urllib.request.urlopen(self.url.replace("/metrics", "/"), timeout=10)
        self.assertEqual(refused.exception.code, 404)
        refused.exception.close()


if __name__ == "__main__":
    if shutil.which("promtool") is None:
        print("skipped: no promtool (Debian's prometheus)")
        sys.exit(77)
    unittest.main(argv=sys.argv[:1])
