"""proto/hapticd.lua in tshark, on a capture written here: datagrams sealed as the document says,
and every way in which one can be wrong."""

import shutil
import struct
import subprocess
import sys
import tempfile

import datagram
from datagram import CLOSE, PATH_CHALLENGE, PROXY, STATE

PATH_ID, SERVER_PORT, CLIENT_PORT = 0xC0FFEE01, 29471, 40000
UP = datagram.Sealer(PATH_ID, bytes(range(16)), b"abcd")
DOWN = datagram.Sealer(PATH_ID, bytes(range(16, 32)), b"efgh")
FIELDS = ["hapticd.type", "hapticd.path_id", "hapticd.packet_number", "hapticd.payload_length",
          "_ws.expert.message"]


def frame(payload, up=True):
    """Ethernet, IPv4, UDP on the loopback, without checksums."""
    ports = (CLIENT_PORT, SERVER_PORT) if up else (SERVER_PORT, CLIENT_PORT)
    udp = struct.pack(">HHHH", *ports, 8 + len(payload), 0) + payload
    ip = struct.pack(">BBHHHBBH4s4s", 0x45, 0, 20 + len(udp), 0, 0, 64, 17, 0,
                     bytes([127, 0, 0, 1]), bytes([127, 0, 0, 1]))
    return bytes(12) + b"\x08\x00" + ip + udp


def write_capture(file, frames):
    """The classic pcap format, link type Ethernet."""
    file.write(struct.pack("<IHHiIII", 0xA1B2C3D4, 2, 4, 0, 0, 65535, 1))
    for number, content in enumerate(frames):
        file.write(struct.pack("<IIII", number, 0, len(content), len(content)) + content)
    file.flush()


def changed(sealed, offset, value):
    return sealed[:offset] + bytes([value]) + sealed[offset + 1:]


def cases():
    """(frame, expected fields); payload lengths and numbers as sealed."""
    path = f"0x{PATH_ID:08x}"
    first = UP.seal(PROXY, b"x" * 22)
    yield frame(first), ["1", path, "1", "22", ""]
    yield frame(DOWN.seal(STATE, b"y" * 300), up=False), ["2", path, "1", "300", ""]
    yield frame(UP.seal(PATH_CHALLENGE, bytes(1168))), ["3", path, "2", "1168", ""]
    yield frame(first), ["1", path, "1", "22", "This packet number was seen before"]
    yield frame(UP.seal(PROXY, b"", 2**40)), ["1", path, str(2**40), "0", ""]
    yield (frame(UP.seal(PROXY, b"z", 2**40 - 1024)),
           ["1", path, str(2**40 - 1024), "1", "1024 or more below the newest"])
    yield frame(UP.seal(PROXY, b"z", 2**40 - 1023)), ["1", path, str(2**40 - 1023), "1", ""]
    yield frame(UP.seal(CLOSE, b"", 2**40 + 1)), ["5", path, str(2**40 + 1), "0", ""]
    yield (frame(changed(UP.seal(PROXY, b"v", 2**40 + 2), 2, 9)),
           ["1", path, str(2**40 + 2), "1", "Version is not 1"])
    yield (frame(changed(UP.seal(PROXY, b"t", 2**40 + 3), 3, 7)),
           ["7", path, str(2**40 + 3), "1", "Type is not 1..5"])
    yield (frame(UP.seal(PATH_CHALLENGE, bytes(39), 2**40 + 4)),
           ["3", path, str(2**40 + 4), "39", "not as long as its type demands"])
    yield (frame(UP.seal(PROXY, bytes(1169), 2**40 + 5)),
           ["1", path, str(2**40 + 5), "1169", "Length is not 32..1200"])
    # Not ours: another magic, and what is too short to be recognised.
    yield frame(changed(first, 0, 0x69)), ["", "", "", "", ""]
    yield frame(first[:31]), ["", "", "", "", ""]


def shown(dissector, capture):
    command = ["tshark", "-X", f"lua_script:{dissector}", "-r", capture, "-o",
               "udp.check_checksum:FALSE", "-T", "fields", "-E", "separator=|"]
    for field in FIELDS:
        command += ["-e", field]
    result = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    assert result.returncode == 0, result.stderr
    assert "Lua: Error" not in result.stderr, result.stderr
    return [line.split("|") for line in result.stdout.rstrip("\n").split("\n")]


def main(dissector):
    if shutil.which("tshark") is None:
        print("skipped: no tshark (package tshark)")
        sys.exit(77)
    expected = list(cases())
    with tempfile.NamedTemporaryFile(suffix=".pcap") as capture:
        write_capture(capture, [content for content, _ in expected])
        rows = shown(dissector, capture.name)
    assert len(rows) == len(expected), rows
    for row, (_, fields) in zip(rows, expected):
        assert row[:4] == fields[:4], (row, fields)
        if fields[4]:
            assert fields[4] in row[4], (row, fields)
        else:
            assert row[4] == "", (row, fields)
    print(f"{len(rows)} datagrams")


main(sys.argv[1])
