#!/usr/bin/env python3
"""hapticd is two processes: whatever becomes of the one that faces the network, the one that owns
the devices goes on, stops by the local control socket, and gets a new front. Whole programs.

    front_test.py HAPTICD HAPTICCTL HAPTIC-HOSTILE-FRONT HAPTIC-EXAMPLE-SOFT-GRASP SCENES [TEST...]

The messages of haptic.v1 are on PYTHONPATH.
"""

from __future__ import annotations

import json
import os
import pathlib
import queue
import re
import signal
import socket
import subprocess
import sys
import tempfile
import time
import unittest
import urllib.request
from collections.abc import Callable, Iterator
from typing import Any

import grpc
from haptic.v1 import haptic_service_pb2 as service
from haptic.v1 import session_pb2 as wire
from haptic.v1.haptic_service_pb2_grpc import HapticServiceStub

HAPTICD, HAPTICCTL, HOSTILE, CLIENT = (str(pathlib.Path(p).resolve()) for p in sys.argv[1:5])
SCENES = pathlib.Path(sys.argv[5])
PATIENCE_S = 60.0  # of a busy machine; tests/hostile judges the times
STRANGER = """
import socket, sys
with socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET) as held:
    held.bind("\\0" + sys.argv[1])
    held.listen()
    print("held", flush=True)
    while True:
        held.accept()[0].close()
"""
STOPPED = "stopped locally: finger; cleared only on this host\n"
ENDED_S = 5.0  # after SIGTERM, whatever happens
NOTICED_S = 1.5  # a front that hangs is not replaced before


def until(what: str, condition: Callable[[], bool]) -> float:
    began = time.monotonic()
    while not condition():
        if time.monotonic() > began + PATIENCE_S:
            raise AssertionError(f"not within {PATIENCE_S:g} s: {what}")
        time.sleep(0.01)
    return time.monotonic() - began


def children(pid: int) -> dict[int, str]:
    found = {}
    for entry in os.listdir("/proc"):
        if entry.isdigit():
            try:
                text = pathlib.Path(f"/proc/{entry}/stat").read_text()
            except OSError:
                continue
            name, rest = text[text.index("(") + 1 :].rsplit(")", 1)
            if int(rest.split()[1]) == pid:
                found[int(entry)] = name
    return found


class Hapticd:
    def __init__(self, folder: pathlib.Path, *arguments: str, scene: str = "finger_constant",
                 log: str = "log", **environment: str) -> None:
        self.log = folder / log
        with open(self.log, "w", encoding="utf-8") as log:
            self.process = subprocess.Popen(
                [HAPTICD, "--scene", str(SCENES / f"{scene}.textproto"),
                 "--set", "loop.late_bucket_full=1000000", "--set",
                 "loop.loop_late_fault={seconds: 5}", *arguments],
                stdin=subprocess.DEVNULL, stdout=log, stderr=log,
                env={**os.environ, **environment})

    def text(self) -> str:
        return self.log.read_text(encoding="utf-8", errors="replace")

    def until_said(self, what: str) -> re.Match[str]:
        until(f"'{what}' in the log of hapticd:\n" + self.text(),
              lambda: re.search(what, self.text()) is not None or self.process.poll() is not None)
        found = re.search(what, self.text())
        assert found is not None, self.text()
        return found

    def address(self) -> str:
        return self.until_said(r"serving '.*' on (\S+)")[1]

    def front(self) -> int:
        """Its process; 0: there is none."""
        launchers = children(self.process.pid)
        fronts = [pid for launcher in launchers for pid, name in children(launcher).items()
                  if name.startswith(("hapticd-front", "haptic-hostile"))]
        return fronts[0] if fronts else 0

    def kill_front(self, how: signal.Signals) -> int:
        front = self.front()
        os.kill(front, how)
        return front

    def until_replaced(self, front: int) -> float:
        return until("another front", lambda: self.front() not in (0, front))

    def ctl(self, *words: str, address: str = "") -> tuple[int, str]:
        done = subprocess.run([HAPTICCTL, "--server", address or self.address(), *words],
                              capture_output=True, text=True, timeout=PATIENCE_S)
        return done.returncode, done.stdout + done.stderr

    def ask(self, command: str) -> str:
        """By the first socket that it said to have."""
        place = self.until_said(r"local control socket: ([^,\s]+)")[1]
        with socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET) as control:
            control.settimeout(PATIENCE_S)
            control.connect(place.replace("@", "\0"))
            control.send(command.encode())
            return control.recv(4096).decode()

    def stop(self) -> int:
        self.process.terminate()
        return self.process.wait(PATIENCE_S)


