"""A board on a pseudo-terminal that can lie (hw/README.md, "The board protocol"), in a process of
its own. It holds one DoF in place; its load cell follows the drive."""

import contextlib
import math
import multiprocessing
import os
import select
import struct
import time
import tty

from daemon import in_time

HELLO, ARM, DISARM, COMMAND = 1, 2, 3, 4
IDENTITY, DOF, STATE, COUNTERS = 0x81, 0x82, 0x83, 0x84
DISARMED, ARMED, STOPPED, FAULT = range(4)
CELL_S = 0.004  # lag of the load cell behind the drive


def table():
    out = []
    for byte in range(256):
        for _ in range(8):
            byte = (byte >> 1) ^ (0x82f63b78 if byte & 1 else 0)
        out.append(byte)
    return out


TABLE = table()


def crc32c(data):
    crc = 0xffffffff
    for byte in data:
        crc = (crc >> 8) ^ TABLE[(crc ^ byte) & 0xff]
    return crc ^ 0xffffffff


def cobs(body):
    return b"".join(bytes([len(part) + 1]) + part for part in body.split(b"\0"))


def uncobs(data):
    """None: no COBS."""
    out, at = [], 0
    while at < len(data):
        code = data[at]
        if code == 0 or at + code > len(data):
            return None
        out.append(data[at + 1:at + code])
        at += code
    return b"\0".join(out)


def frame(kind, seq, payload):
    body = struct.pack("<BI", kind, seq & 0xffffffff) + payload
    return b"\0" + cobs(body + struct.pack("<I", crc32c(body))) + b"\0"


def frames(data):
    """(kind, seq, payload) of each good frame, and what is left over."""
    *whole, rest = data.split(b"\0")
    found = []
    for part in whole:
        body = uncobs(part) if part else None
        if body and len(body) >= 9 and crc32c(body[:-4]) == int.from_bytes(body[-4:], "little"):
            found.append((body[0], int.from_bytes(body[1:5], "little"), body[5:-4]))
    return found, rest


def text(value, width):
    value = value if isinstance(value, bytes) else value.encode()
    return value[:width].ljust(width, b"\0")


def identity(session, version=1, n_q=1, n_a=1, capabilities=2, watchdog=1_000_000, period=1_000,
             serial=b"LIAR-1", model=b"liar", own_session=None):
    return struct.pack("<BBBBIIIBBBB", version, n_q, n_a, capabilities,
                       session if own_session is None else own_session, watchdog, period,
                       1, 0, 0, 0) + text(serial, 16) + text(model, 24)


def dof(index=0, unit=0, actuated=1, lower=-1.0, upper=1.0, effort=50.0, rate=1.0, name=b"z"):
    return struct.pack("<BBBBffff", index, unit, actuated, 0, lower, upper, effort, rate) + \
        text(name, 16)


def dof_two():
    return dof(1, actuated=0, name=b"y")


