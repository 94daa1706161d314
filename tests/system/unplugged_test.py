#!/usr/bin/env python3
"""The network is gone for 10 s and comes back: force is possible again within 3 s, for the client
library in C++ and in Python, by the stream alone and with a UDP path.

    unplugged_test.py HAPTICD HAPTICCTL HAPTIC-EXAMPLE-SOFT-GRASP SCENE    (haptic on PYTHONPATH)

Server and client live in network namespaces of their own with a router between them. Unplugged
means that the router drops everything without a word; or that the client's interface is gone, and
another one comes with another address, as an engine does to a container. Exit status 77 if this
host allows no namespaces."""

import contextlib
import json
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
import unittest

PATIENCE_S, OUTAGE_S, BACK_S = 60.0, 10.0, 3.0
SERVER, PORT, UDP = "10.77.1.2", 29470, 29471
INSIDE = "HAPTIC_UNPLUGGED_INSIDE"


def command(*words):
    subprocess.run(words, check=True, capture_output=True, text=True, stdin=subprocess.DEVNULL)


class Laboratory:
    """Two namespaces and the router, which is the one that this process runs in."""

    def __init__(self):
        command("ip", "link", "set", "lo", "up")
        self.holders = {}
        for number, name in enumerate(("server", "client"), start=1):
            holder = subprocess.Popen(["unshare", "--net", "sleep", "600"],
                                      stdin=subprocess.DEVNULL)
            self.holders[name] = holder
            own = os.stat("/proc/self/ns/net").st_ino
            while os.stat(f"/proc/{holder.pid}/ns/net").st_ino == own:
                time.sleep(0.01)
            self.join(name, number, 2)
        pathlib.Path("/proc/sys/net/ipv4/ip_forward").write_text("1")

    def join(self, name, number, host):
        """A cable from the router to the namespace, which gets 10.77.NUMBER.HOST."""
        near, far = f"to-{name}", f"at-{name}"
        command("ip", "link", "add", "name", near, "type", "veth", "peer", "name", far)
        command("ip", "link", "set", far, "netns", str(self.holders[name].pid))
        command("ip", "address", "add", f"10.77.{number}.1/24", "dev", near)
        command("ip", "link", "set", near, "up")
        for words in (("address", "add", f"10.77.{number}.{host}/24", "dev", far),
                      ("link", "set", far, "up"), ("link", "set", "lo", "up"),
                      ("route", "add", "default", "via", f"10.77.{number}.1")):
            command(*self.inside(name, "ip", *words))

    def inside(self, name, *words):
        return ["nsenter", f"--net=/proc/{self.holders[name].pid}/ns/net", *map(str, words)]

    def rules(self, verb):
        for number in (1, 2):
            command("ip", "rule", verb, "pref", "1", "to", f"10.77.{number}.0/24", "blackhole")

    def unplug(self, interface):
        command("ip", "link", "del", "to-client") if interface else self.rules("add")

    def plug(self, interface):
        self.join("client", 2, 3) if interface else self.rules("del")

    def close(self):
        for name, holder in self.holders.items():
            command("ip", "link", "del", f"to-{name}")
            holder.kill()
            holder.wait()