class Fronts(unittest.TestCase):
    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def hapticd(self, *arguments: str, **more: str) -> Hapticd:
        daemon = Hapticd(self.folder, "--listen", "127.0.0.1:0", *arguments, **more)
        self.addCleanup(daemon.process.wait)
        self.addCleanup(daemon.process.kill)
        return daemon

    def hostile(self, mode: str) -> Hapticd:
        return self.hapticd(HAPTICD_FRONT=HOSTILE, HOSTILE=mode)

    def test_a_killed_front_is_replaced(self) -> None:
        daemon = self.hapticd()
        address = daemon.address()
        front = daemon.kill_front(signal.SIGKILL)
        daemon.until_replaced(front)
        until("served again", lambda: daemon.ctl("health", address=address)[0] == 0)
        self.assertEqual(daemon.stop(), 0, daemon.text())

    def test_the_front_ends_with_its_owner(self) -> None:
        daemon = self.hapticd()
        daemon.address()
        front = pathlib.Path(f"/proc/{daemon.front()}")
        daemon.process.kill()
        until("the front has ended", lambda: not front.exists())

    def test_a_stopped_launcher_is_named(self) -> None:
        daemon = self.hapticd()
        front = daemon.address() and daemon.front()
        launcher = next(iter(children(daemon.process.pid)))
        os.kill(launcher, signal.SIGSTOP)
        os.kill(front, signal.SIGKILL)
        daemon.until_said(rf"launcher of the front does not answer \(process {launcher}\)")
        os.kill(launcher, signal.SIGCONT)
        daemon.until_said("answers again")
        daemon.until_said("front number 2 serves")

    def test_a_lost_launcher_ends_hapticd(self) -> None:
        daemon = self.hapticd()
        daemon.until_said("INIT -> IDLE")
        os.kill(next(iter(children(daemon.process.pid))), signal.SIGKILL)
        self.assertEqual(daemon.process.wait(PATIENCE_S), 1)
        self.assertIn("IDLE -> CLOSING", daemon.text())

    def test_a_frozen_front_is_replaced(self) -> None:
        daemon = self.hapticd()
        address = daemon.address()
        front = daemon.kill_front(signal.SIGSTOP)
        began = time.monotonic()
        self.assertEqual(daemon.ctl("estop", address=address), (0, STOPPED))
        daemon.until_replaced(front)
        self.assertGreater(time.monotonic() - began, NOTICED_S)
        until("served again", lambda: "FAULT" in daemon.ctl("info", address=address)[1])

    def engaged_client(self, daemon: Hapticd, address: str) -> None:
        client = subprocess.Popen([CLIENT, "--server", address], stdout=subprocess.DEVNULL,
                                  stderr=subprocess.DEVNULL)
        self.addCleanup(client.wait)
        self.addCleanup(client.kill)
        daemon.until_said("-> ENGAGED")

    def test_a_lease_outlives_the_front(self) -> None:
        daemon = self.hapticd("--set", "server.lease_timeout={seconds: 30}",
                              scene="finger_soft_grasp")
        address = daemon.address()
        self.engaged_client(daemon, address)
        for replace in (lambda: daemon.kill_front(signal.SIGKILL),
                        lambda: daemon.ctl("restart-front", address=address)):
            log = len(daemon.text())
            replace()
            until("the lease is resumed", lambda: "LEASE_RESUMED" in daemon.text()[log:])
        self.assertNotIn("LEASE_ENDED", daemon.text())
        self.assertEqual(daemon.stop(), 0, daemon.text())

    def test_missed_events_are_told_once(self) -> None:
        daemon = self.hapticd("--set", "server.lease_timeout={seconds: 30}")
        address = daemon.address()

        def session(**more: Any) -> Iterator[wire.SessionResponse]:
            opening = wire.OpenSession(role=wire.ROLE_CONTROLLER, client_name="test",
                                       resumable=True, nominal_rate_hz=100, state_rate_hz=10,
                                       **more)
            requests: queue.SimpleQueue[wire.SessionRequest | None] = queue.SimpleQueue()
            requests.put(wire.SessionRequest(open=opening))
            channel = grpc.insecure_channel(address)
            self.addCleanup(channel.close)
            self.addCleanup(requests.put, None)
            return HapticServiceStub(channel).Session(iter(requests.get, None))

        def events(stream: Iterator[wire.SessionResponse], last: str) -> list[wire.Event]:
            """Up to the one whose reason is `last`."""
            found = [next(r.event for r in stream if r.HasField("event"))]
            while found[-1].reason != last:
                found.append(next(r.event for r in stream if r.HasField("event")))
            return found

        first = session()
        lost = next(first).opened.session_id
        seen = events(first, "LEASE_GRANTED")[-1].server_time_ns
        front = daemon.kill_front(signal.SIGSTOP)
        self.assertEqual(daemon.ctl("estop", address=address)[0], 0)
        self.assertEqual(daemon.ctl("clear-fault", address=address)[0], 0)
        daemon.until_replaced(front)
        until("served again", lambda: daemon.ctl("health", address=address)[0] == 0)
        second = session(resume=lost, events_after_ns=seen)
        self.assertTrue(next(second).opened.resumed)
        told = [(wire.Event.Kind.Name(e.kind), e.reason) for e in events(second, "LEASE_RESUMED")]
        self.assertEqual([t for t in told if "STATE" not in t[0]],
                         [("KIND_FAULT", "EMERGENCY_STOP"),
                          ("KIND_FAULT_CLEARED", "EMERGENCY_STOP"),
                          ("KIND_LEASE", "LEASE_DETACHED"), ("KIND_LEASE", "LEASE_RESUMED")])

    def test_counters_survive_the_front(self) -> None:
        daemon = self.hapticd("--set", 'server.metrics_listen="127.0.0.1:0"',
                              "--set", 'server.udp_listen="127.0.0.1:0"')
        udp = int(daemon.until_said(r"UDP path on port (\d+)")[1])
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as junk:
            for _ in range(5):
                junk.sendto(b"junk", ("127.0.0.1", udp))

        def scrape() -> dict[str, float]:
            port = re.findall(r"metrics on port (\d+)", daemon.text())[-1]
            with urllib.request.urlopen(f"http://127.0.0.1:{port}/metrics", timeout=10) as answer:
                page = answer.read().decode()
            return {name: float(n) for name, n in re.findall(r"^(\S+) (\S+)$", page, re.M)}

        dropped = 'haptic_udp_dropped_datagrams_total{reason="length"}'
        until("five datagrams dropped", lambda: scrape()[dropped] == 5)
        before = scrape()
        daemon.kill_front(signal.SIGKILL)
        daemon.until_said("front number 2 serves")
        until("its metrics", lambda: daemon.text().count("metrics on port") == 2)
        after = scrape()
        self.assertEqual(after[dropped], 5)
        self.assertEqual(after["haptic_front_starts_total"], 2)
        self.assertGreaterEqual(after["haptic_loop_period_seconds_count"],
                                before["haptic_loop_period_seconds_count"])

    def test_a_local_stop_is_cleared_locally(self) -> None:
        daemon = self.hapticd()
        with grpc.insecure_channel(daemon.address()) as channel:
            stub, clear = HapticServiceStub(channel), service.ClearFaultRequest()
            self.assertEqual(daemon.ctl("estop")[0], 0)
            with self.assertRaisesRegex(grpc.RpcError, "stopped on the host"):
                stub.ClearFault(clear, timeout=PATIENCE_S)
            self.assertEqual(daemon.ctl("clear-fault"), (0, "cleared: EMERGENCY_STOP\n"))
            stub.EmergencyStop(service.EmergencyStopRequest(), timeout=PATIENCE_S)
            self.assertEqual(list(stub.ClearFault(clear, timeout=PATIENCE_S).cleared), [7])

    def test_one_port_two_daemons_two_sockets(self) -> None:
        daemon = self.hapticd()
        address = daemon.address()
        other = Hapticd(self.folder, "--listen", address.replace("0.0.1", "0.0.2"), log="other")
        self.addCleanup(other.process.wait)
        self.addCleanup(other.process.kill)
        self.assertEqual(other.ctl("estop"), (0, STOPPED))
        self.assertIn("local emergency stop", other.text())
        self.assertNotIn("local emergency stop", daemon.text())

    @unittest.skipIf(os.geteuid() != 0, "a socket of another user: needs root")
    def test_a_strangers_socket_is_not_believed(self) -> None:
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            address = f"127.0.0.1:{free.getsockname()[1]}"
        stranger = subprocess.Popen(
            [sys.executable, "-c", STRANGER, "hapticd/" + address], user=65534,
            stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
        self.addCleanup(stranger.wait)
        self.addCleanup(stranger.kill)
        assert stranger.stdout is not None
        self.addCleanup(stranger.stdout.close)
        stranger.stdout.readline()
        alone = subprocess.run([HAPTICCTL, "--server", address, "estop"], capture_output=True,
                               text=True, timeout=PATIENCE_S)
        self.assertEqual((alone.returncode, "user 65534" in alone.stderr), (3, True), alone)
        daemon = self.hapticd("--listen", address)
        daemon.until_said("in use by user 65534")
        self.assertEqual(daemon.ctl("estop", address=address), (0, STOPPED))

    def test_health_shows_samples_and_sessions(self) -> None:
        daemon = self.hapticd(scene="finger_soft_grasp")
        address = daemon.address()
        self.engaged_client(daemon, address)

        def front() -> dict[str, Any]:
            return json.loads(daemon.ctl("--json", "health", address=address)[1])["front"]

        until("samples", lambda: front()["devices"][0]["samples_accepted_per_s"] > 10)
        told = front()
        self.assertEqual((told["process"], told["devices"][0]["sessions"], told["connections"] > 0,
                          told["plays_a_client"]), (daemon.front(), 1, True, False))
        daemon.kill_front(signal.SIGSTOP)  # health does not wait for the network's word
        status, words = daemon.ctl("health", address=address)
        self.assertEqual((status, "not serving" in words, "1 sessions" in words), (1, True, True),
                         words)

    def test_an_offline_scene_has_no_front(self) -> None:
        daemon = Hapticd(self.folder, scene="fragments/offline")
        self.addCleanup(daemon.process.wait)
        self.addCleanup(daemon.process.kill)
        daemon.until_said("INIT -> IDLE")
        self.assertEqual(children(daemon.process.pid), {})
        self.assertEqual(daemon.ctl("estop", address="local:offline"), (0, STOPPED))
        self.assertEqual(daemon.ctl("restart-front", address="local:offline")[0], 4)
        self.assertEqual(daemon.stop(), 0, daemon.text())

    def test_a_broken_token_keeps_the_old_front(self) -> None:
        token = self.folder / "token"
        token.write_text("0123456789abcdef\n", encoding="utf-8")
        token.chmod(0o600)
        web = ('server.web={listen: "127.0.0.1:0" token {name: "unity" rights: "primary" '
               f'file: "{token}"}}}}')
        daemon = self.hapticd("--set", web)
        address, front = daemon.address(), daemon.front()
        token.write_text("short\n", encoding="utf-8")
        for mode, why in ((0o600, "must hold 16 to 128"), (0o644, "chmod 600")):
            token.chmod(mode)
            status, words = daemon.ctl("restart-front", address=address)
            self.assertEqual((status, "token 'unity'" in words, why in words), (4, True, True),
                             words)
            self.assertEqual(daemon.front(), front)
        token.write_text("0123456789abcdef\n", encoding="utf-8")
        token.chmod(0o600)
        self.assertEqual(daemon.ctl("restart-front", address=address)[0], 0)
        self.assertNotEqual(daemon.front(), front)
        self.assertEqual(daemon.ctl("health", address=address)[0], 0)

    def test_a_lost_front_leaves_its_port(self) -> None:
        daemon = self.hapticd()
        address = daemon.address()
        host, port = address.rsplit(":", 1)
        front = daemon.kill_front(signal.SIGKILL)
        with socket.create_connection((host, int(port)), timeout=PATIENCE_S):
            while daemon.front() in (0, front):
                with socket.socket() as other:
                    other.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
                    self.assertRaises(OSError, other.bind, (host, int(port)))
        until("served again", lambda: daemon.ctl("health", address=address)[0] == 0)

    def test_a_front_of_another_build_is_refused(self) -> None:
        program = self.folder / "front"
        program.symlink_to(pathlib.Path(HAPTICD).with_name("hapticd-front"))
        daemon = self.hapticd(HAPTICD_FRONT=str(program), HOSTILE="layout")
        address, front = daemon.address(), daemon.front()
        program.unlink()
        program.symlink_to(HOSTILE)
        status, words = daemon.ctl("restart-front")
        self.assertEqual((status, "another build" in words), (4, True), words)
        self.assertEqual(daemon.front(), front)
        until("it serves", lambda: daemon.ctl("health", address=address)[0] == 0)

    def test_a_front_that_cannot_serve_ends_hapticd(self) -> None:
        for program, words in (("/bin/true", "ended with status 0"),
                               (HOSTILE, "another build"), ("/no/such", "ended with status 127")):
            daemon = self.hapticd(HAPTICD_FRONT=program, HOSTILE="layout")
            self.assertEqual(daemon.process.wait(PATIENCE_S), 1)
            self.assertIn(words, daemon.text())

    def test_a_start_that_hangs_ends(self) -> None:
        for mode in ("silent", "unbound"):
            daemon = self.hostile(mode)
            daemon.until_said("real-time grade")
            until("a front", lambda: daemon.front() != 0)
            began = time.monotonic()
            self.assertEqual(daemon.stop(), 0, daemon.text())
            self.assertLess(time.monotonic() - began, ENDED_S)
            self.assertNotIn("INIT -> IDLE", daemon.text())

    def test_a_large_scene_ends_while_it_loads(self) -> None:
        replayed = self.folder / "long.csv"
        with open(replayed, "w", encoding="utf-8") as file:
            file.write("time_s,q_o1_mcp_rad,q_o2_pip_rad\n")
            file.writelines(f"{0.001 * i:.3f},0.2,0.3\n" for i in range(8_000_000))
        daemon = self.hapticd("--set", f'device[0].replay.file="{replayed}"',
                              scene="finger_replay")
        daemon.until_said("real-time grade")
        time.sleep(0.3)
        began = time.monotonic()
        self.assertEqual(daemon.stop(), 0, daemon.text())
        self.assertLess(time.monotonic() - began, ENDED_S)

    def test_the_owners_pages_stay_the_owners(self) -> None:
        daemon = self.hostile("pages")
        daemon.until_said("SIGSEGV")  # of the front
        self.assertNotIn("GOT IN", daemon.text())
        self.assertEqual(daemon.ask("stop"), "ok\nfinger")
        self.assertEqual(daemon.stop(), 0, daemon.text())

    def test_junk_of_a_front_harms_nothing(self) -> None:
        daemon = self.hostile("junk")
        daemon.until_said("INIT -> IDLE")
        resident = pathlib.Path(f"/proc/{daemon.process.pid}/statm")
        time.sleep(1.0)
        before = int(resident.read_text().split()[1])
        for _ in range(20):
            self.assertEqual(daemon.ask("stop"), "ok\nfinger")
            time.sleep(0.1)
        self.assertLess(4096 * (int(resident.read_text().split()[1]) - before), 4 << 20)
        self.assertEqual(daemon.stop(), 0, daemon.text())

    def test_a_stop_goes_ahead_of_a_full_queue(self) -> None:
        daemon = self.hostile("stop")
        daemon.until_said("ahead of the requests that wait")
        self.assertEqual(daemon.stop(), 0, daemon.text())

    def test_a_mute_front_is_replaced(self) -> None:
        daemon = self.hostile("mute")
        daemon.until_said("no sign of life for 2 s")
        daemon.until_said("front number 2 serves")
        self.assertEqual(daemon.ask("health").splitlines()[0], "ok")


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[6:]], verbosity=2)
