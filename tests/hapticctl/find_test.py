#!/usr/bin/env python3
"""`hapticctl find` against a real Avahi daemon, which serves the package's own service file.

    find_test.py HAPTICCTL SERVICE-FILE

It runs in namespaces of its own for network, mounts and users, with a D-Bus of its own: nothing is
announced to the host's network. 77: avahi-daemon, avahi-utils, dbus-daemon or namespaces are not
there.
"""

import contextlib
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import time
import unittest

HAPTICCTL, SERVICE = sys.argv[1:3]
INSIDE = "HAPTIC_FIND_INSIDE"
PATIENCE_S = 60
EVIL_NAME = 'evil\x1b[2J;"\nLab Süd'
EVIL_TXT = ["k=\n=;lo;IPv4;fake;_hapticd._tcp;local;h;192.0.2.9;5;", b"\x1b[31m\xff\xfe\x9b"]
CONFIG = """
[server]
host-name=lab
use-ipv6=no
[publish]
publish-hinfo=no
publish-workstation=no
publish-aaaa-on-ipv4=no
"""


def find(*words: str) -> subprocess.CompletedProcess[bytes]:
    return subprocess.run([HAPTICCTL, *words, "find"], capture_output=True, timeout=PATIENCE_S)


class Find(unittest.TestCase):
    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.bus = f"unix:path={folder.name}/bus"
        os.environ["DBUS_SYSTEM_BUS_ADDRESS"] = self.bus
        self.log = open(self.folder / "log", "w+b")
        self.addCleanup(self.log.close)

    def start(self, *words: str | bytes) -> subprocess.Popen[bytes]:
        process = subprocess.Popen(words, stdin=subprocess.DEVNULL, stdout=self.log,
                                   stderr=subprocess.STDOUT)
        self.addCleanup(process.wait)
        self.addCleanup(process.terminate)
        return process

    def start_avahi(self, *services: str) -> None:
        for file in pathlib.Path("/etc/avahi/services").iterdir():
            file.unlink()
        for file in services:
            shutil.copy(file, "/etc/avahi/services")
        self.start("dbus-daemon", "--session", "--nofork", f"--address={self.bus}")
        self.until(lambda: (self.folder / "bus").exists(), "no bus")
        (self.folder / "avahi.conf").write_text(CONFIG)
        self.start("avahi-daemon", "--no-drop-root", "--no-rlimits", "--no-chroot",
                   "--no-proc-title", f"--file={self.folder}/avahi.conf")
        self.until(lambda: find().returncode in (0, 3), "no Avahi daemon")

    def until(self, condition, what: str) -> None:
        latest = time.monotonic() + PATIENCE_S
        while not condition():
            self.log.seek(0)
            self.assertLess(time.monotonic(), latest, f"{what}: {self.log.read()!r}")
            time.sleep(0.1)

    def servers(self) -> list[dict]:
        return json.loads(find("--json").stdout)["servers"]

    def test_packaged_file_is_found(self) -> None:
        self.start_avahi(SERVICE)
        self.until(lambda: find().returncode == 0, "not found")
        self.assertEqual(self.servers(), [{"name": "hapticd on lab", "host": "lab.local",
                                           "address": "127.0.0.1:29470",
                                           "txt": ["protocol=haptic.v1"]}])
        self.assertEqual(find().stdout.split(b" ", 1)[0], b"127.0.0.1:29470")

    def test_hostile_announcement_stays_one_line(self) -> None:
        self.start_avahi()
        self.start("avahi-publish", "-s", EVIL_NAME, "_hapticd._tcp", "29471", *EVIL_TXT)
        self.until(lambda: find().returncode == 0, "not found")
        shown = find().stdout
        self.assertEqual(shown.count(b"\n"), 1)
        self.assertTrue(all(0x20 <= byte < 0x7F for byte in shown.strip()), shown)
        (server,) = self.servers()
        self.assertEqual((server["name"], server["address"]), (EVIL_NAME, "127.0.0.1:29471"))
        self.assertIn(EVIL_TXT[0], server["txt"])

    def test_given_time_sees_late_servers(self) -> None:
        self.start_avahi()
        looking = subprocess.Popen([HAPTICCTL, "--json", "find", "--seconds", "8"],
                                   stdout=subprocess.PIPE)
        time.sleep(1)
        self.start("avahi-publish", "-s", "late", "_hapticd._tcp", "29470")
        shown, _ = looking.communicate(timeout=PATIENCE_S)
        self.assertEqual([s["name"] for s in json.loads(shown)["servers"]], ["late"])
        self.assertEqual(looking.returncode, 0)

    def test_flood_is_bounded(self) -> None:
        flood = self.folder / "avahi-browse"  # Avahi itself has bounds that hide ours
        flood.write_text("""#!/bin/sh
            i=0; while :; do i=$((i + 1))
            echo "=;lo;IPv4;n$i;_hapticd._tcp;local;lab.local;127.0.0.1;29470;"; done""")
        flood.chmod(0o755)
        flooded = {**os.environ, "PATH": f"{self.folder}:{os.environ['PATH']}"}
        ended = subprocess.run([HAPTICCTL, "find", "--seconds", "3600"], capture_output=True,
                               timeout=PATIENCE_S, env=flooded)
        self.assertEqual((ended.returncode, ended.stdout.count(b"\n")), (0, 256))
        self.assertIn(b"more is announced", ended.stderr)

    def test_no_server_is_3(self) -> None:
        self.start_avahi()
        ended = find()
        self.assertEqual((ended.returncode, ended.stdout), (3, b""))
        self.assertIn(b"no hapticd announces itself", ended.stderr)

    def test_no_daemon_is_1(self) -> None:
        for words in ([], ["--json"]):
            ended = find(*words)
            self.assertEqual((ended.returncode, ended.stdout), (1, b""))
            self.assertIn(b"a running avahi-daemon", ended.stderr)


def enter() -> None:
    """Makes the loopback interface and the folders that avahi-daemon has compiled in."""
    for words in (["ip", "link", "set", "lo", "up"],
                  ["mount", "-t", "tmpfs", "none", "/run"],
                  ["mount", "-t", "tmpfs", "none", "/etc/avahi/services"]):
        subprocess.run(words, check=True)


def main() -> None:
    if os.environ.get(INSIDE):
        enter()
        unittest.main(argv=sys.argv[:1])
    for program in ("avahi-daemon", "avahi-browse", "avahi-publish", "dbus-daemon", "ip"):
        if shutil.which(program) is None:
            print(f"skipped: no {program}")
            sys.exit(77)
    namespaces = ["unshare", "--net", "--mount"]
    if os.geteuid() != 0:
        namespaces.append("--map-root-user")
    with contextlib.suppress(OSError):
        if subprocess.run([*namespaces, "true"], capture_output=True).returncode == 0:
            os.execvpe(namespaces[0], [*namespaces, sys.executable, *sys.argv],
                       {**os.environ, INSIDE: "1"})
    print("skipped: this host allows no namespaces")
    sys.exit(77)


if __name__ == "__main__":
    os.environ["PATH"] += ":/usr/sbin"
    main()
