"""Signals, ports and standard streams; text that goes to the log."""

import contextlib
import os
import pathlib
import signal
import socket
import time

from daemon import FINGER, Controller, Daemon, control
from files import run
from frames import END_HEADERS, HEADERS, PREFACE, SERVICE, Peer, call, connect, frame, served
from judge import TERM_S, judge_ticks, read_record

DIRTY = "evil\x1b[31m\n2026 forged line\u009b2J\u202e\u2066\u200f\x7f\x00end"


def dirty(log):
    """Bytes in a log that move the cursor, forge a line or turn text around; empty: none."""
    found = [hex(byte) for byte in set(log) if byte < 32 and byte != 10 or byte == 127]
    text = log.decode(errors="replace")
    found += [hex(ord(c)) for c in set(text)
              if 0x80 <= ord(c) < 0xa0 or 0x202a <= ord(c) <= 0x202e or
              0x2066 <= ord(c) <= 0x2069 or ord(c) in (0x200e, 0x200f, 0xfffd)]
    if "\n2026 forged line" in text:
        found.append("a forged line")
    return found


def log_text(folder):
    """Names and reasons with ESC, newline, U+009B and bidi overrides: the log stays clean."""
    daemon = Daemon(folder, record=False)
    try:
        from calls import OBSERVER, Session, outcome, service, stub
        calls = stub(daemon)
        for name in (DIRTY.replace("\0", ""), "\u009b", "\u202e" * 10, "a\u2028b\u2029c"):
            for device in ("spare", name):
                session = Session(calls, device=device, client_name=name[:16], role=1)
                session.open(1.0)
                session.end()
            observer = Session(calls, role=OBSERVER, client_name=name[:16])
            observer.open(1.0)
            observer.end()
            outcome(calls.EmergencyStop, service.EmergencyStopRequest(reason=name, device="spare"))
            outcome(calls.EmergencyStop, service.EmergencyStopRequest(reason="x", device=name))
        control(daemon, "--device", "spare", "estop", "--reason", DIRTY.replace("\0", ""))
    finally:
        daemon.stop()
    found = dirty(daemon.log.read_bytes())
    return {"wrong": [f"in the log: {' '.join(sorted(found))}"] if found else []}


def idle(daemon):
    pass


def silent_peers(daemon):
    ends = [connect(daemon.tcp) for _ in range(50)] + [connect(daemon.unix) for _ in range(50)]
    for end in ends[::2]:
        end.sendall(PREFACE)
    return ends


def half_streams(daemon):
    peers = [Peer(daemon.tcp) for _ in range(10)]
    for peer in peers:
        for _ in range(50):
            peer.send(frame(HEADERS, END_HEADERS, peer.stream(), call(SERVICE + "Session")))
    return peers


def unread_watches(daemon):
    import struct
    from frames import DATA, END_STREAM, message
    request = message(b"\x0a\x06finger\x11" + struct.pack("<d", 1000.0))
    peers = [Peer(daemon.tcp, polite=False) for _ in range(10)]
    for peer in peers:
        number = peer.stream()
        peer.send(frame(HEADERS, END_HEADERS, number, call(SERVICE + "Watch")) +
                  frame(DATA, END_STREAM, number, request))
    return peers


def slow_scrapes(daemon):
    ends = [connect(("127.0.0.1", daemon.metrics)) for _ in range(5)]
    for end in ends:
        end.sendall(b"GET /metrics HTTP/1.1\r\nX: y")
    return ends


def junk_datagrams(daemon):
    end = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    end.connect(("127.0.0.1", daemon.udp))
    for _ in range(2_000):
        with contextlib.suppress(OSError):
            end.send(os.urandom(100))
    return end


def pressing(daemon):
    controller = Controller(daemon.address)
    controller.engaged_within(10.0)
    return controller


def stopped(daemon):
    control(daemon, "estop")


def stopped_under_force(daemon):
    controller = pressing(daemon)
    control(daemon, "--device", "finger", "estop")
    return controller


