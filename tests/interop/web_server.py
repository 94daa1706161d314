"""A hapticd that serves browsers too, and one session of a client by WebSocket."""

import json
import os
import re
import subprocess
import sys
import tempfile
import time

import grpc

from server_process import Server, argument, eventually

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "support"))
sys.path.insert(0, argument("HAPTIC_PYTHON_PROTO"))
from haptic.v1 import session_pb2  # noqa: E402
from google.protobuf import json_format  # noqa: E402
from web_socket import BINARY, JSON, TEXT, Closed, WebSocket, ask, frame  # noqa: E402

ORIGIN = "https://lab.example"
OBSERVER, PRIMARY = "observer-0123456789", "primary-0123456789"


class WebServer(Server):
    """`tls`: fields of the scene's."""

    def __init__(self, program, tls="", printed="observe"):
        self.encrypted = bool(tls)
        self.folder = tempfile.TemporaryDirectory()
        tokens = ""
        for name, text, rights in (("guest", OBSERVER, "observe"), ("lab", PRIMARY, "primary")):
            path = os.path.join(self.folder.name, name)
            with open(os.open(path, os.O_CREAT | os.O_WRONLY, 0o600), "w") as file:
                file.write(text + "\n")
            tokens += f'token {{ name: "{name}" file: "{path}" rights: "{rights}" }}\n'
        self.unix = os.path.join(self.folder.name, "web")
        self.log_file = open(os.path.join(self.folder.name, "log"), "w+b")
        super().__init__(program, stderr=self.log_file, server=(
            f'web {{ listen: "127.0.0.1:0" listen: "127.0.0.1:0" listen: "unix:{self.unix}"\n'
            f'  name: "hapticd.example" origin: "{ORIGIN}" printed: "{printed}" {tokens} }} {tls}'))

    def __enter__(self):
        eventually(lambda: b"page: " in self.log(), "the page's address is printed")
        self.web = ("127.0.0.1", int(re.search(rb"page: https?://[^:]*:(\d+)/",
                                               self.log()).group(1)))
        if self.encrypted:  # gRPC would need a certificate
            self.channel = grpc.insecure_channel(self.address)
            return self
        return super().__enter__()

    def __exit__(self, *why):
        """SIGTERM."""
        super().__exit__(*why)
        self.log_file.close()
        self.folder.cleanup()

    def log(self):
        with open(self.log_file.name, "rb") as file:
            return file.read()

    def one_time(self):
        """The token of the newest printed address."""
        return re.findall(rb"/\?token=(\w+)", self.log())[-1].decode()

    def redeem(self, tls=None):
        """(the secret of a cookie, the whole Set-Cookie)."""
        before = self.one_time()
        answer = ask(self.web, "GET", "/?token=" + before, tls=tls)
        assert answer.status == 303 and answer.fields["location"] == "/", answer
        eventually(lambda: self.one_time() != before, "another address is printed")
        cookie = answer.fields["set-cookie"]
        return cookie.split(";")[0], cookie

    def control(self, *words):
        subprocess.run([argument("HAPTICCTL"), "--server", self.address, *words], check=True,
                       stdout=subprocess.DEVNULL, timeout=60)


def bearer(token):
    return {"Authorization": f"Bearer {token}"}


class Session:
    """A session, by `protocol`; `web`: keywords of WebSocket."""

    def __init__(self, address, protocol, token=PRIMARY, web=None, **fields):
        headers = bearer(token) if token else {}
        self.socket = WebSocket(address, (protocol,), headers, **(web or {}))
        assert self.socket.protocol == protocol, self.socket.protocol
        self.json, self.state, self.ack, self.events, self.seq = protocol == JSON, None, None, [], 0
        self.opened = None
        open_session = session_pb2.OpenSession(**{
            "role": session_pb2.ROLE_CONTROLLER, "client_name": "by hand",
            "nominal_rate_hz": 100.0, **fields})
        self.send(session_pb2.SessionRequest(open=open_session))

    def pack(self, request):
        if self.json:
            return json.dumps(json_format.MessageToDict(request)).encode()
        return request.SerializeToString()

    def send(self, request):
        self.socket.send(frame(TEXT if self.json else BINARY, self.pack(request)))

    def unpack(self, kind, payload):
        assert kind == (TEXT if self.json else BINARY), kind
        if not self.json:
            return session_pb2.SessionResponse.FromString(payload)
        return json_format.Parse(payload.decode(), session_pb2.SessionResponse())

    def receive(self):
        response = self.unpack(*self.socket.receive())
        which = response.WhichOneof("message")
        if which == "opened":
            assert self.opened is None
            self.opened = response.opened
        elif which == "state":
            assert self.opened and (not self.state or response.state.seq > self.state.seq)
            self.state = response.state
        elif which == "event":
            self.events.append(response.event)
        elif which == "ack":
            self.ack = response.ack
        return which

    def until(self, condition, what, seconds=60.0):
        end = time.monotonic() + seconds
        while not condition():
            assert time.monotonic() < end, f"never: {what}"
            self.receive()

    def begin(self):
        self.until(lambda: self.opened and self.state, "the session opens, and a state comes")
        return self

    def publish(self, mode, position=(), seq=None):
        self.seq = seq or self.seq + 1
        self.send(session_pb2.SessionRequest(proxy=session_pb2.ProxySample(
            seq=self.seq, mode=mode, position=position, source_time_ns=time.monotonic_ns(),
            device_seq_used=self.state.seq)))

    def publish_until(self, condition, what, position=None, seconds=60.0):
        """A free proxy until the device has force, then `position`; a sample for every 10 ms."""
        end, due = time.monotonic() + seconds, 0.0
        while not condition():
            assert time.monotonic() < end, f"never: {what}"
            self.receive()
            if time.monotonic() < due:
                continue
            due = time.monotonic() + 0.01
            if position is None or self.state.gain == 0:
                self.publish(session_pb2.PROXY_MODE_FREE)
            else:
                self.publish(session_pb2.PROXY_MODE_HELD, position)

    def closed(self, seconds=60.0):
        """How the server ends it."""
        closed = self.socket.end_within(seconds)
        self.socket.socket.close()
        assert closed, "the session does not end"
        return closed

    def leave(self):
        self.send(session_pb2.SessionRequest(leave=session_pb2.LeaveSession()))
        return self.closed()


__all__ = ["OBSERVER", "ORIGIN", "PRIMARY", "Closed", "Session", "WebServer", "bearer",
           "session_pb2"]
