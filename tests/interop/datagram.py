"""A datagram of proto/README.md, "The UDP path", on `cryptography`."""

import struct

from cryptography.exceptions import InvalidTag
from cryptography.hazmat.primitives.ciphers.aead import AESGCM

PROXY, STATE, PATH_CHALLENGE, PATH_RESPONSE, CLOSE = 1, 2, 3, 4, 5
LARGEST_PAYLOAD = 1200 - 16 - 16
HEADER = struct.Struct(">2sBBIQ")  # magic, version, type, path id, packet number
MAGIC, VERSION = b"\x68\x70", 1


def nonce(salt, packet_number):
    return salt + struct.pack(">Q", packet_number)


class Sealer:
    """One direction's keys, for the sender: packet numbers rise from 1."""

    def __init__(self, path_id, key, salt):
        self.path_id, self.aead, self.salt, self.sent = path_id, AESGCM(key), salt, 0

    def seal(self, kind, payload, packet_number=None):
        self.sent = packet_number or self.sent + 1
        header = HEADER.pack(MAGIC, VERSION, kind, self.path_id, self.sent)
        return header + self.aead.encrypt(nonce(self.salt, self.sent), payload, header)


class Opener:
    """One direction's keys, for the receiver; checks in the order of the document."""

    WINDOW = 1024

    def __init__(self, path_id, key, salt, kinds):
        self.path_id, self.aead, self.salt, self.kinds = path_id, AESGCM(key), salt, kinds
        self.newest, self.seen, self.count = 0, set(), 0

    def open(self, datagram):
        """(type, payload), or the reason of the rejection."""
        if not 32 <= len(datagram) <= 1200:
            return "LENGTH"
        header = datagram[:16]
        magic, version, kind, path_id, number = HEADER.unpack(header)
        for wrong, reason in ((magic != MAGIC, "MAGIC"), (version != VERSION, "VERSION"),
                              (kind not in self.kinds, "TYPE"),
                              (path_id != self.path_id, "UNKNOWN_PATH"),
                              (number in self.seen, "DUPLICATE"),
                              (number + self.WINDOW <= self.newest, "TOO_OLD")):
            if wrong:
                return reason
        if number > 2**32:
            return "TAG"
        try:
            payload = self.aead.decrypt(nonce(self.salt, number), datagram[16:], header)
        except InvalidTag:
            return "TAG"
        self.newest = max(self.newest, number)
        self.count += 1
        self.seen.add(number)
        self.seen = {n for n in self.seen if n + self.WINDOW > self.newest}
        return kind, payload
