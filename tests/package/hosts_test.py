#!/usr/bin/env python3
"""The Prometheus configuration of docker/hosts, judged by promtool, and by a real Prometheus that
scrapes three real hapticds.

    hosts_test.py HAPTICD HAPTICCTL SOURCE

77: prometheus or promtool (Debian's prometheus) is not there.
"""

import contextlib
import json
import pathlib
import re
import shutil
import socket
import subprocess
import sys
import tempfile
import time
import unittest
import urllib.parse
import urllib.request

HAPTICD, HAPTICCTL = sys.argv[1:3]
HOSTS = pathlib.Path(sys.argv[3]) / "docker/hosts"
RULES = (HOSTS / "rules.yml").read_text(encoding="utf-8")
NAMES = re.findall(r"^ +- (?:alert|record): (\S+)", RULES, re.M)
# The scenes of docker/hosts/compose.yaml; each is the name of one target.
SCENES = {"left": "finger_constant", "right": "hand_five_fingers", "table": "linear_one_dof"}
PATIENCE_S = 60


def promtool(*words: object) -> subprocess.CompletedProcess[str]:
    return subprocess.run(["promtool", *map(str, words)], capture_output=True, text=True)


class Rules(unittest.TestCase):
    def test_promtool_accepts_configuration(self) -> None:
        judged = promtool("check", "config", HOSTS / "prometheus.yml")
        self.assertEqual(judged.returncode, 0, judged.stderr)

    def test_cases_pass(self) -> None:
        judged = promtool("test", "rules", HOSTS / "rules_test.yml")
        self.assertEqual(judged.returncode, 0, judged.stdout + judged.stderr)

    def test_every_rule_has_a_case(self) -> None:
        self.assertGreater(len(NAMES), 7)
        for name in NAMES:
            with self.subTest(name), tempfile.TemporaryDirectory() as folder:
                rest = re.sub(rf"^ +- (alert|record): {name}\n(?:(?! +- |$).*\n)+", "", RULES,
                              flags=re.M)
                self.assertNotEqual(rest, RULES)
                pathlib.Path(folder, "rules.yml").write_text(rest)
                cases = shutil.copy(HOSTS / "rules_test.yml", folder)
                judged = promtool("test", "rules", cases)
                self.assertIn("FAILED", judged.stdout + judged.stderr)


class Laboratory(unittest.TestCase):
    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.metrics = {name: self.start_server(name, scene) for name, scene in SCENES.items()}

    def start_server(self, name: str, scene: str) -> str:
        server = subprocess.Popen(
            [HAPTICD, "--scene", scene, "--realtime=off", "--listen", self.address(name),
             "--set", "server.metrics_listen=127.0.0.1:0",
             "--set", "loop.late_bucket_full=1000000",
             "--set", "loop.loop_late_fault={seconds: 10}"],
            stderr=subprocess.PIPE, text=True)
        self.addCleanup(server.stderr.close)
        self.addCleanup(server.wait)
        self.addCleanup(server.terminate)
        for line in server.stderr:
            if found := re.search(r"metrics on port (\d+)", line):
                return f"127.0.0.1:{found[1]}"
        self.fail("hapticd logged no metrics port")

    def address(self, name: str) -> str:
        return f"unix:{self.folder}/{name}"

    def start_prometheus(self) -> None:
        """With the targets of this test instead of the composition's, and a quicker pace."""
        shutil.copy(HOSTS / "rules.yml", self.folder)
        config = (HOSTS / "prometheus.yml").read_text(encoding="utf-8")
        for name, target in self.metrics.items():
            self.assertIn(f'"{name}:29472"', config)
            config = config.replace(f"{name}:29472", target)
        (self.folder / "prometheus.yml").write_text(config.replace("interval: 5s", "interval: 1s"))
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            self.prometheus = f"127.0.0.1:{free.getsockname()[1]}"
        log = open(self.folder / "log", "wb")
        self.addCleanup(log.close)
        process = subprocess.Popen(
            ["prometheus", f"--config.file={self.folder}/prometheus.yml",
             f"--storage.tsdb.path={self.folder}/measured",
             f"--web.listen-address={self.prometheus}"], stderr=log, stdout=log)
        self.addCleanup(process.wait)
        self.addCleanup(process.terminate)

    def instances(self, query: str) -> set[str]:
        """Names of the servers for which the query has an answer."""
        url = f"http://{self.prometheus}/api/v1/query?" + urllib.parse.urlencode({"query": query})
        with contextlib.suppress(OSError), urllib.request.urlopen(url, timeout=10) as answer:
            found = {r["metric"]["instance"] for r in json.load(answer)["data"]["result"]}
            return {name for name, target in self.metrics.items() if target in found}
        return set()

    def until(self, query: str, wanted: set[str]) -> None:
        latest = time.monotonic() + PATIENCE_S
        while (got := self.instances(query)) != wanted:
            if time.monotonic() > latest:
                self.fail(f"{query}: {got}\n{(self.folder / 'log').read_text()}")
            time.sleep(0.3)

    def test_rules_name_what_is_served(self) -> None:
        with urllib.request.urlopen(f"http://{self.metrics['left']}/metrics", timeout=10) as page:
            served = page.read().decode()
        metrics = set(re.findall(r"(?<!:)\bhaptic_\w+(?![\w:])", RULES))
        labels = set(re.findall(r'\b(\w+="\w+")', RULES)) - {'job="hapticd"'}
        self.assertGreater(len(metrics), 6)
        self.assertGreater(len(labels), 1)
        for name in metrics:
            self.assertRegex(served, rf"(?m)^{name}[ {{]")
        for label in labels:
            self.assertIn(label, served)

    def test_a_stop_alerts_for_its_server(self) -> None:
        self.start_prometheus()
        self.until('up{job="hapticd"} == 1', set(SCENES))
        self.until("instance:haptic_loop_lateness_seconds:p99_5m > 0", set(SCENES))
        self.assertEqual(self.instances('ALERTS{alertname="HapticFaultLatched"}'), set())
        subprocess.run([HAPTICCTL, "--server", self.address("right"), "estop"], check=True,
                       stdout=subprocess.DEVNULL)
        self.until('ALERTS{alertname="HapticFaultLatched", alertstate="firing"}', {"right"})


if __name__ == "__main__":
    for program in ("prometheus", "promtool"):
        if shutil.which(program) is None:
            print(f"skipped: no {program} (Debian's prometheus)")
            sys.exit(77)
    unittest.main(argv=sys.argv[:1])
