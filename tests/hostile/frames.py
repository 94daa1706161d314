"""HTTP/2 by hand (RFC 9113), for requests that no library would send: frames, HPACK without
compression, one gRPC call."""

import os
import select
import socket
import struct
import time

PREFACE = b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n"
(DATA, HEADERS, PRIORITY, RST_STREAM, SETTINGS, PUSH_PROMISE, PING, GOAWAY, WINDOW_UPDATE,
 CONTINUATION) = range(10)
ACK = END_STREAM = 0x1
END_HEADERS, PADDED = 0x4, 0x8
SERVICE = "/haptic.v1.HapticService/"
REQUEST = (":method", "POST"), (":scheme", "http"), (":authority", "hapticd")
GRPC = ("te", "trailers"), ("content-type", "application/grpc")


def frame(kind, flags, stream, payload=b"", length=None):
    """`length`: what the header says, if not the truth."""
    size = len(payload) if length is None else length
    return struct.pack(">I", size)[1:] + struct.pack(">BBI", kind, flags, stream) + payload


def integer(value, bits, first=0):
    """RFC 7541, 5.1."""
    most = (1 << bits) - 1
    if value < most:
        return bytes([first | value])
    out = bytearray([first | most])
    value -= most
    while value >= 128:
        out.append(value % 128 + 128)
        value //= 128
    return bytes(out) + bytes([value])


def literal(name, value):
    """A header field without indexing (RFC 7541, 6.2.2)."""
    name, value = (v.encode() if isinstance(v, str) else v for v in (name, value))
    return b"\0" + integer(len(name), 7) + name + integer(len(value), 7) + value


def block(*fields):
    return b"".join(literal(name, value) for name, value in fields)


def call(path, *extra):
    """The header block of a gRPC call."""
    return block(*REQUEST, (":path", path), *GRPC, *extra)


def message(payload, compressed=False):
    return struct.pack(">BI", compressed, len(payload)) + payload


def connect(address, timeout=5.0):
    """A socket to ("host", port) or to a path."""
    kind = socket.AF_UNIX if isinstance(address, str) else socket.AF_INET
    end = socket.socket(kind, socket.SOCK_STREAM)
    try:
        end.settimeout(timeout)
        end.connect(address)
    except OSError:
        end.close()
        raise
    return end


class Peer:
    """One connection. `polite`: acknowledges SETTINGS and PING, and gives window back."""

    def __init__(self, address, polite=True, settings=b"", timeout=5.0):
        self.socket = connect(address, timeout)
        self.polite, self.sent, self.buffer, self.closed = polite, 0, b"", False
        self.next_stream = 1
        self.send(PREFACE + frame(SETTINGS, 0, 0, settings))

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.socket.close()

    def send(self, data):
        """False once the server has closed, or takes no more for the socket's timeout."""
        if self.closed:
            return False
        try:
            self.socket.sendall(data)
            self.sent += len(data)
            return True
        except OSError:
            self.closed = True
            return False

    def stream(self):
        number, self.next_stream = self.next_stream, self.next_stream + 2
        return number

    def read(self, seconds=0.0):
        """The frames that come within `seconds`, as (kind, flags, stream, payload)."""
        end = time.monotonic() + seconds
        while not self.closed:
            while len(self.buffer) >= 9:
                size = int.from_bytes(self.buffer[:3], "big")
                if len(self.buffer) < 9 + size:
                    break
                kind, flags, stream = struct.unpack(">BBI", self.buffer[3:9])
                payload, self.buffer = self.buffer[9:9 + size], self.buffer[9 + size:]
                self.answer(kind, flags, payload)
                yield kind, flags, stream & 0x7fffffff, payload
            left = max(0.0, end - time.monotonic())
            ready = select.poll()  # select() knows no descriptor above 1023
            ready.register(self.socket, select.POLLIN)
            if not ready.poll(1e3 * left):
                return
            try:
                came = self.socket.recv(1 << 16)
            except OSError:
                came = b""
            self.closed = not came
            self.buffer += came

    def answer(self, kind, flags, payload):
        if not self.polite:
            return
        if kind == SETTINGS and not flags & ACK:
            self.send(frame(SETTINGS, ACK, 0))
        elif kind == PING and not flags & ACK:
            self.send(frame(PING, ACK, 0, payload))
        elif kind == DATA and payload:
            self.send(frame(WINDOW_UPDATE, 0, 0, struct.pack(">I", len(payload))))

    def drain(self, seconds=0.0):
        """Reads and counts, and forgets."""
        return sum(1 for _ in self.read(seconds))

    def unary(self, method, payload=b"", seconds=1.0):
        """The answer's bytes; None: no answer, or a refusal."""
        number = self.stream()
        self.send(frame(HEADERS, END_HEADERS, number, call(SERVICE + method)) +
                  frame(DATA, END_STREAM, number, message(payload)))
        answer = b""
        for kind, flags, stream, came in self.read(seconds):
            if stream == number and kind == DATA:
                answer += came
            if stream == number and (flags & END_STREAM or kind == RST_STREAM):
                break
        return answer[5:] if len(answer) >= 5 else None


def served(address, seconds=1.0):
    """Whether a new connection gets an answer to GetServerInfo within that time."""
    try:
        with Peer(address, timeout=seconds) as peer:
            return peer.unary("GetServerInfo", seconds=seconds) is not None
    except OSError:
        return False


def junk(size):
    return os.urandom(size)
