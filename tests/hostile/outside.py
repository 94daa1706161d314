"""More attacks from outside, by mechanism: what one peer on the network may do to HTTP/2, TCP, UDP,
TLS and the web. Several share a daemon: a row names the part that went wrong."""

import contextlib
import os
import pathlib
import signal
import socket
import ssl
import struct
import subprocess
import threading
import time

from certificates import certificate, tls_of
from daemon import CONTROL, MB, Daemon, end_all, free_port
from faults import until_served
from frames import (DATA, END_HEADERS, END_STREAM, HEADERS, PADDED, PREFACE, PRIORITY, SERVICE,
                    SETTINGS, WINDOW_UPDATE, Peer, call, connect, frame, message, served)

MOST = 12 * MB  # that one part sends
GOOD = PREFACE + frame(SETTINGS, 0, 0) + frame(
    HEADERS, END_HEADERS, 1, call(SERVICE + "GetServerInfo")) + frame(
    DATA, END_STREAM, 1, message(b""))
WATCH = frame(HEADERS, END_HEADERS, 1, call(SERVICE + "Watch")) + frame(
    DATA, END_STREAM, 1, message(b"\x0a\x06finger\x11" + struct.pack("<d", 1000.0)))


def parts(*attacks, root=False):
    """One attack of several: each gets the daemon, or a folder of its own. `root`: to be other
    users, or to take from the host, needs it."""
    def all_of(target):
        if root and os.getuid() != 0:
            return {"notes": ["not on this host: needs root"]}
        whole = {"sent": 0, "wrong": [], "notes": []}
        for one in attacks:
            place = target
            if isinstance(target, str):
                place = f"{target}/{one.__name__}"
                os.mkdir(place, 0o755)
            try:
                answer = one(place) or {}
            except Exception as why:  # noqa: BLE001  a part that cannot run is part of the report
                answer = {"wrong": [f"did not run: {type(why).__name__}: {why}"]}
                end_all(os.getpid(), itself=False)  # daemons that it left
            if not isinstance(target, str) and not served(target.tcp, 1.0):
                answer.setdefault("wrong", []).append("not served afterwards")
            whole["sent"] += answer.get("sent", 0)
            whole["wrong"] += [f"{one.__name__}: {words}" for words in answer.get("wrong", [])]
            whole["notes"].append(" ".join([one.__name__, *answer.get("notes", [])]))
        return whole
    return all_of


def poured(daemon, begin, piece, seconds=0.8, most=MOST):
    """Bytes that the server took of `begin`, and of `piece` again and again; on another connection
    when it was cut."""
    sent, until = 0, time.monotonic() + seconds
    while time.monotonic() < until and sent < most:
        with contextlib.suppress(OSError), Peer(daemon.tcp, timeout=0.5) as peer:
            peer.send(begin)
            while time.monotonic() < until and peer.sent < most and peer.send(piece(peer)):
                peer.drain()
            sent += peer.sent
    return sent


