"""HTTP that no browser would send (../support/web_socket.py)."""

import contextlib
import json
import os
import pathlib
import resource
import socket
import ssl
import sys
import time

from certificates import certificate, tls_of
from daemon import Daemon, resident
from signals import DIRTY, dirty

sys.path.insert(0, str(pathlib.Path(__file__).parent.parent / "support"))
from web_socket import (PROTO, SERVICE, TEXT, Closed, Http, Refused, WebSocket,  # noqa: E402
                        ask, connect, frame, request)
from web_socket import JSON as JSON_PROTOCOL  # noqa: E402

MB = 1 << 20
JSON = {"Content-Type": "application/json"}
INFO = SERVICE + "GetServerInfo"
OPEN = b'{"open":{"role":"ROLE_OBSERVER","clientName":"attacker","device":"finger"}}'


def bearer(daemon):
    return {"Authorization": "Bearer " + daemon.token}


def stream(daemon, protocol=JSON_PROTOCOL, **more):
    """A WebSocket of an observer."""
    return WebSocket(daemon.web, (protocol,), bearer(daemon), **more)


def health(daemon, seconds=1.0):
    """Whether others are served within that: health, and a session that gets states."""
    end = time.monotonic() + seconds
    try:
        if ask(daemon.web, "GET", "/healthz").body != b"SERVING\n":
            return False
        socket_ = stream(daemon, timeout=seconds)
        with socket_:
            socket_.send(frame(TEXT, OPEN))
            while b'"state"' not in socket_.receive()[1]:
                continue
    except (OSError, Closed, Refused):
        return False
    return time.monotonic() < end


def after(daemon, sent=0, notes=(), seconds=1.0, when="afterwards"):
    """What a row answers; new clients are served within `seconds`, tried for 4 s at most."""
    began, wrong = time.monotonic(), []
    while not health(daemon):
        if time.monotonic() > began + 4.0:
            break
        time.sleep(0.02)
    took = time.monotonic() - began
    if took > seconds + 1.0:
        wrong.append(f"browsers served after {took:.1f} s {when}")
    return {"sent": sent, "wrong": wrong, "notes": list(notes)}


def pour(daemon, begin, part, most=32 * MB, seconds=2.5, opened=connect):
    """`begin`, then `part` without end, on connections one after another."""
    sent, until, count = 0, time.monotonic() + seconds, 0
    while sent < most and time.monotonic() < until:
        count += 1
        with contextlib.suppress(OSError, Closed, Refused):
            end = opened(daemon.web)
            with end:
                getattr(end, "socket", end).settimeout(0.5)
                send = getattr(end, "send" if isinstance(end, Http) else "sendall")
                send(begin)
                while sent < most and time.monotonic() < until:
                    send(part)
                    sent += len(part)
    return sent, count


def idle(daemon):
    """Three hundred connections that say nothing, then three hundred after one request."""
    ends, notes = [], []
    for words in (b"", request("GET", "/healthz")):
        with contextlib.suppress(OSError):
            for _ in range(300):
                end = connect(daemon.web, 0.3)
                ends.append(end)
                end.sendall(words)
        notes.append(f"served meanwhile: {health(daemon)}")
    answer = after(daemon, len(ends) * 50, notes, when="meanwhile")
    for end in ends:
        end.close()
    return answer


def gone(end):
    """Whether the far end has closed; what came is dropped."""
    end.setblocking(False)
    try:
        while end.recv(65536):
            continue
    except BlockingIOError:
        return False
    except OSError:
        pass
    return True


def left_behind(daemon):
    """Four hundred clients that ask, and leave: none of their connections stays open."""
    def count():
        text = ask(daemon.web, "GET", "/metrics").body.decode()
        return int(text.split("\nhaptic_connections ")[1].split()[0])
    before, sent = count(), 0
    for i in range(400):
        with contextlib.suppress(OSError, Closed, Refused):
            with stream(daemon) if i % 4 == 0 else Http(daemon.web) as end:
                words = frame(TEXT, OPEN) if i % 4 == 0 else request("GET", "/healthz")
                end.send(words)
                end.receive() if i % 4 == 0 else end.answer()
                sent += len(words)
    end = time.monotonic() + 3.0
    while (now := count()) > before + 1 and time.monotonic() < end:
        time.sleep(0.05)
    answer = after(daemon, sent, [f"{now} connections, {before} before"])
    if now > before + 1:
        answer["wrong"].append(f"{now} connections are open, {before} were before")
    return answer


