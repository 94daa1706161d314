#!/usr/bin/env python3
"""Whatever a server says, hapticctl moves no terminal: a server whose every text is hostile.

    lying_server_test.py HAPTICCTL

The messages of haptic.v1 are on PYTHONPATH.
"""

from __future__ import annotations

import concurrent.futures
import json
import os
import subprocess
import sys
import tempfile
import unittest
from typing import Any

import grpc
from google.protobuf.message import Message
from haptic.v1 import haptic_service_pb2 as service
from haptic.v1 import session_pb2 as session

HAPTICCTL = sys.argv[1]
# Cursor, bell, a line of its own, C1, writing direction.
EVIL = "\x1b[2J\x07\r\nhapticd: all is well\x7f\x9b31m\u202e\u2066"
SHOWN = "hapticd: all is well"


def fill(message: Message, depth: int = 0) -> Message:
    """Every text is evil, every list has one entry."""
    for field in message.DESCRIPTOR.fields:
        repeated = field.label == field.LABEL_REPEATED
        if field.type == field.TYPE_MESSAGE and depth < 5:
            child = getattr(message, field.name)
            fill(child.add() if repeated else child, depth + 1)
            if not repeated:
                child.SetInParent()
        elif field.type == field.TYPE_STRING and repeated:
            getattr(message, field.name).append(EVIL)
        elif field.type == field.TYPE_STRING and field.containing_oneof is None:
            setattr(message, field.name, EVIL)
    return message


def evil(kind: str) -> Message:
    return fill(getattr(service if hasattr(service, kind) else session, kind)())


class LyingServer(unittest.TestCase):
    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.address = "unix:" + os.path.join(folder.name, "s")
        server = grpc.server(concurrent.futures.ThreadPoolExecutor(8))
        methods = service.DESCRIPTOR.services_by_name["HapticService"].methods
        server.add_generic_rpc_handlers([grpc.method_handlers_generic_handler(
            "haptic.v1.HapticService", {m.name: self.method(m) for m in methods})])
        server.add_insecure_port(self.address)
        server.start()
        self.addCleanup(lambda: server.stop(None).wait())
        self.refuse = False

    def method(self, method: Any) -> grpc.RpcMethodHandler:
        def answer(_: bytes, context: grpc.ServicerContext) -> bytes:
            if self.refuse:
                context.abort(grpc.StatusCode.FAILED_PRECONDITION, EVIL)
            return evil(method.output_type.name).SerializeToString()

        def answers(_: Any, context: grpc.ServicerContext) -> Any:
            for _ in range(3):
                yield answer(b"", context)
            context.abort(grpc.StatusCode.UNKNOWN, EVIL)

        if method.server_streaming and method.client_streaming:
            return grpc.stream_stream_rpc_method_handler(answers)
        if method.server_streaming:
            return grpc.unary_stream_rpc_method_handler(answers)
        return grpc.unary_unary_rpc_method_handler(answer)

    def say(self, *words: str) -> str:
        done = subprocess.run([HAPTICCTL, "--server", self.address, *words], timeout=60,
                              stdin=subprocess.DEVNULL, capture_output=True)
        self.assertGreaterEqual(done.returncode, 0, f"{words} ended by a signal: {done.stderr!r}")
        text = (done.stdout + done.stderr).decode("utf-8")  # raises if it is none
        harmful = {c for c in text if (ord(c) < 0x20 and c != "\n") or 0x7F <= ord(c) < 0xA0
                   or c in "\u202e\u2066"}
        self.assertEqual(harmful, set(), f"{words}: {text!r}")
        for line in text.splitlines():
            self.assertFalse(line.startswith(SHOWN), f"{words}: a line of the server's: {text!r}")
        return text

    COMMANDS = (["info"], ["watch", "--seconds", "1"], ["engage", "--seconds", "1"], ["link"],
                ["estop"], ["clear-fault"], ["calibrate"], ["health"])

    def test_no_text_moves_the_terminal(self) -> None:
        said = [self.say(*command) for command in self.COMMANDS]
        self.assertIn("\\x1b[2J", said[0])
        self.assertTrue(any(SHOWN in text for text in said[3:5]))

    def test_no_error_moves_the_terminal(self) -> None:
        self.refuse = True
        for command in self.COMMANDS[:-1]:
            self.assertIn(SHOWN, self.say(*command), command)

    def test_json_stays_json(self) -> None:
        for command in (["info"], ["link"], ["estop"]):
            text = self.say("--json", *command)
            self.assertTrue(text.isascii(), text)
            self.assertIn(SHOWN, json.dumps(json.loads(text)))


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
