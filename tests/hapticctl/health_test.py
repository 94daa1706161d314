#!/usr/bin/env python3
"""The exit status of `hapticctl health`, against a server that answers as the test says.

    health_test.py HAPTICCTL
"""

import concurrent.futures
import os
import subprocess
import sys
import tempfile
import unittest

import grpc

HAPTICCTL = sys.argv[1]
# grpc.health.v1: HealthCheckRequest { string service = 1; }, HealthCheckResponse { ServingStatus
# status = 1; }
SERVING, NOT_SERVING = b"\x08\x01", b"\x08\x02"


class Health(unittest.TestCase):
    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.address = "unix:" + os.path.join(folder.name, "socket")
        self.asked: list[bytes] = []

    def serve(self, answer: bytes | grpc.StatusCode) -> None:
        def check(request: bytes, context: grpc.ServicerContext) -> bytes:
            self.asked.append(request)
            if isinstance(answer, bytes):
                return answer
            context.abort(answer, "told to say so")

        server = grpc.server(concurrent.futures.ThreadPoolExecutor(1))
        server.add_generic_rpc_handlers([grpc.method_handlers_generic_handler(
            "grpc.health.v1.Health", {"Check": grpc.unary_unary_rpc_method_handler(check)})])
        server.add_insecure_port(self.address)
        server.start()
        self.addCleanup(lambda: server.stop(None).wait())

    def health(self, *arguments: str) -> subprocess.CompletedProcess[str]:
        return subprocess.run([HAPTICCTL, "--server", self.address, *arguments, "health"],
                              capture_output=True, text=True, timeout=60)

    def test_serving_is_0(self) -> None:
        self.serve(SERVING)
        ended = self.health()
        self.assertEqual((ended.returncode, ended.stdout), (0, "serving\n"))
        self.assertEqual(self.health("--json").stdout, '{"serving":true}\n')
        self.assertEqual(self.asked, [b"", b""])  # no service named: the whole server

    def test_not_serving_is_1(self) -> None:
        self.serve(NOT_SERVING)
        ended = self.health()
        self.assertEqual((ended.returncode, ended.stdout), (1, "not serving\n"))
        self.assertEqual(self.health("--json").stdout, '{"serving":false}\n')

    def test_device_is_asked_by_name(self) -> None:
        self.serve(SERVING)
        self.assertEqual(self.health("--device", "finger").returncode, 0)
        self.assertEqual(self.asked, [b"\x0a\x06finger"])

    def test_unknown_device_is_4(self) -> None:
        self.serve(grpc.StatusCode.NOT_FOUND)
        ended = self.health("--device", "nobody")
        self.assertEqual((ended.returncode, ended.stdout), (4, ""))
        self.assertIn("told to say so", ended.stderr)

    def test_no_server_is_3(self) -> None:
        ended = self.health()
        self.assertEqual((ended.returncode, ended.stdout), (3, ""))
        self.assertNotEqual(ended.stderr, "")

    def test_wrong_command_line_is_2(self) -> None:
        self.assertEqual(self.health("--no-such-option").returncode, 2)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
