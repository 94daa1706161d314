"""Datagrams: forged, replayed, damaged, sealed by a client with keys of its own."""

import os
import pathlib
import shutil
import socket
import subprocess
import sys
import time

from daemon import Daemon

sys.path.insert(0, str(pathlib.Path(__file__).parent.parent / "interop"))
LAST = 2**64 - 1


class Path:
    """An observer's or controller's UDP path, used by hand. States come down after a round of
    challenges."""

    def __init__(self, daemon, **fields):
        import datagram
        from calls import Session, stub
        self.datagram, self.calls = datagram, stub(daemon)
        for _ in range(20):  # the session before may end a moment later than its call
            self.session = Session(self.calls, udp_wanted=True,
                                   **{"device": "spare", "state_rate_hz": 20.0, **fields})
            if self.session.open():
                break
            time.sleep(0.05)
        else:
            raise RuntimeError(f"no session: {self.session.status}")
        offer = self.session.opened.udp
        if not offer.path_id:
            raise RuntimeError(f"no UDP path: {self.session.opened.udp_refused}")
        self.offer = offer
        self.sealer = datagram.Sealer(offer.path_id, offer.up_key, offer.up_salt)
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.address = ("127.0.0.1", offer.port)
        self.socket.connect(self.address)
        self.socket.setblocking(False)
        self.sent = self.got = 0

    def send(self, data, count=1):
        for _ in range(count):
            try:
                self.socket.send(data)
                self.sent += len(data)
            except OSError:
                pass

    def seal(self, kind, payload, number=None):
        return self.sealer.seal(kind, payload, number)

    def challenge(self, size=1168):
        return self.seal(self.datagram.PATH_CHALLENGE, os.urandom(8).ljust(size, b"\0"))

    def sample(self, number=None, **more):
        from calls import HELD, wire
        self.session.seq += 1
        return self.seal(self.datagram.PROXY, wire.ProxySample(
            **{"seq": self.session.seq, "mode": HELD, "position": [0.0],
               **more}).SerializeToString(), number)

    def answers(self, seconds=0.2):
        """Counts what comes back."""
        end, count = time.monotonic() + seconds, 0
        while time.monotonic() < end:
            try:
                self.socket.recv(2048)
                count += 1
            except OSError:
                time.sleep(0.002)
        return count

    def up(self):
        """The counters of our datagrams, as the server gives them."""
        from calls import service
        for link in self.calls.GetLinkStats(service.GetLinkStatsRequest(), timeout=2.0).sessions:
            if link.client_name == "attacker":
                for transport in link.transports:
                    if transport.transport == 2:
                        return transport.up
        return None

    def accepted(self):
        time.sleep(0.15)
        return self.session.ack.accepted if self.session.ack else 0

    def end(self):
        self.socket.close()
        self.session.end()


def replay(daemon):
    """Genuine samples again and again, also long after."""
    path = Path(daemon)
    taken = [path.sample() for _ in range(50)]
    for datagram in taken:
        path.send(datagram)
        time.sleep(0.010)
    before = path.accepted()
    for _ in range(40):
        for datagram in taken:
            path.send(datagram)
    grew = path.accepted() - before
    sent = path.sent
    path.end()
    return {"sent": sent, "wrong": [f"{grew} replayed samples accepted"] if grew else [],
            "notes": [f"{before} accepted once"]}