def opening(daemon):
    controller = Controller(daemon.address)
    time.sleep(0.45)  # before force
    return controller


SITUATIONS = (idle, silent_peers, half_streams, unread_watches, slow_scrapes, junk_datagrams,
              pressing, stopped, stopped_under_force, opening)


def sigterm(folder):
    """SIGTERM in fifteen situations: within 5 s, with status 0, force fades; SIGINT too."""
    wrong, slowest = [], 0.0

    def judge(name, took, status, daemon):
        nonlocal slowest
        slowest = max(slowest, took)
        if took > TERM_S or status != 0:
            wrong.append(f"{name}: status {status} after {took:.1f} s")
        if daemon.record.exists():
            force, faults = judge_ticks(read_record(daemon.record), ("EMERGENCY_STOP",))
            if force or faults:
                wrong.append(f"{name}: {force or faults}")
    for situation in SITUATIONS:
        daemon = Daemon(f"{folder}/{situation.__name__}")
        held = situation(daemon)
        judge(situation.__name__, *daemon.stop(), daemon)
        if isinstance(held, Controller):
            held.kill()
    for after in (0.0, 0.03, 0.1, 0.3):  # of the start, before it can have a handler
        daemon = Daemon(f"{folder}/after-{after}", wait=False)
        time.sleep(after)
        took, status = daemon.stop()
        if took > TERM_S or status not in (0, -signal.SIGTERM):
            wrong.append(f"{after} s after the start: status {status} after {took:.1f} s")
    daemon = Daemon(f"{folder}/int")
    held = pressing(daemon)
    daemon.process.send_signal(signal.SIGINT)
    judge("SIGINT", *daemon.stop(), daemon)
    held.kill()
    return {"wrong": wrong, "notes": [f"slowest {slowest:.1f} s"]}


def many_signals(folder):
    """Two hundred that must not matter, under force; then SIGTERM fifty times."""
    wrong = []
    daemon = Daemon(folder)
    controller = pressing(daemon)
    for i in range(200):
        daemon.process.send_signal((signal.SIGCHLD, signal.SIGWINCH, signal.SIGURG, signal.SIGCONT,
                                    signal.SIGPIPE)[i % 5])
        time.sleep(0.004)
    if daemon.process.poll() is not None:
        wrong.append(f"ended with {daemon.process.returncode}")
    elif controller.engaged_within(3.0) is None:
        wrong.append("no force afterwards")
    began = time.monotonic()
    for _ in range(50):
        with contextlib.suppress(ProcessLookupError):
            daemon.process.send_signal(signal.SIGTERM)
        time.sleep(0.002)
    took, status = daemon.stop()
    controller.kill()
    if status != 0 or time.monotonic() - began > TERM_S:
        wrong.append(f"status {status} after {took:.1f} s")
    force, faults = judge_ticks(read_record(daemon.record))
    return {"wrong": wrong + ([force] if force else []) + faults}


def sigstop(folder):
    """Stopped for 3 s under force: a late loop is a fault, and there is no force from before."""
    daemon = Daemon(folder)
    controller = pressing(daemon)
    os.kill(daemon.pid, signal.SIGSTOP)
    time.sleep(3.0)
    os.kill(daemon.pid, signal.SIGCONT)
    began = time.monotonic()
    back = served(daemon.tcp)
    took_back = time.monotonic() - began
    time.sleep(0.5)
    took, status = daemon.stop()
    controller.kill()
    force, faults = judge_ticks(read_record(daemon.record), ("LOOP_LATE",))
    wrong = [force] if force else []
    if not back:
        wrong.append("not served within 1 s")
    if status != 0 or took > TERM_S or faults:
        wrong.append(f"status {status} after {took:.1f} s, faults {faults}")
    return {"wrong": wrong, "notes": [f"served after {1e3 * took_back:.0f} ms"]}


