"""Who may use the service over HTTP, and its unary calls: the same as by gRPC, in JSON and in
protobuf, with errors as the Connect protocol says them."""

import base64
import json
import os
import shutil
import ssl
import subprocess
import sys
import tempfile
import unittest
from unittest import mock

import grpc

from server_process import argument, eventually
from web_server import OBSERVER, ORIGIN, PRIMARY, Closed, WebServer, bearer

from google.protobuf import json_format  # noqa: E402
from haptic.v1 import haptic_service_pb2 as service  # noqa: E402
from haptic.v1 import haptic_service_pb2_grpc  # noqa: E402
from web_socket import JSON, PROTO, SERVICE, Http, Refused, WebSocket, ask, request  # noqa: E402

TYPES = {"json": "application/json", "proto": "application/proto"}
# HTTP's status of a code, https://connectrpc.com/docs/protocol
STATUS = {"INVALID_ARGUMENT": 400, "NOT_FOUND": 404, "PERMISSION_DENIED": 403}


class Calls(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.server = WebServer(argument("HAPTICD")).__enter__()
        cls.stub = haptic_service_pb2_grpc.HapticServiceStub(cls.server.channel)

    @classmethod
    def tearDownClass(cls):
        cls.server.__exit__()

    def ask(self, method, target, headers=(), body=b"", **more):
        return ask(self.server.web, method, target, headers, body, **more)

    def call(self, name, message, kind="json", headers=None, **more):
        """(status, response or error)."""
        headers = bearer(PRIMARY) if headers is None else headers
        body = (json_format.MessageToJson(message).encode() if kind == "json"
                else message.SerializeToString())
        answer = self.ask("POST", SERVICE + name, {"Content-Type": TYPES[kind], **headers}, body,
                          **more)
        if answer.status != 200:
            self.assertEqual(answer.fields["content-type"], "application/json", answer)
            return answer.status, json.loads(answer.body)
        self.assertEqual(answer.fields["content-type"], TYPES[kind], answer)
        response = getattr(service, name + "Response")()
        if kind == "json":
            json_format.Parse(answer.body.decode(), response)
        else:
            response.ParseFromString(answer.body)
        return 200, response

    def reason(self, error):
        detail = error["details"][0]
        self.assertEqual(detail["type"], "google.rpc.ErrorInfo")
        value = base64.b64decode(detail["value"] + "=" * (-len(detail["value"]) % 4))
        self.assertIn(detail["debug"]["reason"].encode(), value)
        return detail["debug"]["reason"]

    def info(self, **headers):
        """Status of a call that every right allows."""
        return self.call("GetServerInfo", service.GetServerInfoRequest(), headers=headers)[0]

    # Who may.

    def test_printed_token_works_once(self):
        token = self.server.one_time()
        pair, cookie = self.server.redeem()
        for word in ("HttpOnly", "SameSite=Strict", "Path=/"):
            self.assertIn(word, cookie.split("; "))
        self.assertEqual(self.info(Cookie=f"theme=dark; {pair}; x=y"), 200)
        again = self.ask("GET", "/?token=" + token)
        self.assertNotIn("set-cookie", again.fields)
        self.assertEqual(self.info(**bearer(token)), 401)
        self.assertEqual(self.info(Cookie=pair[:-1]), 401)
        self.assertEqual(self.info(Cookie=pair + "0"), 401)

    def test_only_a_get_uses_the_token_up(self):
        token = self.server.one_time()
        self.assertNotIn("set-cookie", self.ask("HEAD", "/?token=" + token).fields)
        self.assertEqual(self.server.one_time(), token)

    def test_tokens_count_wherever_they_are_shown(self):
        self.assertEqual(self.info(**bearer(OBSERVER)), 200)
        self.assertEqual(self.info(), 401)
        for wrong in ("", OBSERVER[:-1], OBSERVER + "x", OBSERVER.upper(), "é" * 20, "x" * 4000):
            self.assertEqual(self.info(**bearer(wrong)), 401, wrong)
        for protocol in (PROTO, JSON):
            socket = WebSocket(self.server.web, (protocol, "haptic.token." + OBSERVER))
            self.assertEqual(socket.protocol, protocol)
            socket.socket.close()
        for protocols, status in (((PROTO,), 401), ((PROTO, "haptic.token.no"), 401),
                                  (("haptic.token." + OBSERVER,), 400), (("graphql",), 400)):
            with self.assertRaises(Refused) as refused:
                WebSocket(self.server.web, protocols)
            self.assertEqual(refused.exception.answer.status, status, protocols)

    def test_observer_looks_on_and_stops(self):
        headers = bearer(OBSERVER)
        for name in ("Engage", "Release", "UpdateSettings", "ClearFault"):
            status, error = self.call(name, getattr(service, name + "Request")(), headers=headers)
            self.assertEqual((status, error["code"], self.reason(error)),
                             (403, "permission_denied", "RIGHTS"), name)
        for name in ("GetServerInfo", "ListDevices", "GetLinkStats"):
            self.assertEqual(self.call(name, getattr(service, name + "Request")(),
                                       headers=headers)[0], 200, name)
        status, stopped = self.call("EmergencyStop", service.EmergencyStopRequest(),
                                    headers=headers)
        self.assertEqual((status, list(stopped.stopped)), (200, ["finger"]))
        cleared = self.call("ClearFault", service.ClearFaultRequest(device="finger"))
        self.assertEqual((cleared[0], list(cleared[1].cleared)), (200, [7]))

    def test_socket_of_this_host_needs_no_token(self):
        answer = ask(self.server.unix, "POST", SERVICE + "GetServerInfo",
                     {"Content-Type": TYPES["json"]}, b"{}", host="whatever")
        self.assertEqual(answer.status, 200, answer)

    def test_only_its_own_names_are_served(self):
        port = self.server.web[1]
        for host in ("127.0.0.1", f"127.0.0.1:{port}", f"localhost:{port}", "LocalHost", "[::1]:1",
                     "hapticd.example", "HAPTICD.example:80"):
            for target in ("/", "/healthz", "/metrics"):
                self.assertEqual(self.ask("GET", target, host=host).status, 200, host)
        for host in ("rebound.example", f"127.0.0.1.rebound.example:{port}", "127.0.0.2", "", None,
                     "hapticd.example.", "evil@127.0.0.1", "[::2]", "\xff", "0.0.0.0"):
            for target in ("/", "/healthz", "/metrics", "/?token=" + self.server.one_time()):
                answer = self.ask("GET", target, bearer(PRIMARY), host=host)
                self.assertEqual(answer.status, 403, host)
                self.assertEqual(self.reason(json.loads(answer.body)), "HOST")
                self.assertNotIn("set-cookie", answer.fields)

    def test_a_second_name_is_refused(self):
        own = f"127.0.0.1:{self.server.web[1]}"
        for fields, host in (({}, f"{own}\r\nHost: rebound.example"),
                             ({"Origin": f"http://{own}\r\nOrigin: http://rebound.example"}, own)):
            answer = self.ask("GET", "/healthz", fields, host=host)
            self.assertEqual(answer.status, 403, answer)

    def test_only_pages_of_its_own_and_listed_origins(self):
        own = f"http://127.0.0.1:{self.server.web[1]}"
        host = own[7:]
        for origin in ("null", "http://127.0.0.1", "http://127.0.0.1:1", "http://rebound.example",
                       own.replace("http", "https"), own + ".rebound.example", "http://", own + "/",
                       ORIGIN + ":443", ORIGIN.replace("https", "http"), ORIGIN.upper(), "*"):
            answer = self.ask("POST", SERVICE + "EmergencyStop",
                              {**bearer(PRIMARY), "Origin": origin,
                               "Content-Type": TYPES["json"]}, b"{}", host=host)
            self.assertEqual(answer.status, 403, origin)
            self.assertNotIn("access-control-allow-origin", answer.fields)
            with self.assertRaises(Refused):
                WebSocket(self.server.web, (PROTO,), {**bearer(PRIMARY), "Origin": origin},
                          host=host)
        for origin in (own, own.upper(), ORIGIN):
            WebSocket(self.server.web, (PROTO,), {**bearer(PRIMARY), "Origin": origin},
                      host=host).socket.close()
        allowed = self.ask("OPTIONS", SERVICE + "Engage", {
            "Origin": ORIGIN, "Access-Control-Request-Method": "POST",
            "Access-Control-Request-Headers": "authorization,content-type"})
        self.assertEqual(allowed.status, 204)
        self.assertEqual(allowed.fields["access-control-allow-origin"], ORIGIN)
        self.assertNotIn("access-control-allow-credentials", allowed.fields)
        self.assertIn("authorization", allowed.fields["access-control-allow-headers"].lower())
        self.assertNotIn("access-control-allow-origin", self.ask("GET", "/").fields)

    # The answers.

    def test_calls_say_what_grpc_says(self):
        requests = [("ListDevices", service.ListDevicesRequest()),
                    ("GetLinkStats", service.GetLinkStatsRequest()),
                    ("GetLinkStats", service.GetLinkStatsRequest(device="finger")),
                    ("EmergencyStop", service.EmergencyStopRequest(device="finger", reason="é")),
                    ("ClearFault", service.ClearFaultRequest(device="finger"))]
        for name, message in requests:
            by_grpc = getattr(self.stub, name)(message, timeout=20)
            for kind in TYPES:
                if name == "ClearFault":
                    self.stub.EmergencyStop(service.EmergencyStopRequest(), timeout=20)
                status, response = self.call(name, message, kind)
                self.assertEqual(status, 200)
                for device in getattr(response, "devices", []):
                    device.state, device.faults = by_grpc.devices[0].state, 0
                if name == "ListDevices":
                    by_grpc.devices[0].faults = 0
                self.assertEqual(response, by_grpc, f"{name} {kind}")
        for kind in TYPES:
            info = self.call("GetServerInfo", service.GetServerInfoRequest(), kind)[1]
            by_grpc = self.stub.GetServerInfo(service.GetServerInfoRequest(), timeout=20)
            for field in ("version", "protocol", "scene", "insecure", "max_sessions", "realtime"):
                self.assertEqual(getattr(info, field), getattr(by_grpc, field))

    def test_errors_say_what_grpc_says(self):
        nobody = "0" * 32
        requests = [("Engage", service.EngageRequest(session_id=nobody)),
                    ("Release", service.ReleaseRequest()),
                    ("UpdateSettings", service.UpdateSettingsRequest(session_id=nobody)),
                    ("UpdateSettings", service.UpdateSettingsRequest(stiffness=[float("nan")])),
                    ("GetLinkStats", service.GetLinkStatsRequest(device="none")),
                    ("EmergencyStop", service.EmergencyStopRequest(device="none")),
                    ("ClearFault", service.ClearFaultRequest(device="finger", fault_ids=[32]))]
        for name, message in requests:
            with self.assertRaises(grpc.RpcError) as by_grpc:
                getattr(self.stub, name)(message, timeout=20)
            code = by_grpc.exception.code().name
            details = dict(by_grpc.exception.trailing_metadata())["grpc-status-details-bin"]
            for kind in TYPES:
                status, error = self.call(name, message, kind)
                self.assertEqual((status, error["code"], error["message"]),
                                 (STATUS[code], code.lower(), by_grpc.exception.details()))
                self.assertIn(self.reason(error).encode(), details)

    def test_what_is_no_request_is_refused(self):
        headers = {**bearer(PRIMARY), "Content-Type": TYPES["json"]}
        for body in (b"", b"{", b"[]", b'{"device": 5}', b'{"device": "\xff"}',
                     b"[" * 60_000, b'{"a":' * 10_000, b"1" * 60_000):
            with Http(self.server.web) as http:
                http.ask("GET", "/healthz")  # more than 16 KB must not come before it is let in
                answer = http.ask("POST", SERVICE + "GetLinkStats", headers, body)
            self.assertEqual(answer.status, 400, body[:20])
            error = json.loads(answer.body)
            self.assertEqual((error["code"], self.reason(error)), ("invalid_argument", "PROTOCOL"))
        for what, status in (({}, 400), ({"Content-Type": "text/plain"}, 415)):
            sent = {**headers, "Content-Type": TYPES["proto"], **what}
            self.assertEqual(self.ask("POST", SERVICE + "GetLinkStats", sent, b"\xff").status,
                             status)
        with Http(self.server.web) as http:
            http.ask("GET", "/healthz")
            too_large = http.ask("POST", SERVICE + "GetLinkStats", headers, b" " * 70_000)
        self.assertEqual((too_large.status, json.loads(too_large.body)["code"]),
                         (429, "resource_exhausted"))
        self.assertEqual(self.ask("POST", SERVICE + "Watch", headers, b"{}").status, 404)
        self.assertEqual(self.ask("PUT", SERVICE + "Engage", headers, b"{}").status, 405)

    def test_unreadable_stop_stops_everything(self):
        for body in (b"", b"{", b"\xff" * 100):
            answer = self.ask("POST", SERVICE + "EmergencyStop",
                              {**bearer(OBSERVER), "Content-Type": TYPES["json"]}, body)
            self.assertEqual((answer.status, json.loads(answer.body)["stopped"]),
                             (200, ["finger"]))
            cleared = self.call("ClearFault", service.ClearFaultRequest(device="finger"))[1]
            self.assertEqual(list(cleared.cleared), [7])

    def test_a_refusal_arrives_whatever_is_on_its_way(self):
        for size in 4 * (2, 15_000, 60_000):
            with Http(self.server.web) as http:
                http.ask("GET", "/healthz")
                answer = http.ask("POST", SERVICE + "Engage", {"Content-Type": TYPES["json"]},
                                  b"x" * size)
                self.assertEqual(answer.status, 401, size)

    def test_a_body_is_no_second_request(self):
        hidden = request("GET", "/healthz")
        for begin in (request("GET", "/metrics", {}, hidden), request("OPTIONS", "/", {}, hidden),
                      request("POST", "/none", {}, hidden)):
            with Http(self.server.web) as http:
                http.send(begin)
                self.assertNotEqual(http.answer().body, b"SERVING\n")
                self.assertTrue(http.closed_within(20.0))
                self.assertNotIn(b"SERVING", http.buffer)

    def test_requests_follow_each_other(self):
        with Http(self.server.web) as http:
            http.send(3 * request("GET", "/healthz"))
            for _ in range(3):
                answer = http.answer()
                self.assertEqual((answer.status, answer.body), (200, b"SERVING\n"))
            self.assertEqual(http.ask("HEAD", "/healthz").fields["content-length"], "8")
            self.assertEqual(http.ask("GET", "/none").status, 404)

    def test_cookies_of_others_cost_nothing(self):
        """Browsers send a host's cookies to every port of it."""
        headers = {**bearer(OBSERVER), "Content-Type": TYPES["json"], "Cookie": "x=" + "y" * 6_000}
        with Http(self.server.web) as http:
            for _ in range(150):
                self.assertEqual(http.ask("POST", SERVICE + "GetServerInfo", headers,
                                          b"{}").status, 200)

    def test_clients_that_left_are_gone(self):
        def connections():
            metrics = self.ask("GET", "/metrics").body.decode()
            return int(metrics.split("\nhaptic_connections ")[1].split()[0])
        before = connections()
        for _ in range(30):
            self.assertEqual(self.info(**bearer(OBSERVER)), 200)
        eventually(lambda: connections() <= before + 1, "their connections are gone")
        with Http(self.server.web) as half:
            half.send(b"GET / HT")
            self.assertTrue(half.closed_within(60.0), "a header that does not end")

    def test_health_and_metrics(self):
        headers = {"Content-Type": TYPES["json"]}
        for body, status, said in ((b"{}", 200, "SERVING"), (b'{"service":"finger"}', 200,
                                   "SERVING"), (b'{"service":"none"}', 404, "not_found")):
            answer = self.ask("POST", "/grpc.health.v1.Health/Check", headers, body)
            self.assertEqual(answer.status, status)
            self.assertIn(said, answer.body.decode())
        metrics = self.ask("GET", "/metrics")
        self.assertIn(b"haptic_loop_ticks_total", metrics.body)
        page = self.ask("GET", "/")
        self.assertEqual((page.status, page.fields["x-content-type-options"],
                          page.fields["referrer-policy"], page.fields["cache-control"]),
                         (200, "nosniff", "no-referrer", "no-store"))

    def test_cookies_of_two_servers_live_together(self):
        with WebServer(argument("HAPTICD")) as other:
            here, there = self.server.redeem()[0], other.redeem()[0]
            self.assertNotEqual(here.split("=")[0], there.split("=")[0])
            self.assertEqual(self.info(Cookie=f"{there}; {here}"), 200)
            self.assertEqual(self.info(Cookie=there), 401)


class Pageless(unittest.TestCase):
    def test_says_why_there_is_no_page(self):
        said = b"The page was not built (needs npm)"
        with tempfile.TemporaryDirectory() as folder:
            front = shutil.copy2(os.path.join(os.path.dirname(argument("HAPTICD")),
                                              "hapticd-front"), folder)
            with mock.patch.dict(os.environ, HAPTICD_FRONT=front), \
                    WebServer(argument("HAPTICD")) as server:
                self.assertIn(said, ask(server.web, "GET", "/").body)
                self.assertIn(said, server.log())


class Encrypted(unittest.TestCase):
    """A certificate is asked for, and a token takes its place."""

    def test_certificate_or_token(self):
        with tempfile.TemporaryDirectory() as folder:
            for name in ("server", "surgeon", "stranger"):
                subprocess.run(
                    ["openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt",
                     "ec_paramgen_curve:prime256v1", "-nodes", "-keyout", f"{folder}/{name}.key",
                     "-out", f"{folder}/{name}.pem", "-subj", f"/CN={name}", "-days", "2",
                     "-addext", "subjectAltName=DNS:localhost"], check=True, capture_output=True)
            with WebServer(argument("HAPTICD"), tls=(
                    f'tls {{ certificate: "{folder}/server.pem" key: "{folder}/server.key" '
                    f'client_ca: "{folder}/surgeon.pem" }}')) as server:
                self.check(server, folder)

    def check(self, server, folder):
        headers = {"Content-Type": TYPES["json"]}

        def context(name=None):
            made = ssl.create_default_context(cafile=f"{folder}/server.pem")
            if name:
                made.load_cert_chain(f"{folder}/{name}.pem", f"{folder}/{name}.key")
            return made

        def engage(tls, **more):
            """A controller's call: NOT_CONTROLLER once it may."""
            return ask(server.web, "POST", SERVICE + "Engage", {**headers, **more},
                       b"{}", host="localhost", tls=tls).status
        self.assertEqual(engage(context()), 401)
        self.assertEqual(engage(context(), **bearer("x" * 20)), 401)
        self.assertEqual(engage(context(), **bearer(PRIMARY)), 403)
        self.assertEqual(engage(context("surgeon")), 403)
        observer = ask(server.web, "POST", SERVICE + "Engage", {**headers, **bearer(OBSERVER)},
                       b"{}", tls=context("surgeon"))
        self.assertIn(b"RIGHTS", observer.body)  # who shows a token has what that allows
        with self.assertRaises((OSError, Closed)):
            engage(context("stranger"), **bearer(PRIMARY))
        pair, cookie = server.redeem(tls=context())
        self.assertIn("Secure", cookie.split("; "))
        self.assertEqual(engage(context(), Cookie=pair), 403)
        own = f"https://localhost:{server.web[1]}"
        self.assertEqual(ask(server.web, "POST", SERVICE + "GetServerInfo",
                             {**headers, "Origin": own, **bearer(OBSERVER)}, b"{}",
                             host=own[8:], tls=context()).status, 200)
        WebSocket(server.web, (JSON,), {"Cookie": pair}, tls=context()).socket.close()
        with self.assertRaises((OSError, Closed)):  # plain text
            ask(server.web, "GET", "/healthz")


if __name__ == "__main__":
    os.environ.setdefault("GRPC_VERBOSITY", "ERROR")
    unittest.main(verbosity=1, argv=sys.argv[:1])