def provoked_resets(daemon):
    """The server is made to take streams back itself (CVE-2025-8671): calls that are whole, and
    then a frame that is an error of their stream alone."""
    zero, most = b"\0\0\0\0", b"\x7f\xff\xff\xff"
    errors = (lambda n: frame(WINDOW_UPDATE, 0, n, zero),
              lambda n: 2 * frame(WINDOW_UPDATE, 0, n, most),
              lambda n: frame(DATA, END_STREAM, n, message(b"")) + frame(DATA, 0, n, b"x"),
              lambda n: frame(PRIORITY, 0, n, struct.pack(">IB", n, 0)),
              lambda n: frame(HEADERS, END_HEADERS, n, call(SERVICE + "Engage")))
    sent = 0
    for error in errors:
        def piece(peer, error=error):
            return b"".join(frame(HEADERS, END_HEADERS, n, call(SERVICE + "GetServerInfo")) +
                            error(n) for n in (peer.stream() for _ in range(50)))
        sent += poured(daemon, b"", piece, 0.6, MOST // 4)
    return {"sent": sent}


def priority_churn(daemon):
    """A tree of priorities of streams that do not exist, hung up elsewhere without end
    (CVE-2019-9513)."""
    tree = b"".join(frame(PRIORITY, 0, i + 2, struct.pack(">IB", 1 << 31 | i, i & 255))
                    for i in range(1, 4_000, 2))
    return {"sent": poured(daemon, b"", lambda _: tree)}


def window_flips(daemon):
    """The first window of 90 open streams from nothing to 2 GB and back."""
    begin = b"".join(frame(HEADERS, END_HEADERS, 2 * i + 1, call(SERVICE + "Session"))
                     for i in range(90))
    flips = b"".join(frame(SETTINGS, 0, 0, struct.pack(">HI", 4, size))
                     for _ in range(200) for size in (0, 0x7fffffff))
    return {"sent": poured(daemon, begin, lambda _: flips)}


def padding(daemon):
    """A session whose opening never ends, between 255 bytes of padding for each byte."""
    begin = frame(HEADERS, END_HEADERS, 1, call(SERVICE + "Session")) + frame(
        DATA, 0, 1, b"\0\0\0\xff\xff")
    part = 60 * frame(DATA, PADDED, 1, b"\xff\x0a" + bytes(255))
    return {"sent": poured(daemon, begin, lambda _: part)}


def reset_before_accept(daemon, seconds=2.0):
    """Connections that are reset before anyone took them from the queue."""
    count, until = 0, time.monotonic() + seconds
    linger = struct.pack("ii", 1, 0)
    while time.monotonic() < until:
        with contextlib.suppress(OSError), socket.socket() as end:
            end.setblocking(False)
            end.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, linger)
            end.connect_ex(daemon.tcp)
            end.send(PREFACE)
            count += 1
    return {"sent": 200 * count, "notes": [f"{count}"]}


def odd_segments(daemon):
    """A good call in segments of one byte is answered; urgent bytes are no part of one, over TCP
    and UNIX."""
    ends = [connect(daemon.tcp, 2.0) for _ in range(20)]
    for end in ends:
        end.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    for i in range(len(GOOD)):
        for end in ends:
            end.send(GOOD[i:i + 1])
    time.sleep(0.2)
    mute = sum(1 for end in ends if b"under attack" not in end.recv(1 << 16))
    for end in ends:
        end.close()
    for address in 10 * (daemon.tcp, daemon.unix):
        with contextlib.suppress(OSError), connect(address, 0.5) as end:
            for i in range(0, len(GOOD), 7):
                end.send(GOOD[i:i + 7])
                end.send(b"!", socket.MSG_OOB)
    return {"wrong": [f"{mute} of 20 are not answered"] if mute else []}


def many_addresses(daemon):
    """Three hundred peers of one connection each, every one with a watch: a newcomer is served
    meanwhile all the same."""
    ends = []
    for i in range(300):
        with contextlib.suppress(OSError):
            end = socket.socket()
            end.bind((f"127.9.{i // 200}.{i % 200 + 1}", 0))
            end.settimeout(0.3)
            end.connect(daemon.tcp)
            end.sendall(PREFACE + frame(SETTINGS, 0, 0) + WATCH)
            ends.append(end)
    time.sleep(0.5)
    wrong = [] if served(daemon.tcp, 1.0) else ["a newcomer is not served meanwhile"]
    for end in ends:
        end.close()
    return {"wrong": wrong, "notes": [f"{len(ends)}"]}


def twins(daemon):
    """Every number on both carriers with different words: taken once."""
    from calls import FREE, wire
    from datagrams import Path
    path = Path(daemon)
    for _ in range(50):
        path.send(path.sample(position=[0.9]))
        path.session.queue.put(wire.SessionRequest(proxy=wire.ProxySample(
            seq=path.session.seq, mode=FREE, position=[-0.9])))
        time.sleep(0.004)
    taken = path.accepted()
    path.end()
    return {"wrong": [f"{taken} of 50 numbers were taken"] if taken > 50 else []}


