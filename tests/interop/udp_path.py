"""The client's end of a UDP path, written from proto/README.md alone: receives, answers challenges,
probes, and decides whether the path is in use. One thread; the user sends from another."""

import os
import socket
import struct
import threading
import time

import datagram
from datagram import CLOSE, PATH_CHALLENGE, PATH_RESPONSE, PROXY, STATE

RESPONSE = struct.Struct(">8sqqQQ")


class UdpPath:
    ROUND, NEEDED, SPACING, PATIENCE = 5, 4, 0.020, 0.5

    def __init__(self, offer, stream_host, nominal_period, on_state, on_fallback, clock):
        """`clock`: ns, what the other end may hear of this one's time."""
        self.clock = clock
        up, down = (offer.up_key, offer.up_salt), (offer.down_key, offer.down_salt)
        self.sealer = datagram.Sealer(offer.path_id, *up)
        self.opener = datagram.Opener(offer.path_id, *down,
                                      {STATE, PATH_CHALLENGE, PATH_RESPONSE, CLOSE})
        self.on_state, self.on_fallback = on_state, on_fallback
        self.silence = max(0.1, 4 * nominal_period)
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.connect((offer.host or stream_host, offer.port))
        self.socket.settimeout(0.002)
        self.lock = threading.Lock()
        self.rejected, self.in_use, self.running = {}, False, True
        self.unanswered_since, self.round_trip = None, None
        self.begin_round(0.0)
        self.thread = threading.Thread(target=self.run)
        self.thread.start()

    def begin_round(self, pause):
        self.tokens, self.answered, self.next_challenge = {}, 0, time.monotonic() + pause
        self.round_ends = None

    def send(self, kind, payload):
        with self.lock:  # a packet number is used once
            sealed = self.sealer.seal(kind, payload)
        try:
            self.socket.send(sealed)
        except OSError:
            pass  # lost, as any datagram may be

    def send_sample(self, sample):
        """True where it went this way; else it is the stream's."""
        if not self.in_use:
            return False
        self.send(PROXY, sample.SerializeToString())
        return True

    def challenge(self, size):
        token = os.urandom(8)
        self.tokens[token] = time.monotonic()
        if self.unanswered_since is None:
            self.unanswered_since = time.monotonic()
        self.send(PATH_CHALLENGE, token.ljust(size, b"\0"))

    def step(self):
        now = time.monotonic()
        if self.in_use:
            if self.unanswered_since is not None and now - self.unanswered_since > self.silence:
                self.in_use = False
                self.begin_round(0.5)
                self.unanswered_since = None
                self.on_fallback()
            elif now >= self.next_challenge:
                self.next_challenge = now + self.silence / 10
                self.challenge(40)  # a datagram of 72 bytes
        elif self.round_ends is not None and now > self.round_ends:
            self.begin_round(0.5)
        elif len(self.tokens) < self.ROUND and now >= self.next_challenge:
            self.next_challenge = now + self.SPACING
            self.challenge(datagram.LARGEST_PAYLOAD)
            if len(self.tokens) == self.ROUND:
                self.round_ends = now + self.PATIENCE

    def respond(self, payload, came):
        token = payload[:8]
        response = RESPONSE.pack(token, came, self.clock(), self.opener.count,
                                 self.opener.newest)
        self.send(PATH_RESPONSE, response.ljust(len(payload), b"\0"))

    def take_response(self, payload):
        token = payload[:8]
        sent = self.tokens.pop(token, None)
        if sent is None:
            return
        self.round_trip = time.monotonic() - sent
        self.unanswered_since = None
        self.answered += 1
        if not self.in_use:
            self.tokens[token] = None  # the round has sent it all the same
        if not self.in_use and self.answered >= self.NEEDED:
            self.in_use, self.tokens, self.next_challenge = True, {}, time.monotonic()

    def run(self):
        while self.running:
            try:
                received = self.socket.recv(2048)
            except socket.timeout:
                received = None
            except OSError:
                received = None
            came = self.clock()
            if received is not None:
                self.take(received, came)
            self.step()

    def take(self, received, came):
        opened = self.opener.open(received)
        if isinstance(opened, str):
            self.rejected[opened] = self.rejected.get(opened, 0) + 1
            return
        kind, payload = opened
        if kind == STATE:
            self.on_state(payload)
        elif kind == PATH_CHALLENGE and len(payload) >= 40:
            self.respond(payload, came)
        elif kind == PATH_RESPONSE and len(payload) >= 40:
            self.take_response(payload)
        elif kind == CLOSE:
            self.in_use = False

    def close(self):
        self.running = False
        self.thread.join()
        self.send(CLOSE, b"")
        self.socket.close()
