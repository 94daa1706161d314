"""Client, relay, server and board of a grasp: started in every order, and each killed in every
phase. A service manager is played: a server that ends is started again."""

import concurrent.futures
import itertools
import os
import pathlib
import signal
import socket
import subprocess
import time

from daemon import Controller, Daemon, free_port
from judge import judge_ticks, read_record

SCENARIO = pathlib.Path(__file__).parent.parent / "relay" / "scenarios" / "clean.textproto"
DEVICE = """
device {{
  name: "finger"
  board {{ port: "{port}" max_effort: 40 max_silence {{ nanos: 100000000 }} }}
  finger_exoskeleton {{}}
  subspace_linear {{}}
  direction_guard {{}}
  impedance {{ stiffness_n_per_m: 500 damping_n_s_per_m: 0.5 }}
  limits {{ force_n: 20 }}
}}
loop {{ loop_late_fault {{ nanos: 900000000 }} late_bucket_full: 1000000 }}
"""
BACK_S = 15.0
BESIDE = 4  # grasps at a time: each has programs, ports and a folder of its own


class Parts:
    """The four programs, each of which may be started and killed at any time."""

    def __init__(self, folder):
        self.folder = pathlib.Path(folder)
        self.folder.mkdir(parents=True, exist_ok=True)
        self.port, self.link = free_port(socket.SOCK_STREAM), self.folder / "board"
        self.controller = self.process_relay = self.process_board = self.daemon = None
        self.runs, self.records, self.wanted = 0, [], False

    def client(self):
        self.controller = Controller(f"127.0.0.2:{self.port}", "finger",
                                     ("-0.05", "-0.02", "relative"))

    def relay(self):
        self.process_relay = subprocess.Popen(
            [os.environ["HAPTIC_RELAY"], "--scenario", SCENARIO, "--tcp", str(self.port)],
            stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)

    def board(self):
        self.process_board = subprocess.Popen(
            [os.environ["HAPTIC_EMULATOR"], "--link", self.link, "--watchdog-ms", "1000",
             "--hand"],
            stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        self.process_board.stdin.write(b"0.5 0.5\n")
        self.process_board.stdin.flush()

    def server(self):
        self.wanted = True
        self.runs += 1
        self.daemon = Daemon(self.folder / str(self.runs), "--listen", f"127.0.0.1:{self.port}",
                             devices=DEVICE.format(port=self.link), wait=False)
        self.records.append(self.folder / str(self.runs) / "run.csv")

    def manage(self):
        """The service manager, and a person who clears faults."""
        if self.wanted and self.daemon.process.poll() is not None:
            time.sleep(0.2)
            self.server()
        if self.controller is not None and self.controller.state == "FAULT":
            self.clear()

    def clear(self):
        from daemon import CONTROL
        subprocess.run([CONTROL, "--server", f"127.0.0.1:{self.port}", "clear-fault"], timeout=6.0,
                       stdin=subprocess.DEVNULL, capture_output=True)

    def engaged(self, seconds=BACK_S, state="ENGAGED"):
        """Seconds until there is force; None: never."""
        began = time.monotonic()
        while self.controller is None or self.controller.state != state:
            if time.monotonic() > began + seconds:
                return None
            self.manage()
            time.sleep(0.02)
        return time.monotonic() - began

    def kill(self, part):
        if part == "client":
            self.controller.kill()
            self.controller = None
        elif part == "server":
            self.daemon.kill()
            self.wanted = False
        else:
            process = self.process_relay if part == "relay" else self.process_board
            process.send_signal(signal.SIGKILL)
            process.wait()

    def end(self):
        if self.controller is not None:
            self.controller.kill()
        for process in (self.process_relay, self.process_board):
            if process is not None and process.poll() is None:
                process.terminate()
                process.wait()
        if self.daemon is not None:
            self.daemon.stop()

    def judge(self, *causes):
        """What no tick of any of its servers may do."""
        for record in self.records:
            if record.exists():
                force, faults = judge_ticks(read_record(record), causes)
                if force or faults:
                    return force or " ".join(faults)
        return ""


LINK = ("DEVICE_SILENT", "DEVICE_LOST")


def beside(grasp, cases):
    """`grasp(*case)`: (what was wrong, or "", seconds until force), several at a time."""
    with concurrent.futures.ThreadPoolExecutor(BESIDE) as pool:
        answers = list(pool.map(lambda case: grasp(*case), cases))
    return {"wrong": [wrong for wrong, _ in answers if wrong][:6],
            "notes": [f"slowest {max(took for _, took in answers):.1f} s"]}


def said_of(parts, name, took):
    """As beside() takes it."""
    said = parts.judge(*LINK) if took is not None else f"no force within {BACK_S:.0f} s"
    return f"{name}: {said}" if said else "", BACK_S if took is None else took


def start_orders(folder):
    """All 24 orders, a quarter of a second apart: force in the end, nothing wrong until then."""
    def start(*order):
        parts = Parts(f"{folder}/{'-'.join(order)}")
        try:
            for part in order:
                getattr(parts, part)()
                end = time.monotonic() + 0.25
                while time.monotonic() < end:
                    parts.manage()
                    time.sleep(0.05)
            took = parts.engaged()
        finally:
            parts.end()
        return said_of(parts, " ".join(order), took)
    return beside(start, itertools.permutations(("client", "relay", "server", "board")))


def killed_in_phases(folder):
    """Each of the four killed while it waits for force, while force rises, and under force; and
    started again: no force from before, and force in the end."""
    def grasp(phase, part):
        parts = Parts(f"{folder}/{phase}-{part}")
        try:
            for other in ("board", "server", "relay", "client"):
                getattr(parts, other)()
            if parts.engaged(state=phase) is None:
                return f"{part}: never {phase} in {BACK_S:.0f} s", BACK_S
            parts.kill(part)
            time.sleep(0.4)
            getattr(parts, part)()
            took = parts.engaged()
        finally:
            parts.end()
        return said_of(parts, f"{part}, {phase}", took)
    return beside(grasp, itertools.product(("ARMED", "ENGAGING", "ENGAGED"),
                                           ("client", "relay", "server", "board")))


def start_inside(daemon):
    """A client that starts while the finger is inside its object: no force with a proxy that was
    held all the time, be it far or near; force with one that was free once, or with planes."""
    from calls import FREE, HELD, OPERATOR, PLANES, Session, grpc, service, stub, wire
    calls, wrong = stub(daemon), []

    def engage(session, what, wanted):
        refused = ""
        try:
            calls.Engage(service.EngageRequest(session_id=session.opened.session_id), timeout=2.0)
        except grpc.RpcError as error:
            refused = error.details()
        if wanted not in refused or not wanted and refused:
            wrong.append(f"Engage {what}: {refused or 'granted'}")

    session = Session(calls, priority=OPERATOR)
    if not session.open():
        return {"wrong": [f"no session: {session.status}"]}
    for what, position in (("far inside", (-0.4, 0.0)), ("at the probe", session.place())):
        session.stream(0.6, position=position, mode=HELD)
        engage(session, what, "free for a few samples")
        if session.state.gain or not session.state.limiters & 1 << 16:  # NEVER_FREE
            wrong.append(f"{what}: gain {session.state.gain}, limiters {session.state.limiters}")
    session.stream(0.1, mode=FREE)
    session.stream(0.3, position=session.place(), mode=HELD)
    engage(session, "after a free proxy", "")
    session.stream(0.5, position=(0.0, 0.5236))
    session.queue.put(wire.SessionRequest(leave=wire.LeaveSession()))
    time.sleep(0.3)
    session.end()
    session = Session(calls, priority=OPERATOR)
    if not session.open():
        return {"wrong": [*wrong, f"no second session: {session.status}"]}
    mcp, pip = session.place()
    plane = wire.Plane(normal=(1, 0), offset=mcp - 0.02)
    session.stream(0.5, position=(mcp, pip), mode=PLANES, planes=[plane])
    engage(session, "inside planes", "")
    session.stream(0.5, position=(mcp, pip), mode=PLANES, planes=[plane])
    session.end()
    return {"wrong": wrong}