def taken_ports(folder):
    """Each address in use by another: refused with a word, status 1; the other is not disturbed."""
    first = Daemon(f"{folder}/first", record=False)
    wrong = []
    scene = pathlib.Path(folder) / "scene.textproto"
    for field, value in (("listen", first.address), ("udp_listen", f"127.0.0.1:{first.udp}"),
                         ("metrics_listen", f"127.0.0.1:{first.metrics}")):
        listen = "" if field == "listen" else 'listen: "127.0.0.1:0" '
        scene.write_text(f'name: "a"\n{FINGER}server {{ {listen}{field}: "{value}" }}\n')
        status, words, took = run(["--scene", scene], 5.0)
        if status != 1 or value not in words:
            wrong.append(f"{field}: status {status} after {took:.1f} s: {words[-80:]}")
    scene.write_text(f'name: "a"\n{FINGER}server {{ listen: "unix:{first.unix}" }}\n')
    status, words, took = run(["--scene", scene], 3.0)
    if not served(first.unix):
        wrong.append(f"the UNIX socket of a running hapticd was taken (status {status})")
    first.stop()
    return {"wrong": wrong, "notes": [f"the same UNIX socket: status {status}"]}


def stale_socket(folder):
    """A socket's file that a killed hapticd left; a plain file in its place."""
    wrong = []
    daemon = Daemon(folder, record=False)
    daemon.kill()
    if not os.path.exists(daemon.unix):
        wrong.append("the row did not run: no stale socket")
    again = Daemon(folder, record=False)
    if not served(again.unix):
        wrong.append("not served at the stale socket's path")
    again.stop()
    plain = pathlib.Path(folder) / "plain"
    plain.write_text("precious")
    scene = pathlib.Path(folder) / "plain.textproto"
    scene.write_text(f'name: "a"\n{FINGER}server {{ listen: "unix:{plain}" }}\n')
    status, words, _ = run(["--scene", scene], 2.0)
    if not plain.is_file() or plain.read_text() != "precious":
        wrong.append(f"a plain file was replaced by a socket (status {status})")
    return {"wrong": wrong}


def closed_stdio(folder):
    """Without standard streams, and with full ones: serves; no log in the recording."""
    wrong = []

    def closed():
        for number in (0, 1, 2):
            os.close(number)
    pid = os.fork()  # subprocess always gives three streams
    if pid == 0:
        daemon = Daemon(f"{folder}/closed", wait=False)  # for its scene; ended at once
        daemon.kill()
        scene = f"{folder}/closed/scene.textproto"
        pathlib.Path(f"{folder}/closed/port").write_text(str(daemon.port))
        closed()
        os.execv(os.environ["HAPTICD"], [os.environ["HAPTICD"], "--scene", scene])
    port = pathlib.Path(f"{folder}/closed/port")
    end, up = time.monotonic() + 8.0, False
    while time.monotonic() < end and not up:
        time.sleep(0.05)
        up = port.exists() and served(("127.0.0.1", int(port.read_text() or 1)), 0.5)
    if not up:
        wrong.append("closed: does not serve")
    time.sleep(0.5)
    with contextlib.suppress(ProcessLookupError):
        os.kill(pid, signal.SIGTERM)
    status = os.waitpid(pid, 0)[1]
    if status != 0:
        wrong.append(f"closed: ended with {status}")
    for file in pathlib.Path(f"{folder}/closed").glob("run*.csv"):
        lines = file.read_bytes().split(b"\n")
        if any(line.count(b",") != lines[0].count(b",") for line in lines[1:-1]):
            wrong.append(f"{file.name} holds other text")
    with open("/dev/full", "wb") as full:
        daemon = Daemon(f"{folder}/full", wait=False, stdout=full, stderr=full)
    with contextlib.suppress(RuntimeError):
        daemon.wait_served(8.0)
    up = daemon.process.poll() is None and served(daemon.tcp)
    took, status = daemon.stop()
    if not up or status != 0 or took > TERM_S:
        wrong.append(f"/dev/full: served {up}, ended with {status} after {took:.1f} s")
    return {"wrong": wrong}
