"""HapticSession.cs under mono against a hapticd with server.web, and against a hostile peer.
$HAPTICD, $HAPTIC_SCENES, $HAPTIC_MONO and $HAPTIC_CSHARP_PROGRAMS (a folder) say where they are."""

import base64
import contextlib
import hashlib
import json
import os
import pathlib
import re
import socket
import subprocess
import tempfile
import threading
import time
import unittest
from collections.abc import Iterator

TOKEN = "a-token-of-this-test-alone"


def run(program: str, *arguments: str, told: str = "") -> subprocess.CompletedProcess[str]:
    path = os.path.join(os.environ["HAPTIC_CSHARP_PROGRAMS"], program)
    return subprocess.run([os.environ["HAPTIC_MONO"], path, *arguments], capture_output=True,
                          text=True, timeout=150, check=False, input=told)


def lines(value: object, path: str = "") -> Iterator[str]:
    """JSON as ContactTest reads it."""
    if isinstance(value, dict):
        for name, part in value.items():
            yield from lines(part, f"{path}.{name}" if path else name)
    elif isinstance(value, list) and value and isinstance(value[0], dict):
        for i, part in enumerate(value):
            yield from lines(part, f"{path}.{i}")
    else:
        values = value if isinstance(value, list) else [value]
        yield " ".join([path, *("" if v is None else str(int(v) if isinstance(v, bool) else v)
                                for v in values)])


class SharedVectors(unittest.TestCase):
    def test_contacts_are_those_of_all_languages(self) -> None:
        vectors = pathlib.Path(__file__).parents[1].joinpath("contacts.json").read_text("utf-8")
        done = run("ContactTest.exe", told="\n".join(lines(json.loads(vectors))))
        self.assertEqual((done.returncode, done.stderr), (0, ""))


class WithHapticd(unittest.TestCase):
    maxDiff = None

    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        token = pathlib.Path(folder.name) / "token"
        token.touch(mode=0o600)
        token.write_text(TOKEN + "\n", encoding="ascii")
        log = pathlib.Path(folder.name) / "log"
        with log.open("wb") as written:
            server = subprocess.Popen(
                [os.environ["HAPTICD"], "--scene",
                 os.path.join(os.environ["HAPTIC_SCENES"], "finger_constant.textproto"),
                 "--realtime=off", "--listen", f"unix:{folder.name}/socket",
                 "--set", "loop.late_bucket_full=1000000",
                 "--set", "loop.loop_late_fault={seconds: 10}",
                 # Nor is one of the server: mono may get no processor for seconds.
                 "--set", "server.lease_timeout={seconds: 60}",
                 "--set", "device[0].staleness={hold_end {seconds: 5} fade_end {seconds: 6}}",
                 "--set", 'server.web={listen: "127.0.0.1:0" token {name: "test" '
                          f'file: "{token}" rights: "primary"}}}}'], stderr=written)
        self.addCleanup(server.wait)
        self.addCleanup(server.kill)
        address = None
        while address is None:
            self.assertIsNone(server.poll(), log.read_text(encoding="utf-8"))
            address = re.search(r"page: (http://[\d.:]+)/", log.read_text("utf-8"))
        self.address = address[1]

    def test_whole_class(self) -> None:
        done = run("SessionTest.exe", "all", self.address, TOKEN)
        self.assertEqual((done.returncode, done.stderr), (0, ""))

    def test_wrong_token_is_refused(self) -> None:
        done = run("SessionTest.exe", "refused", self.address, "another-token-of-24-letters", "60")
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertIn("show a token", done.stdout)

    def test_no_server_is_refused(self) -> None:
        done = run("SessionTest.exe", "refused", "http://127.0.0.1:1", TOKEN, "60")
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertIn("refused", done.stdout)

    def test_example_makes_force(self) -> None:
        """The finger rests at 0.52 rad, so it is beyond the wall of the example."""
        done = run("VirtualWall.exe", self.address, TOKEN, "5")
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        state, force = done.stdout.split()
        self.assertEqual(state, "Engaged")
        self.assertGreater(abs(float(force)), 0.05)