class Observer(threading.Thread):
    """The states of the device, as a client on the server's side sees them."""

    def __init__(self, words):
        super().__init__(daemon=True)
        self.process = subprocess.Popen(words, stdout=subprocess.PIPE, text=True,
                                        stdin=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        self.gain, self.at = 0.0, 0.0
        self.start()

    def run(self):
        for line in self.process.stdout or ():
            with contextlib.suppress(ValueError):
                self.gain = float(json.loads(line).get("gain", self.gain))
                self.at = time.monotonic()

    def end(self):
        self.process.kill()
        self.process.wait()
        self.join()
        self.process.stdout.close()

    def wait(self, what, wanted, seconds=PATIENCE_S):
        """Seconds until wanted(gain) is true."""
        began = time.monotonic()
        while not (self.at > began and wanted(self.gain)):
            if time.monotonic() > began + seconds:
                raise AssertionError(f"{what}: not within {seconds:g} s, gain {self.gain:g}")
            time.sleep(0.005)
        return time.monotonic() - began


def press_in_python(address, udp):
    """The client in Python: runs in the client's namespace until it is ended."""
    import haptic
    carriers = haptic.Carriers.BEST if udp else haptic.Carriers.STREAM
    with haptic.Connection(address) as connection:
        with connection.session(client_name="presser", nominal_rate_hz=60, carriers=carriers,
                                reconnect=True, re_engage=True) as session:
            session.engage_when_ready()
            while True:
                force = session.state is not None and session.state.gain > 0
                x = session.state.x_probe if force else ()  # force begins with a free proxy
                session.publish(haptic.held(x) if force else haptic.FREE)
                time.sleep(1 / 60)


class Unplugged(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.laboratory = Laboratory()
        self.addCleanup(self.laboratory.close)

    def started(self, words, name):
        with open(self.folder / name, "wb") as log:
            process = subprocess.Popen(words, stdin=subprocess.DEVNULL, stdout=log, stderr=log)

        def end():
            process.send_signal(signal.SIGTERM)
            try:
                process.wait(10.0)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
        self.addCleanup(end)
        return process

    def bears(self, client, interface=False):
        socket = f"unix:{self.folder}/s"
        inside = self.laboratory.inside
        self.started(inside(
            "server", HAPTICD, "--scene", SCENE, "--insecure-lab", "--listen", f"0.0.0.0:{PORT}",
            "--listen", socket, "--set", f"server.udp_listen=0.0.0.0:{UDP}",
            "--set", "loop.late_bucket_full=1000000", "--set",
            "loop.loop_late_fault={seconds: 10}"), "server.log")
        latest = time.monotonic() + PATIENCE_S
        while subprocess.run([HAPTICCTL, "--server", socket, "health"],
                             capture_output=True).returncode != 0:
            self.assertLess(time.monotonic(), latest, "hapticd does not serve")
        observer = Observer([HAPTICCTL, "--server", socket, "watch", "--json", "--rate", "100"])
        self.addCleanup(observer.end)
        process = self.started(inside("client", *client), "client.log")
        observer.wait("force at first", lambda gain: gain == 1.0)
        time.sleep(2.0)  # for the UDP path
        self.laboratory.unplug(interface)
        observer.wait("force goes", lambda gain: gain == 0.0, 2.0)
        time.sleep(OUTAGE_S)
        self.laboratory.plug(interface)
        after = observer.wait("force is back", lambda gain: gain > 0.0)
        self.assertIsNone(process.poll(), (self.folder / "client.log").read_text())
        print(f"{self.id()}: force again {after:.2f} s after the network", flush=True)
        self.assertLess(after, BACK_S)

    def cpp(self, carriers):
        return [GRASP, "--server", f"{SERVER}:{PORT}", "--carriers", carriers]

    def python(self, udp):
        return [sys.executable, __file__, "--press", f"{SERVER}:{PORT}", *(["udp"] if udp else [])]

    def test_cpp_by_the_stream(self):
        self.bears(self.cpp("grpc"))

    def test_cpp_with_udp(self):
        self.bears(self.cpp("auto"))

    def test_python_by_the_stream(self):
        self.bears(self.python(False))

    def test_python_with_udp(self):
        self.bears(self.python(True))

    def test_cpp_gets_another_address(self):
        self.bears(self.cpp("auto"), interface=True)

    def test_python_gets_another_address(self):
        self.bears(self.python(True), interface=True)


def enter():
    """Again in a network of its own; as a user without rights in a user namespace too."""
    for tool in ("ip", "unshare", "nsenter"):
        if shutil.which(tool) is None:
            print(f"skipped: no {tool}")
            sys.exit(77)
    words = ["unshare", "--net", *([] if os.getuid() == 0 else ["--map-root-user"])]
    probe = [*words, "sh", "-c", "ip link add name near type veth peer name far && "
             "ip rule add pref 1 to 10.77.9.0/24 blackhole && "
             "echo 1 >/proc/sys/net/ipv4/ip_forward"]
    tried = subprocess.run(probe, capture_output=True, text=True, stdin=subprocess.DEVNULL)
    if tried.returncode != 0:
        why = (tried.stderr.strip().splitlines() or ["no reason"])[-1]
        print(f"skipped: this host allows no network namespaces: {why}")
        sys.exit(77)
    os.environ[INSIDE] = "1"
    os.execvp("unshare", [*words, sys.executable, *sys.argv])


if __name__ == "__main__":
    if sys.argv[1] == "--press":
        signal.signal(signal.SIGTERM, lambda *_: os._exit(0))
        press_in_python(sys.argv[2], "udp" in sys.argv[3:])
    if INSIDE not in os.environ:
        enter()
    HAPTICD, HAPTICCTL, GRASP, SCENE = sys.argv[1:5]
    unittest.main(argv=[sys.argv[0], *sys.argv[5:]], verbosity=2)