def slow(daemon, seconds=12.0):
    """A byte per half a second on 24 connections: of a header, of a body, of a frame. None lasts,
    others are served meanwhile."""
    post = request("POST", INFO, {**JSON, **bearer(daemon)}, b"{" * 60_000)
    ends = []
    for kind, words in (("header", b"GET / HTTP/1.1\r\nX: "), ("body", post[:-59_990]),
                        ("frame", frame(TEXT, b"x" * 60_000)[:20])):
        for _ in range(8):
            end = stream(daemon).socket if kind == "frame" else connect(daemon.web)
            end.sendall(words)
            ends.append((kind, end))
    sent, wrong, until = 0, [], time.monotonic() + seconds
    while ends and time.monotonic() < until:
        ends = [(kind, end) for kind, end in ends if not gone(end)]
        for _, end in ends:
            with contextlib.suppress(OSError):
                end.sendall(b"y")
                sent += 1
        if not health(daemon, 2.0) and not wrong:
            wrong.append("browsers not served within 2 s meanwhile")
        time.sleep(0.5)
    if ends:
        wrong.append(f"{len(ends)} slow ones after {seconds:.0f} s: {sorted({k for k, _ in ends})}")
    return {"sent": sent, "wrong": wrong}


def headers(daemon):
    """A request line, a field, and fields without end."""
    begin = b"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\n"
    sent = 0
    for words, part in ((b"GET /", b"x" * 65536), (begin + b"X: ", b"y" * 65536),
                        (begin, b"X: y\r\n" * 10_000), (b"", b"\r\n" * 30_000)):
        sent += pour(daemon, words, part, 8 * MB, 0.7)[0]
    return after(daemon, sent)


def bodies(daemon):
    """A huge Content-Length, and chunks without end, with a token and without."""
    sent = 0
    for more in ({}, bearer(daemon)):
        for fields, part in (({"Content-Length": "99999999999"}, b"z" * 65536),
                             ({"Content-Length": str(250_000)}, b"z" * 65536),
                             ({"Transfer-Encoding": "chunked"}, b"10000\r\n" + b"z" * 65536 +
                              b"\r\n"), ({"Transfer-Encoding": "chunked"}, b"1\r\nz\r\n" * 9_000)):
            begin = request("GET", INFO, {**JSON, **more, **fields}).replace(b"GET", b"POST", 1)
            sent += pour(daemon, begin, part, 4 * MB, 0.5)[0]
    return after(daemon, sent)


def pipelined(daemon):
    """Requests in thousands, whose answers are not read."""
    sent = sum(pour(daemon, b"", 500 * words, 16 * MB, 1.0)[0] for words in (
        request("GET", "/healthz"), request("GET", "/metrics"),
        request("POST", INFO, {**JSON, **bearer(daemon)}, b"{}")))
    return after(daemon, sent)


def smuggled(daemon):
    """A request inside of another's body, for which a proxy would not look."""
    hidden = request("GET", "/healthz")
    chunked = b"0\r\n\r\n" + hidden
    shapes = {
        "GET with a body": (request("GET", "/none", {}, hidden)),
        "HEAD with a body": (request("HEAD", "/none", {}, hidden)),
        "two lengths": request("GET", "/none", {"Content-Length": "0"}, hidden),
        "length and chunks": request("GET", "/none", {"Transfer-Encoding": "chunked",
                                                      "Content-Length": str(len(chunked))}) +
        chunked,
        "chunked twice": request("GET", "/none", {
            "Transfer-Encoding": "chunked, identity"}) + chunked,
        "odd chunked": request("GET", "/none", {"Transfer-Encoding": "\x0bchunked"}) + chunked,
        "folded": request("GET", "/none", {"X": "y\r\n Content-Length: 0"}, hidden),
        "length + 1": request("GET", "/none", {"Content-Length": "+0"}) + b"X" + hidden,
        "refused": request("POST", INFO, JSON, hidden),
        "upgrade": request("GET", SERVICE + "Session", {
            "Upgrade": "websocket", "Connection": "Upgrade", "Sec-WebSocket-Version": "13",
            "Sec-WebSocket-Key": "x"}, hidden)}
    wrong = []
    for name, words in shapes.items():
        with connect(daemon.web, 1.0) as end:
            end.sendall(words)
            came = b""
            with contextlib.suppress(OSError):
                while b"SERVING" not in came and (more := end.recv(65536)):
                    came += more
        if b"SERVING" in came:
            wrong.append(f"{name}: a second request was seen in it")
    answer = after(daemon, sum(map(len, shapes.values())))
    return {**answer, "wrong": wrong + answer["wrong"]}