class Firmware:
    """One millisecond after the other; `lie(name, fields)` changes what it says."""

    def __init__(self, identity_fields, dofs, lie):
        self.identity_fields, self.dofs, self.lie = identity_fields, dofs, lie
        self.session = self.nonce = self.command_seq = self.seq = 0
        self.state, self.drive, self.cell, self.commanded = DISARMED, 0.0, 0.0, 0.0
        self.drift = 0.0  # N, of a lie
        self.began, self.armings, self.commands, self.said_hello = time.monotonic(), 0, [], 0
        self.nonces = []  # of every ARM, in order; one that is said again stands once

    def say(self, kind, payload):
        self.seq += 1
        return frame(kind, self.seq, payload)

    def hear(self, kind, seq, payload):
        """The answer's bytes."""
        if kind == HELLO and len(payload) == 5:
            session = int.from_bytes(payload[1:], "little")
            self.said_hello += 1
            if session != self.session:
                self.session, self.state, self.nonce = session, DISARMED, 0
            return self.say(IDENTITY, identity(session, **self.identity_fields)) + b"".join(
                self.say(DOF, one) for one in self.dofs)
        if kind == ARM and len(payload) == 4:
            self.armings += 1
            self.nonce, self.state = int.from_bytes(payload, "little"), ARMED
            if self.nonces[-1:] != [self.nonce]:
                self.nonces.append(self.nonce)
        elif kind == DISARM:
            self.state, self.drive = DISARMED, 0.0
            self.commands.append((time.monotonic(), seq, self.nonce, 0.0))
        elif kind == COMMAND and len(payload) >= 10:
            nonce, what, count = struct.unpack_from("<IBB", payload)
            value = struct.unpack_from("<f", payload, 6)[0]
            self.command_seq, self.commanded = seq, time.monotonic()
            self.commands.append((time.monotonic(), seq, nonce, value))
            if self.state == ARMED and nonce == self.nonce:
                self.drive = value
        return b""

    def sample(self, name):
        """What goes out this millisecond."""
        if not self.session:
            return b""
        now = time.monotonic()
        if self.state != ARMED:
            self.drive = 0.0
        self.cell += (self.drive - self.cell) * min(1.0, 0.001 / CELL_S)
        fields = {
            "time": int(1e6 * (now - self.began)), "nonce": self.nonce, "seq": self.command_seq,
            "age": min(65_534, int(1e6 * (now - self.commanded))) if self.commanded else 65_535,
            "state": self.state, "faults": 0, "q": [0.001 * math.sin(now)], "force": [self.cell],
            "raw": None, "kind": STATE, "now": now, "board": self,
        }
        if name:
            self.lie(name, fields)
        if fields["raw"] is not None:
            return fields["raw"]
        f = fields
        payload = struct.pack("<QIIHBBBB", f["time"] & (2**64 - 1), f["nonce"] & 0xffffffff,
                              f["seq"] & 0xffffffff, f["age"], f["state"], f["faults"],
                              f.get("n_q", len(f["q"])), f.get("n_f", len(f["force"])))
        payload += struct.pack(f"<{len(f['q'])}f", *f["q"])
        payload += struct.pack(f"<{len(f['force'])}f", *f["force"])
        return self.say(f["kind"], payload)


class Board:
    """In a process of its own: start it before anything that does not survive a fork."""

    def __init__(self, identity_fields=(), dofs=None, lie=None):
        self.master, self.slave = os.openpty()
        tty.setraw(self.slave)
        os.set_blocking(self.master, False)
        self.port = os.ttyname(self.slave)
        context = multiprocessing.get_context("fork")
        self.lying = context.Array("c", 40)
        self.armings, self.hellos = context.Value("i", 0), context.Value("i", 0)
        self.here, there = context.Pipe()
        self.process = context.Process(target=self.run, daemon=True, args=(
            there, Firmware(dict(identity_fields), [dof()] if dofs is None else dofs, lie)))
        self.process.start()

    def run(self, pipe, firmware):
        in_time()  # a board has a clock of its own, however busy this host is
        rest, due = b"", time.monotonic()
        while True:
            with contextlib.suppress(BlockingIOError, OSError):
                heard, rest = frames(rest + os.read(self.master, 4096))
                for one in heard:
                    self.write(firmware.hear(*one))
            self.write(firmware.sample(self.lying.value.decode()))
            self.armings.value, self.hellos.value = firmware.armings, firmware.said_hello
            if pipe.poll():
                if pipe.recv() == "nonces":
                    pipe.send(firmware.nonces)
                else:
                    pipe.send(firmware.commands)
                    firmware.commands = []
            due = max(due + 0.001, time.monotonic() - 0.01)
            if not firmware.session:  # nothing to say yet, and other boards may be at work
                due = time.monotonic() + 0.010
            select.select([], [], [], max(0.0, due - time.monotonic()))

    def write(self, data):
        with contextlib.suppress(BlockingIOError, OSError):
            os.write(self.master, data)

    def tell(self, lie=""):
        self.lying.value = lie.encode()

    def commands(self):
        """Since the last call: (time, seq, nonce, newtons); a DISARM is 0 N."""
        self.here.send("commands")
        return self.here.recv()

    def nonces(self):
        """Of every arming so far."""
        self.here.send("nonces")
        return self.here.recv()

    def end(self):
        self.process.kill()
        self.process.join()
        os.close(self.master)
        os.close(self.slave)
