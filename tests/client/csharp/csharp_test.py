"""HapticSession.cs under mono against a hapticd with server.web, and against a hostile peer.
$HAPTICD, $HAPTIC_SCENES, $HAPTIC_MONO and $HAPTIC_CSHARP_PROGRAMS (a folder) say where they are."""

import base64
import hashlib
import os
import pathlib
import re
import socket
import subprocess
import tempfile
import threading
import unittest

TOKEN = "a-token-of-this-test-alone"


def run(program: str, *arguments: str) -> subprocess.CompletedProcess[str]:
    path = os.path.join(os.environ["HAPTIC_CSHARP_PROGRAMS"], program)
    return subprocess.run([os.environ["HAPTIC_MONO"], path, *arguments], capture_output=True,
                          text=True, timeout=150, check=False)


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


class Hostile(unittest.TestCase):
    """A peer that agrees to the WebSocket and then sends frames of its own."""

    def peer(self, *frames: bytes) -> str:
        listener = socket.create_server(("127.0.0.1", 0))
        self.addCleanup(listener.close)

        def serve() -> None:
            with listener.accept()[0] as client:
                head = b""
                while b"\r\n\r\n" not in head:
                    head += client.recv(4096)
                key = re.search(rb"(?i)sec-websocket-key: *(\S+)", head)
                assert key is not None
                accept = base64.b64encode(hashlib.sha1(
                    key[1] + b"258EAFA5-E914-47DA-95CA-C5AB0DC85B11").digest())
                client.sendall(b"HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\n"
                               b"Connection: Upgrade\r\nSec-WebSocket-Protocol: haptic.v1.proto\r\n"
                               b"Sec-WebSocket-Accept: " + accept + b"\r\n\r\n")
                try:
                    for frame in frames:
                        client.sendall(frame)
                    while client.recv(4096):
                        pass
                except OSError:
                    pass  # the client went away, as it should

        threading.Thread(target=serve, daemon=True).start()
        return f"http://127.0.0.1:{listener.getsockname()[1]}"

    def refuses(self, why: str, *frames: bytes, seconds: str = "60") -> None:
        done = run("SessionTest.exe", "refused", self.peer(*frames), TOKEN, seconds)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertRegex(done.stdout, why)

    def test_long_message_ends_it(self) -> None:
        self.refuses("64 KB", b"\x82\x7f" + (1 << 20).to_bytes(8, "big") + bytes(1 << 20))

    def test_length_beyond_the_end(self) -> None:
        self.refuses("beyond the end", b"\x82\x03\x12\x7f\x01")

    def test_cut_field(self) -> None:
        self.refuses("within a field", b"\x82\x04\x12\x02\x69\x00")

    def test_endless_number(self) -> None:
        self.refuses("64 bits", b"\x82\x0d\x12\x0b\x08" + b"\xff" * 10)

    def test_silence_is_not_waited_for(self) -> None:
        self.refuses("no answer in 2 s", seconds="2")


if __name__ == "__main__":
    unittest.main()
