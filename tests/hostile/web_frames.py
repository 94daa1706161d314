"""WebSockets that no browser would open, and frames that none would send."""

import contextlib
import os
import socket
import time

from web import INFO, JSON, MB, OPEN, after, bearer, pour, stream
from web_socket import (BINARY, CLOSE, CONTINUATION, PING, PROTO, TEXT, Closed, Http, Refused,
                        frame)


def upgrades(daemon, seconds=3.0):
    """WebSockets as fast as it goes; none opens a session."""
    ends, count, until = [], 0, time.monotonic() + seconds
    while time.monotonic() < until:
        with contextlib.suppress(OSError, Closed, Refused):
            ends.append(stream(daemon, timeout=0.5))
            count += 1
        if len(ends) > 200:
            ends.pop(0).socket.close()
    answer = after(daemon, 300 * count, [f"{count} upgrades"], when="meanwhile")
    for end in ends:
        end.socket.close()
    return answer


def odd_frames(daemon):
    """Frames that break the protocol, and halves of them that stay, on 200 connections."""
    odd = [frame(BINARY, b"x", mask=False), frame(BINARY, length=1 << 63),
           frame(BINARY, length=(1 << 64) - 1), frame(BINARY, length=255 * 1024),
           frame(BINARY, b"x" * 200_000, length=255 * 1024), frame(CONTINUATION, b"x"),
           frame(BINARY, b"x", reserved=7), frame(TEXT, b"x", fin=False) * 2, frame(3, b"x"),
           frame(PING, b"x" * 126), frame(CLOSE, b"x"), frame(CLOSE, os.urandom(125)),
           os.urandom(5_000), b"\x82", b"\x82\xff" + b"\0" * 7]
    ends, sent = [], 0
    for i in range(200):
        with contextlib.suppress(OSError, Closed, Refused):
            end = stream(daemon, PROTO, timeout=0.5)
            ends.append(end)
            end.send(odd[i % len(odd)])
            sent += len(odd[i % len(odd)])
    answer = after(daemon, sent, [f"{len(ends)} connections"], when="meanwhile")
    for end in ends:
        end.socket.close()
    return answer


def fragments(daemon):
    """A message of parts of one byte, and of none, without end."""
    begin, sent = frame(BINARY, b"x", fin=False), 0
    for part in (frame(CONTINUATION, b"x", fin=False), frame(CONTINUATION, fin=False)):
        sent += pour(daemon, begin, 4_000 * part, 16 * MB, 1.5,
                     lambda _: stream(daemon, PROTO))[0]
    return after(daemon, sent)


def pings(daemon):
    """Pings, pongs and closes without end, none of whose answers is read."""
    sent = 0
    for begin, part in ((frame(TEXT, OPEN), frame(PING)), (frame(TEXT, OPEN), frame(10, b"x")),
                        (b"", frame(PING, b"x" * 125)), (frame(CLOSE), frame(CLOSE))):
        sent += pour(daemon, begin, 4_000 * part, 16 * MB, 0.8, lambda _: stream(daemon))[0]
    return after(daemon, sent)


def json_bombs(daemon):
    """64 KB of JSON that is deep, long, doubled, no UTF-8 or half a character, in frames and calls:
    refused, or unknown and ignored by a call, and quickly."""
    def sized(begin, part, end=b""):
        return begin + part * ((65_000 - len(begin) - len(end)) // len(part)) + end
    proxy = b'{"proxy":{"seq":"1","mode":"PROXY_MODE_FREE","position":'
    bombs = [sized(b"", b"["), sized(b"", b'{"open":'), sized(proxy, b"["), sized(proxy, b"1"),
             sized(proxy + b"[0.", b"9", b"]}}"), sized(proxy + b"[1e", b"9", b"]}}"),
             sized(proxy + b"[", b"0,", b"0]}}"), sized(proxy + b"[", b"-", b"]}}"),
             sized(b'{"open":{"clientName":"', b"\\u0000", b'"}}'),
             sized(b'{"open":{"clientName":"', b"\\ud800", b'"}}'),
             sized(b'{"open":{"clientName":"', b"\xff", b'"}}'), sized(b"{", b'"open":{},', b"}"),
             sized(b'{"open":{', b'"device":"a",', b'"device":"b"}}'), sized(b"", b" "),
             sized(b'{"', b"x", b'":1}'), sized(b"", b'"'), sized(b"/*", b"*"), sized(b"", b"\0"),
             sized(b'{"open":{"freshEnd":"', b"9", b's"}}')]
    wrong, sent, slowest = [], 0, 0.0
    for bomb in bombs:
        for in_frame in (True, False):
            began = time.monotonic()
            try:
                if in_frame:
                    end = stream(daemon)
                    end.send(frame(TEXT, bomb))
                    closed = end.end_within(5.0)
                    end.socket.close()
                    # None: the door cut it, for the memory that it took.
                    ended = closed and closed.code in (None, 1007, 4003, 4005)
                else:
                    with Http(daemon.web) as http:
                        http.ask("GET", "/healthz")
                        answer = http.ask("POST", INFO, {**JSON, **bearer(daemon)}, bomb)
                        # Fields that it does not know are ignored.
                        ended = answer.status in (200, 400)
                        closed = answer
            except (OSError, Closed, Refused) as why:
                ended, closed = False, why
            if not ended:
                wrong.append(f"{bomb[:30]!r}: {str(closed)[:80]}")
            sent, slowest = sent + len(bomb), max(slowest, time.monotonic() - began)
    answer = after(daemon, sent, [f"{2 * len(bombs)} bombs, {1e3 * slowest:.0f} ms at most"])
    return {**answer, "wrong": wrong[:5] + answer["wrong"]}


def unread_states(daemon, count=24, seconds=4.0):
    """Sessions at 1 kHz in JSON that read nothing, and those that read everything."""
    ends = []
    for i in range(count):
        with contextlib.suppress(OSError, Closed, Refused):
            end = stream(daemon, timeout=0.5)
            end.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 2048)
            end.send(frame(TEXT, OPEN))
            ends.append(end)
    time.sleep(seconds)
    answer = after(daemon, 400 * count, [f"{len(ends)} sessions"], when="meanwhile")
    for end in ends:
        end.socket.close()
    return answer
