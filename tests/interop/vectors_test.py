"""The test vectors of proto/README.md, sealed and opened by an AES-GCM that is not ours."""

import re
import sys

import datagram

KINDS = {"proxy": 1, "state": 2, "challenge": 3, "response": 4, "close": 5}


def table(lines, first_cells):
    """Rows of the Markdown table whose header begins with `first_cells`."""
    rows, inside = [], False
    for line in lines:
        cells = [cell.strip().strip("`") for cell in line.strip().strip("|").split("|")]
        if cells[:len(first_cells)] == first_cells:
            inside = True
        elif inside and not line.startswith("|"):
            return rows
        elif inside and not set(cells[0]) <= {"-", ":"}:
            rows.append(cells)
    raise AssertionError(f"no table {first_cells}")


def main(readme):
    with open(readme, encoding="utf-8") as file:
        lines = file.read().split("\n")
    path_id = int(re.search(r"Path id ([0-9a-f]{8})", "\n".join(lines)).group(1), 16)
    keys = {way: (bytes.fromhex(key), bytes.fromhex(salt))
            for way, key, salt in table(lines, ["direction", "key", "salt"])}
    vectors = table(lines, ["vector", "way", "packet number"])
    assert {vector[0] for vector in vectors} == set(KINDS), vectors
    for name, way, number, payload, sealed in vectors:
        payload = b"" if payload == "-" else bytes.fromhex(payload)
        sealed = bytes.fromhex(sealed)
        sealer = datagram.Sealer(path_id, *keys[way])
        assert sealer.seal(KINDS[name], payload, int(number)) == sealed, name
        opener = datagram.Opener(path_id, *keys[way], {KINDS[name]})
        assert opener.open(sealed) == (KINDS[name], payload), name
        assert opener.open(sealed) == "DUPLICATE", name
        damaged = sealed[:-1] + bytes([sealed[-1] ^ 1])
        assert datagram.Opener(path_id, *keys[way], {KINDS[name]}).open(damaged) == "TAG", name
    print(f"{len(vectors)} vectors")


main(sys.argv[1])
