"""Frames and header blocks that no client sends."""

import struct
import time

from frames import (
    ACK, CONTINUATION, DATA, END_HEADERS, END_STREAM, GOAWAY, GRPC, HEADERS, PADDED, PING, PREFACE,
    PRIORITY, PUSH_PROMISE, REQUEST, RST_STREAM, SERVICE, SETTINGS, WINDOW_UPDATE, Peer, block,
    call, connect, frame, integer, junk, literal, message, served)

MB = 1 << 20
INFO = SERVICE + "GetServerInfo"
FLOOD_S = 2.5  # for what costs nothing but time
MOST = 96 * MB  # for what costs memory


def ask(peer, headers, seconds=0.3, payload=b""):
    """A call with these headers; the frames that came back."""
    number = peer.stream()
    peer.send(frame(HEADERS, END_HEADERS, number, headers) +
              frame(DATA, END_STREAM, number, message(payload)))
    return list(peer.read(seconds))


def each(daemon, requests, polite=True):
    """Every header block on a connection of its own; the server must answer others after each."""
    sent, wrong = 0, []
    for i, headers in enumerate(requests):
        with Peer(daemon.tcp, polite=polite) as peer:
            if polite:
                peer.drain(0.05)
            ask(peer, headers)
            sent += peer.sent
        if not served(daemon.tcp):
            wrong.append(f"not served after request {i}")
    return {"sent": sent, "wrong": wrong}


def odd_headers(daemon):
    """te, :scheme, load balancers' headers, alone and with 12 KB more, polite and not."""
    big = [("x", "y" * 12_000)]
    odd = [
        block(*REQUEST, (":path", INFO), ("te", "gzip"), GRPC[1]),
        block((":method", "POST"), (":scheme", "ftp"), (":path", INFO), *GRPC),
        call(INFO, ("lb-token", "x" * 400), ("lb-cost-bin", "AAAA")),
        call(INFO, ("grpc-lb-client-stats", "x"), ("lb-cost-bin", "!"), *big),
    ]
    polite, rude = each(daemon, odd), each(daemon, odd, polite=False)
    return {"sent": polite["sent"] + rude["sent"], "wrong": polite["wrong"] + rude["wrong"]}


def odd_metadata(daemon):
    return each(daemon, [
        call(INFO, ("grpc-timeout", "99999999999999H")),
        call(INFO, ("grpc-timeout", "-1S")),
        call(INFO, ("grpc-timeout", "")),
        call(INFO, ("grpc-encoding", "brotli\x7f")),
        call(INFO, ("grpc-encoding", "snappy")),
        call(INFO, ("x-bin", "not base64 !!")),
        call(INFO, ("grpc-trace-bin", "=" * 5000)),
        call(INFO, (":path", SERVICE + "ListDevices")),
        call(INFO, ("", "")),
        call(INFO, ("Upper", "Case")),
        call(INFO, ("x", "a\r\nb: c")),
        call("/" * 8000),
    ])


def large_headers(daemon):
    return each(daemon, [call(INFO, ("x", "y" * size)) for size in (7_000, 9_000, 15_900)])


def continuation(daemon, polite):
    """A header block without end."""
    with Peer(daemon.tcp, polite=polite, timeout=2.0) as peer:
        if polite:
            peer.drain(0.1)
        number = peer.stream()
        peer.send(frame(HEADERS, 0, number, call(INFO)))
        part = frame(CONTINUATION, 0, number, literal("x", "y" * 16_000))
        end = time.monotonic() + 2 * FLOOD_S
        while peer.sent < MOST and time.monotonic() < end and peer.send(part):
            if polite:
                peer.drain()
        time.sleep(0.5)  # what it took stands in memory now
        return {"sent": peer.sent}


def continuation_unacked(daemon):
    return continuation(daemon, False)


def continuation_acked(daemon):
    return continuation(daemon, True)


