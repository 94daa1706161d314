#!/usr/bin/env python3
"""hapticd as systemd sees it: ready, fed while it ticks, stopping.

    notify_test.py HAPTICD SCENE
"""
import os
import signal
import socket
import subprocess
import sys
import tempfile
import unittest

HAPTICD, SCENE = sys.argv[1:3]
WATCHDOG_US = 400_000


class Notify(unittest.TestCase):
    def setUp(self) -> None:
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        path = os.path.join(self.folder.name, "notify")
        self.manager = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        self.addCleanup(self.manager.close)
        self.manager.bind(path)
        self.manager.settimeout(20)
        environment = dict(os.environ, NOTIFY_SOCKET=path, WATCHDOG_USEC=str(WATCHDOG_US))
        environment.pop("WATCHDOG_PID", None)
        self.server = subprocess.Popen(
            [HAPTICD, "--scene", SCENE, "--realtime=off",
             "--listen", "unix:" + os.path.join(self.folder.name, "socket")],
            env=environment, stderr=subprocess.DEVNULL)
        self.addCleanup(self.end)

    def end(self) -> None:
        self.server.kill()
        self.server.wait()

    def hear(self) -> list[str]:
        return self.manager.recv(4096).decode().split("\n")

    def test_hangup_replaces_the_front(self) -> None:
        self.assertIn("READY=1", self.hear())
        self.server.send_signal(signal.SIGHUP)
        for _ in range(3):
            self.assertEqual(self.hear(), ["WATCHDOG=1"])
        self.assertIsNone(self.server.poll())

    def test_ready_then_fed_then_stopping(self) -> None:
        first = self.hear()
        self.assertIn("READY=1", first)
        self.assertTrue(first[1].startswith("STATUS="), first)
        for _ in range(5):
            self.assertEqual(self.hear(), ["WATCHDOG=1"])
        self.server.send_signal(signal.SIGTERM)
        last = self.hear()
        while last == ["WATCHDOG=1"]:
            last = self.hear()
        self.assertIn("STOPPING=1", last)
        self.assertEqual(self.server.wait(timeout=5), 0)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
