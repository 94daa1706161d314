"""How programs end, and what may not end with them: nine ways of not closing a session, forks, and
Ctrl-C. Each session is the one with most to end: it has force, reconnects and goes by UDP."""

import os
import signal
import socket
import subprocess
import sys
import threading
import time
import unittest
import unittest.mock

import haptic
from hapticd_process import eventually
from one_server import OneServer

LIMIT_S = 60.0  # of a busy machine; a program that hangs does so for ever
BEGIN = """
import atexit, gc, os, signal, sys, threading, time
HERE
import haptic
server = haptic.Connection(sys.argv[1])
session = server.session(client_name="leaver", nominal_rate_hz=100, reconnect=True, re_engage=True)
session.engage_when_ready()
state = session.wait_for_state()
while state.gain < 1.0 or state.carrier != "UDP":
    session.publish(haptic.FREE)
    state = session.wait_for_state()
def freed():  # the lease that nothing takes up again lasts longer
    end = time.monotonic() + 30
    while server.devices()[0].controller == "leaver":
        assert time.monotonic() < end
        time.sleep(0.01)
    return "freed"
print("engaged", flush=True)
"""
LOOP = """
def loop():
    while True:
        session.publish(haptic.FREE)
        session.wait_for_state()
"""


class Exits(OneServer):
    udp = True
    lease_s = 60

    def ends(self, script: str, before: str = "", status: int = 0, says: str = "",
             interrupt: bool = False, farewell: bool = True) -> None:
        client = subprocess.Popen(
            [sys.executable, "-c", BEGIN.replace("HERE", before) + script, self.server.address],
            stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.addCleanup(client.kill)
        assert client.stdout is not None
        self.assertEqual(client.stdout.readline(), "engaged\n")
        if interrupt:
            client.stdout.readline()
            client.send_signal(signal.SIGINT)
        output, complaint = client.communicate(timeout=LIMIT_S)
        self.assertEqual(client.returncode, status, complaint)
        self.assertIn(says, output + complaint)
        if says == "":
            self.assertEqual(complaint, "")
        if farewell:
            self.assertTrue(eventually(lambda: self.connection.devices()[0].controller == ""))

    def test_returning_from_main(self) -> None:
        self.ends("")

    def test_an_exception_in_main(self) -> None:
        self.ends("1 / 0", status=1, says="ZeroDivisionError")

    def test_sys_exit_in_a_thread(self) -> None:
        self.ends("thread = threading.Thread(target=sys.exit)\nthread.start()\nthread.join()\n"
                  "sys.exit(3)", status=3)

    def test_ctrl_c_while_waiting(self) -> None:
        self.ends("print('waits', flush=True)\nwhile True: session.wait_for_state(60)",
                  status=-signal.SIGINT, says="KeyboardInterrupt", interrupt=True)

    def test_del_of_the_session(self) -> None:
        self.ends("del session\nprint(freed())", says="freed")

    def test_a_cycle_that_only_gc_finds(self) -> None:
        self.ends("class Node: pass\nnode = Node()\nnode.me, node.session = node, session\n"
                  "gc.disable()\ndel node, session\nassert server.devices()[0].controller == "
                  "'leaver'\ngc.collect()\nprint(freed())", says="freed")

    def test_atexit_after_the_librarys_own(self) -> None:
        late = """
def late():
    for call in (lambda: session.publish(haptic.FREE), session.wait_for_state, session.engage):
        try:
            call()
        except haptic.ClientError as error:
            print(error.reason)
atexit.register(late)"""
        self.ends("", before=late, says="CLOSED\nCLOSED\nCLOSED\n")

    def test_a_daemon_thread_that_publishes(self) -> None:
        self.ends(LOOP + "for _ in range(3): threading.Thread(target=loop, daemon=True).start()\n"
                  "time.sleep(0.2)")

    def test_a_daemon_thread_that_solves(self) -> None:
        self.ends("def solve():\n    while True: haptic.solve(lambda x: [], (0.1, 0.2), 1.0)\n"
                  "for _ in range(3): threading.Thread(target=solve, daemon=True).start()\n"
                  "time.sleep(0.2)")

    def test_an_interrupted_opening(self) -> None:
        start = threading.Thread.start

        def interrupted(thread: threading.Thread) -> None:
            start(thread)
            thread.join()
            raise KeyboardInterrupt

        with (unittest.mock.patch.object(threading.Thread, "start", interrupted),
              self.assertRaises(KeyboardInterrupt)):
            self.connection.session(client_name="leaver", nominal_rate_hz=60)
        self.assertTrue(eventually(lambda: self.connection.devices()[0].controller == ""))

    def test_os_exit(self) -> None:
        self.ends("os._exit(5)", status=5, farewell=False)


class Forks(OneServer):
    udp = True

    def test_a_child_leaves_all_to_its_parent(self) -> None:
        session = self.open(reconnect=True)
        session.engage_when_ready()
        before = self.hold(session, lambda s: s.state == "ENGAGED" and s.carrier == "UDP")
        published = session.statistics().published
        child = os.fork()
        if child == 0:
            self.in_the_child(session)
        self.assertEqual(os.waitpid(child, 0)[1], 0)
        after = self.hold(session, lambda s: s.proxy_seq_used > published + 100)
        self.assertEqual((after.state, after.carrier, after.lease_epoch),
                         ("ENGAGED", "UDP", before.lease_epoch))
        counted = session.statistics()
        self.assertEqual((counted.rejected_old, counted.rejected_invalid), (0, 0))

    def in_the_child(self, session: haptic.Session) -> None:
        """Every call raises; then it ends as programs do, the library's exit handler included."""
        signal.alarm(int(LIMIT_S))
        connection = self.connection
        calls = (lambda: session.publish(haptic.FREE), session.wait_for_state, session.events,
                 lambda: session.state, session.engage, session.engage_when_ready, session.release,
                 session.statistics, session.update_settings, session.close, connection.devices,
                 connection.emergency_stop, connection.clear_fault, connection.close,
                 lambda: haptic.Connection(self.server.address))
        wrong = []
        for i, call in enumerate(calls):
            try:
                call()
                wrong.append(i)
            except haptic.ClientError as error:
                if error.reason != "CLOSED" or "forked" not in error.message:
                    wrong.append((i, str(error)))
        try:
            with session:
                pass
            subprocess.run(["true"], check=True)
        finally:
            print(*wrong, file=sys.stderr, end="")
            for handler in (haptic._library._end,):  # os._exit() skips it
                handler()
            os._exit(len(wrong))


class Interrupts(OneServer):
    """Ctrl-C ends every wait within 0.2 s, of whatever the main thread waits for. For a calm
    host."""

    def interrupted_after(self, wait: object) -> float:
        sent: list[float] = []

        def interrupt() -> None:
            time.sleep(0.5)
            sent.append(time.monotonic())
            os.kill(os.getpid(), signal.SIGINT)

        thread = threading.Thread(target=interrupt)
        thread.start()
        with self.assertRaises(KeyboardInterrupt):
            wait()
        ended = time.monotonic()
        thread.join()
        return ended - sent[0]

    def test_waits_end_within_200_ms(self) -> None:
        session = self.open(observer=True)
        os.kill(self.server.pid, signal.SIGSTOP)
        self.addCleanup(os.kill, self.server.pid, signal.SIGCONT)
        with socket.socket() as silent:
            silent.bind(("127.0.0.1", 0))
            silent.listen()
            mute = haptic.Connection(f"127.0.0.1:{silent.getsockname()[1]}")
            for wait in (lambda: session.wait_for_state(60.0) and session.wait_for_state(60.0),
                         mute.devices,
                         lambda: mute.session(client_name="x", nominal_rate_hz=60, timeout=60.0)):
                self.assertLess(self.interrupted_after(wait), 0.2)


if __name__ == "__main__":
    unittest.main()