def flood(daemon, begin, part, opens_stream=False):
    """`begin`, then `part` for FLOOD_S, in pieces of 64 KB."""
    with Peer(daemon.tcp, timeout=1.0) as peer:
        peer.drain(0.1)
        if opens_stream:
            peer.stream()
        peer.send(begin)
        piece = part * max(1, (1 << 16) // len(part))
        end = time.monotonic() + FLOOD_S
        while time.monotonic() < end and peer.send(piece):
            peer.drain()
        return {"sent": peer.sent, "notes": ["connection closed" if peer.closed else
                                             "connection kept"]}


def empty_continuation(daemon):
    return flood(daemon, frame(HEADERS, 0, 1, call(INFO)), frame(CONTINUATION, 0, 1), True)


def empty_data(daemon):
    return flood(daemon, frame(HEADERS, END_HEADERS, 1, call(SERVICE + "Session")),
                 frame(DATA, 0, 1), True)


def ping_flood(daemon):
    return flood(daemon, b"", frame(PING, 0, 0, b"12345678"))


def settings_flood(daemon):
    return flood(daemon, b"", frame(SETTINGS, 0, 0, struct.pack(">HI", 4, 65_535)))


def hpack_bomb(daemon):
    """A large value in the dynamic table, then a thousand references to it, a byte each."""
    with Peer(daemon.tcp, timeout=2.0) as peer:
        peer.drain(0.1)
        value = "y" * 3_900
        store = b"\x40" + integer(1, 7) + b"x" + integer(len(value), 7) + value.encode()
        peer.send(frame(HEADERS, END_HEADERS, peer.stream(), call(INFO) + store))
        for _ in range(200):
            bomb = call(INFO) + b"\xbe" * 12_000  # index 62: the newest entry
            if not peer.send(frame(HEADERS, END_HEADERS | END_STREAM, peer.stream(), bomb)):
                break
            peer.drain()
        peer.drain(0.3)
        return {"sent": peer.sent, "notes": [f"{200 * 12_000 * 3_900 / MB:.0f} MB unpacked"]}


def hpack_integers(daemon):
    endless = b"\xff" * 4_000
    return each(daemon, [
        call(INFO) + b"\xff" + b"\x80" * 12 + b"\x01",  # index beyond 64 bits
        call(INFO) + b"\xff" + b"\xff" * 9 + b"\x7f",
        call(INFO) + b"\x80",  # index 0
        call(INFO) + b"\xff\x00\x7f",  # no such entry
        call(INFO) + b"\x00" + endless,
        call(INFO) + b"\x00\x01x\xff" + b"\x80" * 9 + b"\x01",  # a length of 2^63
        call(INFO) + b"\x00\x81\xff",  # Huffman with a bad end
        junk(8_000),
    ])


def hpack_table_size(daemon):
    sizes = [integer(size, 5, 0x20) for size in (0, 4096, 1 << 16, (1 << 32) - 1, 1 << 40)]
    return each(daemon, [*(size + call(INFO) for size in sizes), b"\x20" * 8_000 + call(INFO),
                         call(INFO) + b"\x3f\xe1\x1f"])


def odd_frames(daemon):
    """Eleven that break a rule of RFC 9113, each on a connection of its own, and a window that
    overflows."""
    four = struct.pack(">I", 0x7fffffff)
    odd = [
        frame(DATA, 0, 0, b"x"),
        frame(DATA, 0, 7, b"x" * 100),
        frame(HEADERS, END_HEADERS, 0, call(INFO)),
        frame(HEADERS, END_HEADERS | PADDED, 1, b"\xff" + b"x" * 4),
        frame(HEADERS, END_HEADERS, 2, call(INFO)),
        frame(CONTINUATION, END_HEADERS, 1, call(INFO)),
        frame(PRIORITY, 0, 1, b"\0\0\0\1\0"),
        frame(RST_STREAM, 0, 0, b"\0\0\0\0"),
        frame(SETTINGS, ACK, 0, b"x" * 6),
        frame(SETTINGS, 0, 0, b"x" * 5) + frame(SETTINGS, 0, 0, struct.pack(">HI", 5, 1)),
        frame(PUSH_PROMISE, END_HEADERS, 1, b"\0\0\0\2") + frame(GOAWAY, 0, 0, b"x" * 8),
        frame(WINDOW_UPDATE, 0, 0, four) * 4 + frame(WINDOW_UPDATE, 0, 0, b"\0\0\0\0"),
        frame(0xee, 0xff, 0xffffffff, b"x" * 200),
        frame(DATA, 0, 1, b"", length=(1 << 24) - 1) + b"x" * 70_000,
    ]
    sent, wrong = 0, []
    for i, bad in enumerate(odd):
        with Peer(daemon.tcp) as peer:
            peer.drain(0.03)
            peer.send(bad)
            peer.drain(0.1)
            sent += peer.sent
        if not served(daemon.tcp):
            wrong.append(f"not served after frame {i}")
    return {"sent": sent, "wrong": wrong}


def other_protocols(daemon):
    """HTTP/1, junk, a TLS hello, half a preface: on the plain port, TCP and UNIX."""
    hello = b"\x16\x03\x01\x00\xa5\x01\x00\x00\xa1\x03\x03" + junk(160)
    sent = 0
    for address in (daemon.tcp, daemon.unix):
        for words in (b"GET / HTTP/1.1\r\nHost: a\r\n\r\n", junk(5_000), hello, PREFACE[:10],
                      PREFACE + junk(500), b"\0" * 100_000):
            with connect(address) as end:
                end.settimeout(0.2)
                try:
                    end.sendall(words)
                    end.recv(1000)
                except OSError:
                    pass
                sent += len(words)
    return {"sent": sent}
