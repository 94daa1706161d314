"""The port of the metrics: HTTP that no scraper sends."""

import contextlib
import socket
import time

from frames import connect

MB = 1 << 20


def address(daemon):
    return ("127.0.0.1", daemon.metrics)


def scrape(daemon, seconds=1.0):
    """How long a scrape took; None: it did not come within `seconds`."""
    began = time.monotonic()
    answer = b""
    try:
        with connect(address(daemon), seconds) as end:
            end.sendall(b"GET /metrics HTTP/1.1\r\nHost: a\r\nConnection: close\r\n\r\n")
            while time.monotonic() < began + seconds:
                came = end.recv(1 << 16)
                if not came:
                    break
                answer += came
    except OSError:
        return None
    return time.monotonic() - began if b"haptic_loop_ticks_total" in answer else None


def pour(daemon, begin, part, most=64 * MB, seconds=3.0):
    """`begin`, then `part` without end."""
    sent = 0
    with connect(address(daemon)) as end:
        end.settimeout(0.5)
        with contextlib.suppress(OSError):
            end.sendall(begin)
            until = time.monotonic() + seconds
            while sent < most and time.monotonic() < until:
                end.sendall(part)
                sent += len(part)
        time.sleep(0.3)
    return sent


def after(daemon, sent, notes=()):
    took = scrape(daemon)
    return {"sent": sent, "notes": list(notes),
            "wrong": [] if took is not None else ["no scrape within 1 s afterwards"]}


def endless_line(daemon):
    return after(daemon, pour(daemon, b"GET /", b"x" * (1 << 16)))


def endless_header(daemon):
    return after(daemon, pour(daemon, b"GET /metrics HTTP/1.1\r\nX: ", b"y" * (1 << 16)))


def many_headers(daemon):
    return after(daemon, pour(daemon, b"GET /metrics HTTP/1.1\r\n", b"X: y\r\n" * 10_000))


def chunked_post(daemon):
    begin = b"POST /metrics HTTP/1.1\r\nHost: a\r\nTransfer-Encoding: chunked\r\n\r\n"
    return after(daemon, pour(daemon, begin, b"10000\r\n" + b"z" * (1 << 16) + b"\r\n"))


def long_body(daemon):
    begin = b"POST /x HTTP/1.1\r\nHost: a\r\nContent-Length: 99999999999\r\n\r\n"
    return after(daemon, pour(daemon, begin, b"z" * (1 << 16)))


def slow_bytes(daemon, seconds=5.0):
    """One byte per 1.5 s on eight connections: others are scraped meanwhile."""
    ends = [connect(address(daemon)) for _ in range(8)]
    for end in ends:
        end.sendall(b"GET /metrics HTTP/1.1\r\nX: ")
    wrong, sent, until, due = [], 0, time.monotonic() + seconds, 0.0
    while time.monotonic() < until:
        if time.monotonic() > due:
            due = time.monotonic() + 1.5
            for end in ends:
                with contextlib.suppress(OSError):
                    end.sendall(b"y")
                    sent += 1
        if scrape(daemon) is None and not wrong:
            wrong.append("no scrape within 1 s meanwhile")
        time.sleep(0.2)
    for end in ends:
        end.close()
    return {"sent": sent, "wrong": wrong}


def unread(daemon):
    """Asks and does not read the answer, 60 times."""
    ends = []
    for _ in range(60):
        with contextlib.suppress(OSError):
            end = socket.socket()
            end.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 2048)
            end.settimeout(0.3)
            end.connect(address(daemon))
            end.sendall(b"GET /metrics HTTP/1.1\r\nHost: a\r\n\r\n" * 20)
            ends.append(end)
    took = scrape(daemon)
    for end in ends:
        end.close()
    return {"wrong": [] if took is not None else ["no scrape within 1 s meanwhile"]}


def ranges(daemon):
    """Many ranges of a page at once."""
    many = b",".join(b"%d-%d" % (i, i + 40_000) for i in range(1_500))
    wrong, largest = [], 0
    for words in (b"bytes=" + many[:7_000], b"bytes=0-0," * 500 + b"1-1", b"bytes=-99999999",
                  b"bytes=5-2", b"bytes=99999999999999999999-", b"bytes=" + b"0-," * 600):
        with connect(address(daemon), 1.0) as end:
            got = 0
            with contextlib.suppress(OSError):
                end.sendall(b"GET /metrics HTTP/1.1\r\nHost: a\r\nConnection: close\r\nRange: " +
                            words + b"\r\n\r\n")
                while got < 64 * MB:
                    came = end.recv(1 << 16)
                    if not came:
                        break
                    got += len(came)
            largest = max(largest, got)
    if largest > MB:
        wrong.append(f"{largest / MB:.1f} MB came back for one page of ranges")
    if scrape(daemon) is None:
        wrong.append("no scrape within 1 s afterwards")
    return {"wrong": wrong, "notes": [f"largest answer {largest} bytes"]}


def idle(daemon):
    """Three hundred connections that say nothing."""
    ends = []
    with contextlib.suppress(OSError):
        for _ in range(300):
            ends.append(connect(address(daemon), 0.3))
    took = scrape(daemon)
    time.sleep(1.0)
    for end in ends:
        end.close()
    return {"wrong": [] if took is not None else ["no scrape within 1 s meanwhile"],
            "notes": [f"{len(ends)} connections"]}


def odd_requests(daemon):
    """Requests that are wrong in one way each."""
    get = b"GET /metrics HTTP/1.1\r\nHost: a\r\n"
    odd = [
        b"\r\n\r\n", b"GET\r\n\r\n", b"GET /metrics\r\n\r\n", b"GET /metrics HTTP/9.9\r\n\r\n",
        b"BREW /metrics HTTP/1.1\r\n\r\n", b"GET /../../etc/passwd HTTP/1.1\r\n\r\n",
        b"GET /metrics%00 HTTP/1.1\r\n\r\n", b"GET " + b"/" * 9_000 + b" HTTP/1.1\r\n\r\n",
        get + b"Content-Length: -1\r\n\r\n",
        get + b"Content-Length: 1\r\nContent-Length: 2\r\n\r\n",
        get + b"Content-Length: 99999999999999999999\r\n\r\n", get + b": x\r\n\r\n",
        get + b"X\r\n\r\n", get + b"X: " + b"\0" * 100 + b"\r\n\r\n",
        get + b"Expect: 100-continue\r\n\r\n", get + b"Upgrade: h2c\r\n\r\n",
        get + b"Transfer-Encoding: chunked\r\n\r\nffffffffffffffff\r\n",
        get + b"Transfer-Encoding: chunked\r\n\r\n-1\r\n", get + b"\n", b"PRI * HTTP/2.0\r\n\r\n",
        b"HEAD /metrics HTTP/1.1\r\n\r\n", b"CONNECT a:1 HTTP/1.1\r\n\r\n",
        b"\x16\x03\x01" + b"x" * 99,
        b"POST /metrics HTTP/1.1\r\nContent-Length: 2000\r\n\r\n" + b"x" * 2_000,
        get + b"Range: bytes=0-\r\n\r\n", get + b"If-None-Match: *\r\n\r\n",
        b"GET http:" + b"//a/metrics HTTP/1.1\r\n\r\n", b"OPTIONS * HTTP/1.1\r\n\r\n",
    ]
    sent = 0
    for words in odd:
        with connect(address(daemon), 0.3) as end, contextlib.suppress(OSError):
            end.sendall(words)
            sent += len(words)
            end.recv(1000)
    return after(daemon, sent, [f"{len(odd)} requests"])
