"""HTTP/1.1 (RFC 9112) and WebSockets (RFC 6455) by hand, for requests and frames that no library
would send. Of the standard library only."""

import base64
import contextlib
import hashlib
import os
import socket
import struct
import time

CONTINUATION, TEXT, BINARY, CLOSE, PING, PONG = 0, 1, 2, 8, 9, 10
SERVICE = "/haptic.v1.HapticService/"
PROTO, JSON = "haptic.v1.proto", "haptic.v1.json"
GUID = "258EAFA5-E914-47DA-95CA-C5AB0DC85B11"


def connect(address, timeout=5.0, tls=None):
    """A socket to ("host", port) or to a path; `tls`: an ssl.SSLContext."""
    kind = socket.AF_UNIX if isinstance(address, str) else socket.AF_INET
    end = socket.socket(kind, socket.SOCK_STREAM)
    try:
        end.settimeout(timeout)
        end.connect(address)
        return tls.wrap_socket(end, server_hostname="localhost") if tls else end
    except OSError:
        end.close()
        raise


def request(method, target, headers=(), body=b"", host="127.0.0.1"):
    """As bytes; Content-Length if there is a body. `host` None: no Host."""
    lines = [f"{method} {target} HTTP/1.1"]
    lines += [f"Host: {host}"] if host is not None else []
    lines += [f"{name}: {value}" for name, value in dict(headers).items()]
    lines += [f"Content-Length: {len(body)}"] if body or method == "POST" else []
    return "\r\n".join(lines).encode("latin-1") + b"\r\n\r\n" + body


def frame(kind, payload=b"", fin=True, mask=True, length=None, reserved=0):
    """`length`: what the header says, if not the truth."""
    size = len(payload) if length is None else length
    head = bytes([(0x80 if fin else 0) | reserved << 4 | kind])
    bit = 0x80 if mask else 0
    if size < 126:
        head += bytes([bit | size])
    elif size < 1 << 16:
        head += bytes([bit | 126]) + struct.pack(">H", size)
    else:
        head += bytes([bit | 127]) + struct.pack(">Q", size)
    if not mask:
        return head + payload
    key = os.urandom(4)
    whole = key * (len(payload) // 4 + 1)
    masked = int.from_bytes(payload, "big") ^ int.from_bytes(whole[:len(payload)], "big")
    return head + key + masked.to_bytes(len(payload), "big")


class Closed(Exception):
    """The far end closed. `code` None: without a close frame."""

    def __init__(self, code=None, reason=""):
        super().__init__(f"{code} {reason}")
        self.code, self.reason = code, reason


class Answer:
    def __init__(self, head, body):
        status, *fields = head.decode("latin-1").split("\r\n")
        self.status, self.body = int(status.split()[1]), body
        self.fields = {}
        for field in fields:
            name, value = field.split(":", 1)
            self.fields[name.lower()] = value.strip()

    def __repr__(self):
        return f"{self.status} {self.body[:200]!r}"


class Http:
    """One connection."""

    def __init__(self, address, timeout=5.0, tls=None):
        self.socket, self.buffer = connect(address, timeout, tls), b""

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.socket.close()

    def send(self, data):
        self.socket.sendall(data)

    def more(self):
        try:
            came = self.socket.recv(1 << 16)
        except ConnectionError:
            came = b""
        if not came:
            raise Closed()
        self.buffer += came

    def take(self, size):
        while len(self.buffer) < size:
            self.more()
        taken, self.buffer = self.buffer[:size], self.buffer[size:]
        return taken

    def answer(self, without_body=False):
        while b"\r\n\r\n" not in self.buffer:
            self.more()
        head, self.buffer = self.buffer.split(b"\r\n\r\n", 1)
        answer = Answer(head, b"")
        if not without_body and answer.status != 101:
            answer.body = self.take(int(answer.fields.get("content-length", 0)))
        return answer

    def ask(self, method, target, headers=(), body=b"", host="127.0.0.1"):
        self.send(request(method, target, headers, body, host))
        return self.answer(without_body=method == "HEAD")

    def closed_within(self, seconds):
        """Whether the far end closes; what comes until then is dropped."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            self.socket.settimeout(max(0.01, end - time.monotonic()))
            try:
                if not self.socket.recv(1 << 16):
                    return True
            except TimeoutError:
                return False
            except OSError:
                return True
        return False


def ask(address, method, target, headers=(), body=b"", host="127.0.0.1", tls=None):
    """One request on a connection of its own."""
    with Http(address, tls=tls) as http:
        return http.ask(method, target, headers, body, host)


class Refused(Exception):
    """The upgrade was."""

    def __init__(self, answer):
        super().__init__(repr(answer))
        self.answer = answer


class WebSocket(Http):
    """A client's end. Pings are answered, unless `polite` is false."""

    def __init__(self, address, protocols=(PROTO,), headers=(), target=SERVICE + "Session",
                 host="127.0.0.1", polite=True, timeout=5.0, tls=None):
        super().__init__(address, timeout, tls)
        self.polite, self.parts = polite, None
        key = base64.b64encode(os.urandom(16)).decode()
        try:
            answer = self.ask("GET", target, {
                "Upgrade": "websocket", "Connection": "Upgrade", "Sec-WebSocket-Version": "13",
                "Sec-WebSocket-Key": key, "Sec-WebSocket-Protocol": ", ".join(protocols),
                **dict(headers)}, host=host)
            if answer.status != 101:
                raise Refused(answer)
        except BaseException:
            self.socket.close()
            raise
        proof = base64.b64encode(hashlib.sha1((key + GUID).encode()).digest()).decode()
        assert answer.fields["sec-websocket-accept"] == proof, answer.fields
        self.protocol = answer.fields.get("sec-websocket-protocol")

    def frame(self):
        """(kind, whether it is the last of its message, payload)."""
        first, second = self.take(2)
        assert not second & 0x80, "a server does not mask"
        size = second & 0x7f
        if size >= 126:
            size = int.from_bytes(self.take(2 if size == 126 else 8), "big")
        return first & 0x0f, bool(first & 0x80), self.take(size)

    def receive(self):
        """The next message, as (kind, payload); kind PONG: the answer to a ping. Raises Closed."""
        while True:
            kind, last, payload = self.frame()
            if kind == CLOSE:
                code = struct.unpack(">H", payload[:2])[0] if payload else None
                with contextlib.suppress(OSError):
                    self.send(frame(CLOSE, payload[:2]))
                raise Closed(code, payload[2:].decode())
            if kind == PING:
                if self.polite:
                    self.send(frame(PONG, payload))
            elif kind == PONG:
                return kind, payload
            else:
                self.parts = (kind, payload) if kind else (self.parts[0], self.parts[1] + payload)
                if last:
                    return self.parts

    def end_within(self, seconds):
        """The Closed with which the far end ends this; None: it does not."""
        end = time.monotonic() + seconds
        try:
            while time.monotonic() < end:
                self.socket.settimeout(max(0.01, end - time.monotonic()))
                self.receive()
        except TimeoutError:
            return None
        except Closed as closed:
            return closed
        except OSError:
            return Closed()
        return None