def wrong_tokens(daemon, seconds=3.0):
    """Tokens are guessed as fast as it goes, on eight connections."""
    https = [Http(daemon.web) for _ in range(8)]
    tried, wrong, until = 0, [], time.monotonic() + seconds
    batch = 50
    while time.monotonic() < until and not wrong:
        for i, http in enumerate(https):
            with contextlib.suppress(OSError, Closed):
                words = b"".join(request("POST", INFO, {
                    **JSON, "Authorization": "Bearer " + os.urandom(8).hex()})
                    if i % 2 else request("GET", "/?token=" + os.urandom(16).hex())
                    for _ in range(batch))
                http.send(words)
                for _ in range(batch):
                    answer = http.answer()
                    tried += 1
                    if answer.status not in (401, 303) or "set-cookie" in answer.fields:
                        wrong.append(f"a guess was answered with {answer}")
                    if answer.fields.get("connection") == "close":
                        raise Closed()
                continue
            http.socket.close()
            https[i] = Http(daemon.web)
    answer = after(daemon, 150 * tried, [f"{tried / seconds:.0f} guesses per second"])
    for http in https:
        http.socket.close()
    return {**answer, "wrong": wrong + answer["wrong"]}


def unread_pages(daemon):
    """Pages and metrics that are asked for and not read, on 90 connections."""
    ends = []
    for i in range(90):
        with contextlib.suppress(OSError):
            end = socket.socket()
            end.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 2048)
            end.settimeout(0.3)
            end.connect(daemon.web)
            ends.append(end)
            end.sendall(100 * request("GET", ("/", "/metrics", "/index.html")[i % 3]))
    answer = after(daemon, 5_000 * len(ends), when="meanwhile")
    for end in ends:
        end.close()
    return answer


def stops(daemon, seconds=2.5):
    """An observer stops the spare device as often as it can: the finger feels nothing of it."""
    with Http(daemon.web) as http:
        words = request("POST", SERVICE + "EmergencyStop", {**JSON, **bearer(daemon)},
                        b'{"device":"spare","reason":"flood"}')
        count, until, wrong = 0, time.monotonic() + seconds, []
        log = daemon.log.stat().st_size
        while time.monotonic() < until and not wrong:
            http.send(20 * words)
            for _ in range(20):
                answer = http.answer()
                count += 1
                if answer.status != 200:
                    wrong.append(f"a stop was answered with {answer}")
    grown = daemon.log.stat().st_size - log
    return {**after(daemon, 200 * count, [f"{count / seconds:.0f} stops per second, "
                                          f"{grown / MB:.1f} MB of log"]), "wrong": wrong}


def strangers(daemon):
    """A stolen cookie from other pages, names that are rebound, and text for the log."""
    end = time.monotonic() + 5.0
    while "/?token=" not in daemon.text() and time.monotonic() < end:
        time.sleep(0.02)
    token = daemon.text().rsplit("/?token=", 1)[1].split()[0]
    wrong = []
    got = ask(daemon.web, "GET", "/?token=" + token)
    cookie = {"Cookie": got.fields.get("set-cookie", "").split(";")[0]}
    host = f"127.0.0.1:{daemon.web[1]}"
    if ask(daemon.web, "POST", INFO, {**JSON, **cookie}, b"{}", host=host).status != 200:
        wrong.append("its own cookie is refused")
    text = DIRTY.encode().decode("latin-1")
    for name, value in (("Origin", "http://evil.example"), ("Origin", "null"), ("Origin", "file:"),
                        ("Origin", f"http://{host}.evil.example"), ("Origin", "http://localhost:1"),
                        ("Origin", text), ("Host", "evil.example"), ("Host", text),
                        ("Host", "127.0.0.1\0"), ("Host", "127.0.0.1\xff"), ("Host", "a\rHost: b"),
                        ("Host", "evil\r\nX: y")):
        more = {**JSON, **cookie, **({name: value} if name != "Host" else {})}
        for target in (INFO, SERVICE + "EmergencyStop"):
            with contextlib.suppress(OSError, Closed):
                answer = ask(daemon.web, "POST", target, more, b"{}",
                             host=value if name == "Host" else host)
                if answer.status not in (400, 403):
                    wrong.append(f"{name} {value[:20]!r}: {answer}")
        with contextlib.suppress(OSError, Closed, Refused):
            WebSocket(daemon.web, (PROTO,), {**cookie, **({name: value} if name != "Host" else {})},
                      host=value if name == "Host" else host)
            wrong.append(f"{name} {value[:20]!r}: a session")
    for name in (text, "\0" * 20, "\xff" * 20, "é"):
        for words in (request("GET", "/?token=" + name), request("GET", "/" + name),
                      request("POST", INFO, {**JSON, "Authorization": "Bearer " + name}),
                      request("POST", SERVICE + name, {**JSON, **bearer(daemon)})):
            with contextlib.suppress(OSError, Closed), Http(daemon.web) as http:
                http.send(words)
                http.answer()
        with contextlib.suppress(OSError, Closed, Refused), stream(daemon) as end:
            end.send(frame(TEXT, json.dumps({"open": {"role": "ROLE_OBSERVER",
                                                      "clientName": DIRTY[:30]}}).encode()))
            end.receive()
        with contextlib.suppress(OSError, Closed, Refused):
            ask(daemon.web, "POST", SERVICE + "EmergencyStop", {**JSON, **bearer(daemon)},
                json.dumps({"device": "spare", "reason": DIRTY}).encode())
    log = daemon.log.read_bytes()
    if found := dirty(log):
        wrong.append("in the log: " + " ".join(sorted(found)))
    if daemon.token.encode() in log or cookie["Cookie"].split("=")[1].encode() in log:
        wrong.append("a secret is in the log")
    answer = after(daemon)
    return {**answer, "wrong": wrong[:8] + answer["wrong"]}