def tampered(daemon):
    """Every bit of a genuine sample flipped, and every header field changed."""
    path = Path(daemon)
    genuine = path.sample()
    for bit in range(8 * len(genuine)):
        bad = bytearray(genuine)
        bad[bit // 8] ^= 1 << bit % 8
        path.send(bytes(bad))
    got = path.answers(0.3)
    accepted = path.accepted()
    sent = path.sent
    path.end()
    wrong = [f"{accepted} damaged samples accepted"] if accepted else []
    if got:
        wrong.append(f"{got} answers to damaged datagrams")
    return {"sent": sent, "wrong": wrong}


def lengths(daemon):
    """Every length up to 1,300 and some beyond, with a genuine header and without."""
    path = Path(daemon)
    header = path.sample()[:16]
    for size in [*range(0, 1_300), 1_400, 1_472, 8_000, 65_000]:
        path.send((header + os.urandom(size))[:size])
        path.send(os.urandom(size))
    got = path.answers(0.3)
    sent = path.sent
    path.end()
    return {"sent": sent, "wrong": [f"{got} answers"] if got else []}


def leaps(daemon):
    """Packet numbers that leap forward and back."""
    path = Path(daemon)
    numbers = [1, 5_000, 4_500, 3_000, 2**32 - 2, 10, 2**31, 2**32 - 1, 2**32, 2**40, 2**63]
    for number in numbers:
        path.send(path.sample(number))
        time.sleep(0.01)
    accepted = path.accepted()
    sent = path.sent
    path.end()
    return {"sent": sent, "notes": [f"{accepted} of {len(numbers)} accepted"]}


def last_number(daemon):
    """Packet number 2^64 - 1 by a client with genuine keys: the count of what was lost."""
    path = Path(daemon)
    path.send(path.sample(1))
    path.send(path.sample(LAST))
    time.sleep(0.2)
    up = path.up()
    sent = path.sent
    path.end()
    lost = up.lost if up is not None else 0
    wrong = [f"lost is {lost:.2g} after two datagrams"] if lost > 2**33 else []
    return {"sent": sent, "wrong": wrong, "notes": [f"lost {lost}"]}


def rekey(daemon):
    """Numbers past the half of what a key may seal, again and again: new keys, once a minute."""
    path = Path(daemon)
    for i in range(200):
        path.send(path.sample(2**31 + 1 + i))
        path.send(path.challenge(40))
        time.sleep(0.005)
    accepted = path.accepted()
    path.session.stream(0.1, position=[0.0])
    alive = path.session.status == ""
    sent = path.sent
    path.end()
    return {"sent": sent, "wrong": [] if alive else ["the session ended"],
            "notes": [f"{accepted} accepted"]}


def ports(daemon):
    """A genuine client that comes from fifty ports: only answers to its challenges go there."""
    path = Path(daemon)
    ends = []
    for _ in range(50):
        end = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        end.connect(path.address)
        end.setblocking(False)
        end.send(path.sample())
        ends.append(end)
    time.sleep(0.5)
    got = 0
    for end in ends:
        try:
            while end.recv(2048):
                got += 1
        except OSError:
            end.close()
    path.end()
    return {"wrong": [f"{got} datagrams to new addresses"] if got > 60 else [],
            "notes": [f"{got} challenges came"]}


def dead_keys(daemon):
    """The keys of sessions that ended."""
    path = Path(daemon)
    path.end()
    time.sleep(0.2)
    path.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    path.socket.connect(path.address)
    path.socket.setblocking(False)
    for _ in range(500):
        path.send(path.sample())
        path.send(path.challenge())
    got = path.answers(0.3)
    path.socket.close()
    return {"sent": path.sent, "wrong": [f"{got} answers under dead keys"] if got else []}


def junk(daemon):
    """16,000 junk datagrams per second, a third of them with a genuine header."""
    path = Path(daemon)
    header = path.sample()[:16]
    end, count = time.monotonic() + 3.0, 0
    while time.monotonic() < end:
        for size in (32, 40, 100, 1_200):
            path.send(os.urandom(size), 5)
            path.send(header + os.urandom(size - 16), 5)
            path.send(b"hp\x01\x01" + os.urandom(size - 4), 5)
        count += 60
        time.sleep(0.0035)
    got = path.answers(0.2)
    sent = path.sent
    path.end()
    return {"sent": sent, "wrong": [f"{got} answers to junk"] if got > 30 else [],
            "notes": [f"{count} datagrams"]}


def stepped_clock(folder):
    """The wall clock steps by 5 s while datagrams are under way, by a library that changes what
    hapticd hears of it: no lease may end."""
    compiler = shutil.which("cc")
    if compiler is None:
        return {"notes": ["not on this host: no C compiler"]}
    library = f"{folder}/clock.so"
    subprocess.run([compiler, "-shared", "-fPIC", "-O1", "-o", library,
                    str(pathlib.Path(__file__).parent / "stepped_clock.c"), "-ldl"], check=True)
    began = time.monotonic()
    daemon = Daemon(f"{folder}/run", env={"LD_PRELOAD": library, "HAPTIC_STEP_AFTER": "7"})
    try:
        path = Path(daemon)
        while time.monotonic() < began + 8.5:  # the lease is older than its 2 s at the step
            path.send(path.sample())
            time.sleep(0.010)
        ended = [e for e in path.session.events if e in ("LEASE_EXPIRED", "LEASE_ENDED")]
        accepted = path.accepted()
        path.end()
    finally:
        daemon.stop()
    wrong = [f"the lease ended: {ended[0]}"] if ended else []
    if "stepped_clock: 5 s forward" not in daemon.text() or accepted < 50:
        wrong.append(f"the row did not run: {accepted} samples accepted")
    return {"wrong": wrong, "notes": [f"{accepted} samples accepted"]}


def path_churn(daemon):
    """A hundred sessions with a path each, whose challenges are never answered."""
    for _ in range(100):
        path = Path(daemon)
        path.send(path.challenge(), 3)
        path.end()
    return {"notes": ["100 paths"]}