def reflected(daemon):
    """What the server sends comes back to it, and what is sealed for one path comes with the number
    of another."""
    import datagram
    from calls import OBSERVER
    from datagrams import Path
    path, other = Path(daemon), Path(daemon, device="finger", role=OBSERVER)
    path.send(path.sample())
    heard, until = [], time.monotonic() + 0.4
    while time.monotonic() < until:
        with contextlib.suppress(OSError):
            heard.append(path.socket.recv(2048))
    before = path.accepted()
    for one in heard:
        path.send(one, 20)
        other.send(one, 20)
    crossed = datagram.Sealer(other.offer.path_id, path.offer.up_key, path.offer.up_salt)
    swapped = datagram.Sealer(path.offer.path_id, path.offer.down_key, path.offer.down_salt)
    for sealer in (crossed, swapped):
        for _ in range(50):
            path.send(sealer.seal(datagram.PROXY, b"\x08\x7f"))
    grew = path.accepted() - before
    path.end()
    other.end()
    return {"wrong": ([f"{grew} taken"] if grew else []) + ([] if heard else ["nothing heard"]),
            "notes": [f"{len(heard)} sent back"]}


def across_fronts(daemon):
    """Datagrams that were sealed for the front that died, to the one that resumed the session."""
    from datagrams import Path
    path = Path(daemon, resumable=True)
    path.send(path.sample())
    path.accepted()
    kept = [path.sample() for _ in range(50)]
    for pid in daemon.fronts():
        os.kill(pid, signal.SIGKILL)
    until_served(daemon)
    path.session.end()
    again = Path(daemon, resumable=True, resume=path.session.opened.session_id)
    before = again.accepted()
    for one in kept:
        again.send(one)
    grew, answers = again.accepted() - before, again.answers()
    again.end()
    path.end()
    return {"wrong": [f"{grew} taken, {answers} answers"] if grew or answers else []}


