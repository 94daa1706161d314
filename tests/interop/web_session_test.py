"""Sessions on WebSockets, in protobuf and in JSON: what gRPC's sessions do, and how they end."""

import os
import struct
import sys
import time
import unittest

import grpc

from server_process import argument, eventually
from web_server import OBSERVER, PRIMARY, Closed, Session, WebServer, bearer, session_pb2

from haptic.v1 import haptic_service_pb2 as service  # noqa: E402
from haptic.v1 import haptic_service_pb2_grpc  # noqa: E402
from web_socket import (BINARY, CLOSE, CONTINUATION, JSON, PING, PONG, PROTO, TEXT,  # noqa: E402
                        WebSocket, frame)

FREE, HELD = session_pb2.PROXY_MODE_FREE, session_pb2.PROXY_MODE_HELD
PRESSED = [0.25, 0.5236]  # rad: the first joint is held 0.27 rad short of where it would rest
SAMPLE_LIMIT = 64 * 1024
(INVALID_ARGUMENT, NOT_FOUND, ALREADY_EXISTS, PERMISSION_DENIED, RESOURCE_EXHAUSTED, ABORTED,
 UNAVAILABLE) = (4003, 4005, 4006, 4007, 4008, 4010, 4014)


class Sessions(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.server = WebServer(argument("HAPTICD")).__enter__()
        cls.stub = haptic_service_pb2_grpc.HapticServiceStub(cls.server.channel)
        eventually(lambda: cls.device().state == session_pb2.DEVICE_STATE_NAME_IDLE, "it is ready")

    @classmethod
    def tearDownClass(cls):
        cls.server.__exit__()

    @classmethod
    def device(cls):
        return cls.stub.ListDevices(service.ListDevicesRequest(), timeout=20).devices[0]

    def setUp(self):
        eventually(lambda: not self.device().controller, "the test before left the device")

    def session(self, protocol=PROTO, **fields):
        return Session(self.server.web, protocol, **fields)

    def ends(self, session, code, reason):
        closed = session.closed()
        self.assertEqual((closed.code, closed.reason.split(":")[0]), (code, reason), closed)
        self.assertLessEqual(len(closed.reason.encode()), 123)

    def engaged(self, session):
        """Asks for force; False: the stream is too young, or had a gap."""
        try:
            self.stub.Engage(service.EngageRequest(session_id=session.opened.session_id),
                             timeout=20)
            return True
        except grpc.RpcError as error:
            self.assertEqual(error.code(), grpc.StatusCode.FAILED_PRECONDITION, error)
            return False

    # A whole session.

    def press(self, protocol):
        session = self.session(protocol, state_rate_hz=200.0, udp_wanted=True).begin()
        opened = session.opened
        self.assertEqual((opened.transport, opened.role, opened.device),
                         (session_pb2.TRANSPORT_WEBSOCKET, session_pb2.ROLE_CONTROLLER, "finger"))
        self.assertTrue(opened.udp_refused and not opened.HasField("udp"))
        self.assertEqual(self.device().controller, "by hand")
        session.publish_until(lambda: self.engaged(session), "force is granted")
        session.publish_until(lambda: session.state.tau_elastic and abs(
            session.state.tau_elastic[0]) > 1.0, "force by the proxy", PRESSED)
        self.assertEqual(session.state.transport, session_pb2.TRANSPORT_WEBSOCKET)
        self.assertEqual(session.state.lease_epoch, opened.lease_epoch)
        session.publish_until(lambda: session.ack, "samples are acknowledged", PRESSED)
        self.assertGreater(session.ack.accepted, 0)
        session.publish(HELD, [float("inf")] * 2)
        session.publish_until(lambda: session.ack.rejected_invalid == 1, "a refusal", PRESSED)
        reasons = {event.reason for event in session.events}
        self.assertLessEqual({"LEASE_GRANTED", "ARMED -> ENGAGING"}, reasons)
        links = self.stub.GetLinkStats(service.GetLinkStatsRequest(), timeout=20).sessions
        self.assertEqual([(link.client_name, link.samples_by) for link in links],
                         [("by hand", session_pb2.TRANSPORT_WEBSOCKET)])
        closed = session.leave()
        self.assertEqual((closed.code, closed.reason), (1000, ""))
        eventually(lambda: not self.device().controller, "the lease is given back at once", 1.5)

    def test_presses_in_protobuf(self):
        self.press(PROTO)

    def test_presses_in_json(self):
        self.press(JSON)

    def test_late_client_is_free_first(self):
        """A proxy that is held from the first sample on gets no force: NEVER_FREE."""
        session = self.session(state_rate_hz=200.0).begin()
        why = ""

        def refused():
            nonlocal why
            session.publish(HELD, PRESSED)
            with self.assertRaises(grpc.RpcError) as refusal:
                self.stub.Engage(service.EngageRequest(session_id=session.opened.session_id),
                                 timeout=20)
            details = dict(refusal.exception.trailing_metadata())["grpc-status-details-bin"]
            why = why or ("NEVER_FREE" if b"NEVER_FREE" in details else "")
            self.assertFalse(any(session.state.tau_elastic))
            return why
        session.until(refused, "a refusal for being never free")
        session.until(lambda: session.state.limiters & 1 << 16, "the limiter NEVER_FREE")
        session.publish_until(lambda: self.engaged(session), "force after free samples")
        session.leave()

    def test_observer_sees_states_only(self):
        session = self.session(JSON, token=OBSERVER, role=session_pb2.ROLE_OBSERVER).begin()
        for _ in range(20):
            session.receive()
        self.assertEqual(session.opened.lease_epoch, 0)
        self.ends(self.session(token=OBSERVER), PERMISSION_DENIED, "RIGHTS")
        self.ends(self.session(token=OBSERVER, role=session_pb2.ROLE_TRACKER), PERMISSION_DENIED,
                  "RIGHTS")
        session.leave()

    def test_unix_socket_needs_no_token(self):
        session = Session(self.server.unix, PROTO, token=None,
                          priority=session_pb2.PRIORITY_OPERATOR).begin()
        session.leave()

    # How it ends.

    def test_refused_sessions_say_why(self):
        for fields, code, reason in (
                ({"device": "none"}, NOT_FOUND, "NO_SUCH_DEVICE"),
                ({"client_name": ""}, INVALID_ARGUMENT, "INVALID_ARGUMENT"),
                ({"client_name": "é" * 400}, INVALID_ARGUMENT, "INVALID_ARGUMENT"),
                ({"role": 0}, INVALID_ARGUMENT, "INVALID_ARGUMENT"),
                ({"priority": session_pb2.PRIORITY_OPERATOR}, PERMISSION_DENIED,
                 "PRIORITY_DENIED"),
                ({"nominal_rate_hz": 5000.0}, INVALID_ARGUMENT, "INVALID_ARGUMENT")):
            for protocol in (PROTO, JSON):
                self.ends(self.session(protocol, **fields), code, reason)

    def test_held_lease_is_refused(self):
        holder = self.session().begin()
        self.ends(self.session(JSON, client_name="late"), ALREADY_EXISTS, "LEASE_HELD")
        holder.leave()

    def test_first_message_must_open(self):
        for protocol in (PROTO, JSON):
            session = self.session(protocol, role=session_pb2.ROLE_OBSERVER).begin()
            session.send(session_pb2.SessionRequest(open=session_pb2.OpenSession()))
            self.ends(session, INVALID_ARGUMENT, "PROTOCOL")
        for kind, words, protocol in ((TEXT, b"{}", JSON), (BINARY, b"", PROTO),
                                      (BINARY, b"\xff", PROTO), (TEXT, b"[" * 60_000, JSON),
                                      (TEXT, b'{"open":{"role":1e999}}', JSON),
                                      (TEXT, b'{"open":{"clientName":"\\ud800"}}', JSON),
                                      (TEXT, b'{"proxy":{"seq":"1"}}', JSON),
                                      (TEXT, b"{}", PROTO), (BINARY, b"{}", JSON)):
            socket = WebSocket(self.server.web, (protocol,), bearer(PRIMARY))
            socket.send(frame(kind, words))
            closed = socket.end_within(60.0)
            socket.socket.close()
            self.assertEqual((closed.code, closed.reason[:9]), (INVALID_ARGUMENT, "PROTOCOL:"),
                             (words[:30], closed))
        for words in (b'{"open":{"clientName":"\xff"}}', b"\xed\xa0\x80"):  # UTF-8: RFC 6455, 8.1
            socket = WebSocket(self.server.web, (JSON,), bearer(PRIMARY))
            socket.send(frame(TEXT, words))
            self.assertEqual(socket.end_within(60.0).code, 1007)
            socket.socket.close()

    def test_silence_instead_of_an_open_ends(self):
        socket = WebSocket(self.server.web, (PROTO,), bearer(OBSERVER))
        closed = socket.end_within(60.0)
        socket.socket.close()
        self.assertEqual((closed.code, closed.reason[:9]), (INVALID_ARGUMENT, "PROTOCOL:"))

    def test_too_large_a_message_ends(self):
        for protocol, kind in ((PROTO, BINARY), (JSON, TEXT)):
            session = self.session(protocol, role=session_pb2.ROLE_OBSERVER).begin()
            session.socket.send(frame(kind, b" " * (SAMPLE_LIMIT + 1)))
            self.ends(session, RESOURCE_EXHAUSTED, "MESSAGE_TOO_LARGE")

    def test_broken_frames_end_only_themselves(self):
        text = frame(TEXT, b"{}")
        for name, words in {
                "unmasked": frame(BINARY, b"x", mask=False), "reserved bit": frame(
                    BINARY, b"x", reserved=4), "unknown": frame(3, b"x"), "unknown control":
                frame(11), "continuation without a beginning": frame(CONTINUATION, b"x"),
                "two beginnings": frame(BINARY, b"x", fin=False) + frame(BINARY, b"x"),
                "long control": frame(PING, b"x" * 126), "part of a control": frame(
                    PING, b"x", fin=False), "2^63": frame(BINARY, b"", length=1 << 63),
                "2^64 - 1": frame(BINARY, b"", length=(1 << 64) - 1),
                "close of one byte": frame(CLOSE, b"x"), "close 1005": frame(
                    CLOSE, struct.pack(">H", 1005)), "close 999": frame(
                    CLOSE, struct.pack(">H", 999) + b"x"), "text": text[:1]}.items():
            socket = WebSocket(self.server.web, (PROTO,), bearer(OBSERVER))
            socket.send(words)
            closed = socket.end_within(60.0)
            socket.socket.close()
            self.assertIsNotNone(closed, name)
            self.assertIn(closed.code, (None, 1002, 1007, 1009, INVALID_ARGUMENT), name)

    def test_messages_may_come_in_parts(self):
        socket = WebSocket(self.server.web, (PROTO,), bearer(OBSERVER))
        words = session_pb2.SessionRequest(open=session_pb2.OpenSession(
            role=session_pb2.ROLE_OBSERVER, client_name="parts")).SerializeToString()
        socket.send(frame(BINARY, words[:1], fin=False) + frame(PING, b"between"))
        for byte in words[1:]:
            socket.send(frame(CONTINUATION, bytes([byte]), fin=False))
        socket.send(frame(CONTINUATION))
        self.assertEqual(socket.receive(), (PONG, b"between"))
        kind, payload = socket.receive()
        self.assertEqual(kind, BINARY)
        self.assertTrue(session_pb2.SessionResponse.FromString(payload).HasField("opened"))
        socket.send(frame(CLOSE, struct.pack(">H", 1001)))
        self.assertEqual(socket.end_within(60.0).code, 1001)
        socket.socket.close()

    # The fate of the lease.

    def test_lost_socket_is_resumed(self):
        for protocol in (PROTO, JSON):
            session = self.session(protocol, resumable=True).begin()
            session.publish_until(lambda s=session: s.ack, "samples are acknowledged")
            session.socket.socket.close()
            again = self.session(protocol, resumable=True,
                                 resume=session.opened.session_id).begin()
            self.assertTrue(again.opened.resumed)
            self.assertGreaterEqual(again.opened.newest_seq, session.ack.newest_seq)
            again.leave()

    def test_session_goes_on_elsewhere(self):
        session = self.session(resumable=True).begin()
        again = self.session(JSON, resumable=True, resume=session.opened.session_id).begin()
        self.assertTrue(again.opened.resumed)
        self.ends(session, ABORTED, "RESUMED")
        again.leave()

    def test_silent_controller_loses_the_lease(self):
        session = self.session(JSON).begin()
        session.until(lambda: any(e.reason == "LEASE_EXPIRED" for e in session.events),
                      "the lease ends for want of samples")
        session.receive()  # it looks on
        session.leave()

    def test_stronger_client_takes_the_lease(self):
        session = self.session().begin()
        strong = Session(self.server.unix, JSON, token=None,
                         priority=session_pb2.PRIORITY_OPERATOR).begin()
        session.until(lambda: any(e.reason == "LEASE_PREEMPTED" for e in session.events),
                      "it is told")
        strong.leave()
        session.leave()


class Ends(unittest.TestCase):
    def test_front_restarts_and_hapticd_ends(self):
        with WebServer(argument("HAPTICD")) as server:
            first = Session(server.web, PROTO, resumable=True).begin()
            cookie = server.redeem()[0]
            server.control("restart-front")
            closed = first.closed()
            self.assertIn(closed.code, (UNAVAILABLE, None))
            again = None
            end = time.monotonic() + 60.0
            while again is None:  # at the same port
                self.assertLess(time.monotonic(), end)
                try:
                    again = Session(server.web, JSON, resumable=True,
                                    resume=first.opened.session_id).begin()
                except (OSError, Closed):
                    time.sleep(0.02)
            self.assertTrue(again.opened.resumed)
            with self.assertRaises(Exception):
                WebSocket(server.web, (JSON,), {"Cookie": cookie})  # it lived in the first one
            sockets = [Session(server.web, PROTO, role=session_pb2.ROLE_OBSERVER).begin()
                       for _ in range(10)]
            server.process.terminate()
            for session in (again, *sockets):
                self.ends(session)
            self.assertEqual(server.process.wait(timeout=60), 0)

    def ends(self, session):
        closed = session.closed()
        self.assertEqual((closed.code, closed.reason.split(":")[0]), (UNAVAILABLE, "CLOSING"))


if __name__ == "__main__":
    os.environ.setdefault("GRPC_VERBOSITY", "ERROR")
    unittest.main(verbosity=1, argv=sys.argv[:1])