def web_socket(head: bytes) -> bytes:
    key = re.search(rb"(?i)sec-websocket-key: *(\S+)", head)
    assert key is not None
    accept = base64.b64encode(hashlib.sha1(
        key[1] + b"258EAFA5-E914-47DA-95CA-C5AB0DC85B11").digest())
    return (b"HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
            b"Sec-WebSocket-Protocol: haptic.v1.proto\r\nSec-WebSocket-Accept: " + accept +
            b"\r\n\r\n")


class Hostile(unittest.TestCase):
    """A peer that agrees to the WebSocket, if no other answer is given, and then sends frames of
    its own; it gives every call the same answer."""

    def peer(self, *frames: bytes, answer: bytes | None = None, endless: bytes = b"",
             call: bytes = b"HTTP/1.1 404 None\r\nConnection: close\r\nContent-Length: 0\r\n\r\n",
             call_s: float = 0.0) -> str:
        self.calls: list[bytes] = []  # as they come, and as they are answered
        listener = socket.create_server(("127.0.0.1", 0))
        self.addCleanup(listener.close)

        def talk(client: socket.socket) -> None:
            with client, contextlib.suppress(OSError):  # it went away, as it should
                head = b""
                while b"\r\n\r\n" not in head:
                    head += client.recv(4096)
                if head.startswith(b"POST"):
                    method = head.split(b" ")[1].rpartition(b"/")[2]
                    self.calls.append(method + b"?")
                    time.sleep(call_s)
                    self.calls.append(method + b".")
                    client.sendall(call)
                else:
                    client.sendall(web_socket(head) if answer is None else answer)
                    for frame in frames:
                        client.sendall(frame)
                    while endless:
                        client.sendall(endless)
                        time.sleep(0.001)
                while client.recv(4096):
                    pass

        def serve() -> None:
            while True:
                try:
                    client = listener.accept()[0]
                except OSError:
                    return  # the test is over
                threading.Thread(target=talk, args=(client,), daemon=True).start()

        threading.Thread(target=serve, daemon=True).start()
        return f"http://127.0.0.1:{listener.getsockname()[1]}"

    def refuses(self, why: str, *frames: bytes, seconds: str = "60", answer: bytes | None = None,
                endless: bytes = b"") -> None:
        peer = self.peer(*frames, answer=answer, endless=endless)
        done = run("SessionTest.exe", "refused", peer, TOKEN, seconds)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertRegex(done.stdout, why)

    def test_long_message_ends_it(self) -> None:
        self.refuses("64 KB", b"\x82\x7f" + (1 << 20).to_bytes(8, "big") + bytes(1 << 20))

    def test_pieces_without_end(self) -> None:
        self.refuses("64 KB", b"\x02\x00", endless=b"\x00\x7e\x40\x00" + bytes(0x4000))

    def test_broken_frames(self) -> None:
        for name, frame in {"masked": b"\x82\x81\0\0\0\0\x12", "in pieces": b"\x09\x01x",
                            "unknown": b"\x83\x01x", "reserved": b"\xc2\x01x"}.items():
            with self.subTest(name):
                self.refuses("(?i)invalid|websocket|frame|data", frame)

    def test_negative_length_is_not_waited_for(self) -> None:
        self.refuses("no answer in 2 s", b"\x82\x7f" + b"\xff" * 8, seconds="2")

    def test_length_beyond_the_end(self) -> None:
        self.refuses("beyond the end", b"\x82\x03\x12\x7f\x01")

    def test_cut_field(self) -> None:
        self.refuses("within a field", b"\x82\x04\x12\x02\x69\x00")

    def test_cut_list(self) -> None:
        """12 bytes of q, then seq = 1: two numbers would take what follows."""
        self.refuses("within a number", b"\x82\x12\x12\x10\x1a\x0c" + bytes(12) + b"\x08\x01")

    def test_groups(self) -> None:
        self.refuses("another type", b"\x82\x7e\x40\x00" + b"\x7b" * 0x4000)

    def test_endless_number(self) -> None:
        self.refuses("64 bits", b"\x82\x0d\x12\x0b\x08" + b"\xff" * 10)

    def test_silence_is_not_waited_for(self) -> None:
        self.refuses("no answer in 2 s", seconds="2")

    def test_pings_are_not_an_answer(self) -> None:
        self.refuses("no answer in 2 s", seconds="2", endless=b"\x89\x01x")

    def test_slow_head(self) -> None:
        self.refuses("no answer in 2 s", seconds="2",
                     answer=b"HTTP/1.1 101 Switching Protocols\r\nX: ", endless=b"x")

    def test_endless_head(self) -> None:
        self.refuses("no answer in 2 s", seconds="2",
                     answer=b"HTTP/1.1 101 Switching Protocols\r\nX: ", endless=b"x" * 4096)

    def test_200_is_no_session(self) -> None:
        self.refuses("HTTP 404", answer=b"HTTP/1.1 200 OK\r\nContent-Length: 1\r\n\r\nx")

    def test_odd_states_and_silence(self) -> None:
        """NaN and infinities of no device of this size; then no message any more."""
        odd = bytes.fromhex("000000000000f87f" "000000000000f0ff")
        session = b"\x82\x05\x0a\x03\x4a\x01s"
        state = b"\x82\x14\x12\x12\x2a\x10" + odd
        for name, call, why in (
                ("escape", b'{"message": "\\u12"}', r"\\u12"),
                ("cut", b'{"message": "a', "HTTP 400"),
                ("not UTF-8", b'{"message": "\xff\xfe"}', "\ufffd")):
            with self.subTest(name):
                answer = b"HTTP/1.1 400 Bad\r\nContent-Length: %d\r\n\r\n" % len(call) + call
                peer = self.peer(session, state, call=answer)
                done = run("SessionTest.exe", "deserted", peer, TOKEN, "60")
                self.assertEqual((done.returncode, done.stderr), (0, ""))
                *refusal, failure, x_probe = done.stdout.splitlines()
                self.assertRegex("\n".join(refusal), why)
                self.assertRegex(failure, "fell silent")
                self.assertEqual(x_probe, "NaN -Infinity")

    def test_a_release_does_not_overtake(self) -> None:
        peer = self.peer(b"\x82\x05\x0a\x03\x4a\x01s", call_s=1.0)
        done = run("SessionTest.exe", "released", peer, TOKEN)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        # A mono that got no processor for 200 ms has not asked yet, and then it never does.
        engage = [] if self.calls[0] == b"Release?" else [b"Engage?", b"Engage."]
        self.assertEqual(self.calls, [*engage, b"Release?", b"Release."])

    def test_answers_without_end(self) -> None:
        peer = self.peer(b"\x82\x05\x0a\x03\x4a\x01s",
                         call=b"HTTP/1.1 200 OK\r\nContent-Length: 999\r\n\r\n" + b"x" * 9)
        done = run("SessionTest.exe", "deserted", peer, TOKEN, "2")
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertRegex(done.stdout, "no answer in 2 s\nthe server fell silent")

    def test_odd_answers(self) -> None:
        for why, head in (("65536", b"Content-Length: 99999"), ("encoding", b"Content-Length: 1\r\n"
                           b"Content-Type: text/plain; charset=none\r\n\r\nx")):
            with self.subTest(why):
                peer = self.peer(b"\x82\x05\x0a\x03\x4a\x01s",
                                 call=b"HTTP/1.1 400 Bad\r\n" + head + b"\r\n\r\n")
                done = run("SessionTest.exe", "deserted", peer, TOKEN, "60")
                self.assertEqual((done.returncode, done.stderr), (0, ""))
                self.assertRegex(done.stdout, why)


if __name__ == "__main__":
    unittest.main()