def slow_handshakes(folder):
    """TLS that does not go on after its first bytes, plain text to it, and bytes without end: each
    ends within 8 s, and others are served meanwhile."""
    folder = pathlib.Path(folder)
    certificate(folder, "server")
    daemon = Daemon(folder / "run", record=False, wait=False, web=True,
                    server=tls_of(folder, "server"))
    context = ssl.create_default_context(cafile=f"{folder}/server.pem")

    def serves():
        with contextlib.suppress(OSError, Closed):
            return ask(daemon.web, "GET", "/healthz", tls=context).status == 200
        return False
    wrong = []
    try:
        end = time.monotonic() + 20.0
        while not serves():
            if time.monotonic() > end:
                return {"wrong": ["TLS is not served: " + daemon.text()[-300:]]}
            time.sleep(0.05)
        incoming, outgoing = ssl.MemoryBIO(), ssl.MemoryBIO()
        with contextlib.suppress(ssl.SSLWantReadError):
            context.wrap_bio(incoming, outgoing, server_hostname="localhost").do_handshake()
        hello = outgoing.read()
        before = max(map(resident, daemon.fronts()), default=0)
        ends = []
        for i in range(80):
            with contextlib.suppress(OSError):
                connection = connect(daemon.web, 0.5)
                ends.append(connection)
                connection.sendall((b"", hello[:1], hello[:-1], hello,
                                    request("GET", "/healthz"), os.urandom(9_000))[i % 6])
        if not serves():
            wrong.append("browsers not served within 5 s meanwhile")
        time.sleep(8.0)
        left = sum(not gone(connection) for connection in ends)
        if left:
            wrong.append(f"{left} of {len(ends)} handshakes that do not go on, after 8 s")
        grown = max(map(resident, daemon.fronts()), default=0) - before
        took, status = daemon.stop()
        if took > 5.0 or status != 0:
            wrong.append(f"SIGTERM took {took:.1f} s, status {status}")
        return {"wrong": wrong, "notes": [f"{len(ends)} handshakes, front +{grown / MB:.1f} MB"]}
    finally:
        daemon.kill()


def many_at_sigterm(folder):
    """SIGTERM with 200 connections: sessions that read and those that do not, calls on their way,
    idle ones. It ends within 5 s, and each session that reads hears why."""
    daemon = Daemon(folder, record=False, web=True,
                    limits=[(resource.RLIMIT_NOFILE, 1024)])
    ends, readers, wrong = [], [], []
    try:
        for i in range(90):
            with contextlib.suppress(OSError, Closed, Refused):
                if i % 3 == 0:
                    end = stream(daemon, timeout=2.0)
                    end.send(frame(TEXT, OPEN))
                    (readers if i % 2 else ends).append(end)
                elif i % 3 == 1:
                    end = Http(daemon.web)
                    ends.append(end)
                    end.send(request("POST", SERVICE + "EmergencyStop",
                                     {**JSON, **bearer(daemon)}, b'{"device":"spare"}') * 5)
                else:
                    ends.append(Http(daemon.web))
                    ends[-1].send(b"GET / HT" if i % 2 else b"")
        for _ in range(100):
            with contextlib.suppress(OSError):
                ends.append(Http(daemon.unix))
        for reader in readers:
            reader.receive()
        daemon.process.terminate()
        told = sum((closed := reader.end_within(3.0)) is not None and closed.code == 4014
                   for reader in readers)
        took, status = daemon.stop()
        if took > 5.0 or status != 0:
            wrong.append(f"SIGTERM took {took:.1f} s more, status {status}")
        if told < len(readers):
            wrong.append(f"{told} of {len(readers)} sessions heard why they ended")
    finally:
        daemon.kill()
    return {"wrong": wrong, "notes": [f"{len(ends) + len(readers)} connections"]}