def raced_token(daemon):
    """The printed token, shown by forty at once: it works once."""
    from web import ask
    end = time.monotonic() + 5.0
    while "/?token=" not in daemon.text() and time.monotonic() < end:
        time.sleep(0.02)
    token = daemon.text().rsplit("/?token=", 1)[1].split()[0]
    cookies, gate = [], threading.Barrier(40)

    def show():
        gate.wait()
        with contextlib.suppress(Exception):
            cookies.append(ask(daemon.web, "GET", "/?token=" + token).fields.get("set-cookie"))
    threads = [threading.Thread(target=show) for _ in range(40)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    got = sum(1 for cookie in cookies if cookie)
    return {"wrong": [] if got == 1 else [f"it worked {got} times"]}


def odd_paths(daemon):
    """Ways out of the page's folder, and methods that are none of a page's."""
    from web import ask
    wrong = []
    for path in ("/../../etc/passwd", "/%2e%2e/%2e%2e/etc/passwd", "//etc/passwd", "/..%2fetc",
                 "/\\..\\..\\etc\\passwd", "/%00", "/index.html%00.js", "/./../proc/self/environ",
                 "/proc/self/environ", "/index.html/", "/%c0%ae%c0%ae/etc/passwd", "/.", "/~root"):
        with contextlib.suppress(OSError):
            answer = ask(daemon.web, "GET", path)
            if answer.status == 200 or b"root:" in answer.body:
                wrong.append(f"{path}: {answer}")
    for method in ("TRACE", "CONNECT", "PUT", "DELETE", "PROPFIND", "OPTIONS"):
        with contextlib.suppress(Exception):
            answer = ask(daemon.web, method, "/index.html", {"X-Secret": "echo"})
            if b"echo" in answer.body or answer.status == 200:
                wrong.append(f"{method}: {answer}")
    return {"wrong": wrong[:4]}


def doubled_fields(daemon):
    """Host and Origin twice: it is the first that counts, which is refused."""
    from web import INFO, Http, bearer
    wrong, host = [], f"127.0.0.1:{daemon.web[1]}"
    for name, own in (("Host", host), ("Origin", f"http://{host}")):
        lines = [f"POST {INFO} HTTP/1.1", f"{name}: http://evil.example", f"{name}: {own}",
                 "Authorization: " + bearer(daemon)["Authorization"], "Content-Length: 2",
                 "Content-Type: application/json", *([f"Host: {host}"] if name != "Host" else [])]
        with contextlib.suppress(Exception), Http(daemon.web) as http:
            http.send("\r\n".join(lines).encode() + b"\r\n\r\n{}")
            if http.answer().status == 200:
                wrong.append(f"{name}: served")
    return {"wrong": wrong}


def issue(folder, name, names):
    """A client's certificate with these DNS names, of the folder's issuer."""
    import datetime
    from cryptography import x509
    from cryptography.hazmat.primitives import hashes, serialization as form
    from cryptography.hazmat.primitives.asymmetric import ec
    ca = x509.load_pem_x509_certificate(pathlib.Path(f"{folder}/ca.pem").read_bytes())
    ca_key = form.load_pem_private_key(pathlib.Path(f"{folder}/ca.key").read_bytes(), None)
    key, now = ec.generate_private_key(ec.SECP256R1()), datetime.datetime.utcnow()
    day = datetime.timedelta(days=1)
    made = x509.CertificateBuilder(
        ca.issuer, x509.Name([x509.NameAttribute(x509.NameOID.COMMON_NAME, name)]),
        key.public_key(), x509.random_serial_number(), now - day, now + day).add_extension(
        x509.SubjectAlternativeName(map(x509.DNSName, names)), False).sign(ca_key, hashes.SHA256())
    pathlib.Path(f"{folder}/{name}.pem").write_bytes(made.public_bytes(form.Encoding.PEM))
    pathlib.Path(f"{folder}/{name}.key").write_bytes(key.private_bytes(
        form.Encoding.PEM, form.PrivateFormat.TraditionalOpenSSL, form.NoEncryption()))


def tls_server(folder):
    """A daemon with TLS: gRPC asks for certificates, browsers need none."""
    for name in ("server", "ca"):
        certificate(folder, name)
    os.chmod(f"{folder}/server.key", 0o600)
    port = free_port(socket.SOCK_STREAM)
    daemon = Daemon(f"{folder}/run", wait=False, record=False, server=tls_of(
        folder, "server", f'client_ca: "{folder}/ca.pem" client {{ name: "surgeon" '
        'highest_priority: "operator" }') + f' web {{ listen: "127.0.0.1:{port}" }}')
    daemon.web = ("127.0.0.1", port)
    end = time.monotonic() + 10.0
    while time.monotonic() < end and "/?token=" not in daemon.text():
        time.sleep(0.05)
    return daemon


def carried_ticket(folder):
    """A session of TLS that the web gave without a certificate, resumed where one is needed."""
    daemon = tls_server(folder)
    wrong = []
    try:
        for version in (ssl.TLSVersion.TLSv1_2, ssl.TLSVersion.TLSv1_3):
            context = ssl.create_default_context(cafile=f"{folder}/server.pem")
            context.set_alpn_protocols(["h2", "http/1.1"])
            context.minimum_version = context.maximum_version = version
            with context.wrap_socket(
                    connect(daemon.web, 2.0), server_hostname="localhost") as end:
                end.sendall(b"GET /healthz HTTP/1.1\r\nHost: localhost\r\n\r\n")
                end.recv(1000)
                ticket = end.session
            if ticket is None:
                continue
            with contextlib.suppress(OSError), context.wrap_socket(
                    connect(daemon.tcp, 2.0), server_hostname="localhost",
                    session=ticket) as end:
                end.sendall(GOOD)
                came, until = b"", time.monotonic() + 1.0
                while time.monotonic() < until and len(came) < 4_000:
                    came += end.recv(1 << 16)
                    if b"under attack" in came:
                        wrong.append(f"{version.name}: served without a certificate")
                        break
    finally:
        daemon.stop()
    return {"wrong": wrong}


def odd_names(folder):
    """Certificates whose names are nearly one that the scene lists: none has its priority, and the
    log stays clean."""
    from certificates import priority
    from signals import dirty
    daemon, wrong = tls_server(folder), []
    kinds = {"nul": ["surgeon\0.evil"], "case": ["SURGEON"], "wild": ["*"], "dot": ["surgeon."],
             "blank": [" surgeon"], "text": ["evil\x1b[31m\n2026 forged line"],
             "many": [f"n{i}.example" for i in range(400)], "surgeon": ["surgeon"]}
    try:
        for name, names in kinds.items():
            issue(folder, name, names)
            if (priority(daemon, folder, name) == "OK") != (name == "surgeon"):
                wrong.append(f"{name}: wrong priority")
    finally:
        daemon.stop()
    found = dirty(daemon.log.read_bytes())
    return {"wrong": wrong + ([f"in the log: {' '.join(sorted(found))}"] if found else [])}


def handshakes_again(folder):
    """Renegotiation and new keys asked for without end, and a chain of certificates of 190 KB:
    others are served meanwhile, and SIGTERM ends it."""
    daemon = tls_server(folder)
    issue(folder, "good", ["good"])
    pathlib.Path(f"{folder}/chain.pem").write_bytes(
        pathlib.Path(f"{folder}/good.pem").read_bytes() +
        300 * pathlib.Path(f"{folder}/ca.pem").read_bytes())
    wrong, running = [], []
    try:
        for words, letter in ((["-tls1_2"], b"R\n"), (["-tls1_3"], b"K\n"), (["-tls1_3"], b"k\n"),
                              (["-cert_chain", f"{folder}/chain.pem"], b"")):
            for address in (daemon.address, f"127.0.0.1:{daemon.web[1]}"):
                one = subprocess.Popen(
                    ["openssl", "s_client", "-connect", address, "-alpn", "h2", "-cert",
                     f"{folder}/good.pem", "-key", f"{folder}/good.key", *words],
                    stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
                running.append(one)
                threading.Thread(target=lambda one=one, letter=letter: [
                    one.stdin.write(letter) or one.stdin.flush() or time.sleep(0.0005)
                    for _ in range(4_000) if one.poll() is None], daemon=True).start()
        time.sleep(1.0)
        began = time.monotonic()
        done = subprocess.run([CONTROL, "--server", daemon.address, "--ca", f"{folder}/server.pem",
                               "--server-name", "localhost", "--cert", f"{folder}/good.pem",
                               "--key", f"{folder}/good.key", "info"], capture_output=True,
                              timeout=20.0)
        if done.returncode != 0 or time.monotonic() > began + 2.0:
            wrong.append(f"another: status {done.returncode} "
                         f"after {time.monotonic() - began:.1f} s")
    finally:
        took, status = daemon.stop()
        for one in running:
            one.kill()
            one.wait()
    if took > 5.0 or status != 0:
        wrong.append(f"SIGTERM: status {status} after {took:.1f} s")
    return {"wrong": wrong}


SERVED = "memory flat, served again within 1 s, force as promised"
ROWS = [("outside_http2", SERVED, parts(provoked_resets, priority_churn, window_flips, padding),
         {"seconds": 60.0}),
        ("outside_tcp", SERVED, parts(reset_before_accept, odd_segments, many_addresses),
         {"seconds": 60.0}),
        ("outside_udp", "taken once, or dropped", parts(twins, reflected, across_fronts), {}),
        ("outside_web", "refused", parts(raced_token, odd_paths, doubled_fields), {"web": True}),
        ("outside_tls", "refused", parts(carried_ticket, odd_names, handshakes_again),
         {"alone": True, "seconds": 60.0})]
