"""No key, token or payload stands in a log. A whole client works, and makes mistakes, against a
hapticd that logs all it can; then its log is searched for every secret of the two, in every
spelling."""

import base64
import struct
import sys
import tempfile

import grpc

from server_process import Server, argument, eventually

sys.path.insert(0, argument("HAPTIC_PYTHON_PROTO"))
from haptic.v1 import haptic_service_pb2, session_pb2  # noqa: E402

from udp_client import Client  # noqa: E402

# Values that occur nowhere else. A position beyond 1000 rad is refused, and the refusal names it.
POSITION = [0.271828182845904, 0.141421356237309]
OUTSIDE = [POSITION[0], 1732.0508075688772]


def spellings(secret):
    """Of bytes, as programs print them."""
    text = secret.hex()
    yield from {
        "as it is": secret,
        "hex": text.encode(),
        "HEX": text.upper().encode(),
        "hex in pairs": secret.hex(" ").encode(),
        "hex by colons": secret.hex(":").encode(),
        "base64": base64.b64encode(secret).rstrip(b"="),
        "base64, for addresses": base64.urlsafe_b64encode(secret).rstrip(b"="),
        "C": "".join(f"\\x{byte:02x}" for byte in secret).encode(),
        "C, octal": "".join(f"\\{byte:03o}" for byte in secret).encode(),
        "protobuf's text": protobuf_text(secret),
    }.items()


def protobuf_text(secret):
    message = session_pb2.UdpPath(up_key=secret)
    return str(message).strip().removeprefix("up_key: ").strip('"').encode()


def found(log, secrets):
    return [f"{name}, {how}" for name, secret in secrets.items() for how, words in spellings(secret)
            if len(words) >= 4 and words in log]


def work(server):
    """A session in all its parts, mistakes included; returns the secrets that it learnt."""
    client = Client(server.channel, "127.0.0.1")
    try:
        eventually(lambda: client.opened and client.state, "the session opens, and a state comes")
        client.start_udp()
        client.publish_until(client.engage, "force is granted")
        client.publish_until(lambda: client.state.transport == session_pb2.TRANSPORT_UDP,
                             "samples go up by UDP", POSITION)
        accepted = client.sample
        client.publish(OUTSIDE)  # by UDP
        # A datagram with the right tag that is no message.
        client.path.send(1, b"\xff" + client.opened.udp.up_key)
        client.seq += 1
        client.send_by_stream(session_pb2.ProxySample(
            seq=client.seq, mode=session_pb2.PROXY_MODE_HELD, position=OUTSIDE))
        wrong = client.opened.session_id[::-1]
        try:
            client.stub.Release(haptic_service_pb2.ReleaseRequest(session_id=wrong))
            raise AssertionError("a session that nobody opened may release")
        except grpc.RpcError as error:
            assert error.code() == grpc.StatusCode.PERMISSION_DENIED, error
        udp = client.opened.udp
        return {"session id": client.opened.session_id.encode(), "wrong session id": wrong.encode(),
                "up key": udp.up_key, "up salt": udp.up_salt, "down key": udp.down_key,
                "down salt": udp.down_salt, "sample": accepted.SerializeToString(),
                "positions": struct.pack("<2d", *POSITION),
                "state": client.state.SerializeToString()}
    finally:
        client.close()


def control():
    """The search finds each spelling of a secret."""
    secret = bytes(range(250, 256)) + b"key of a kind"
    for how, words in spellings(secret):
        assert found(b"[info] x: " + words + b"\n", {"s": secret}), how
    assert not found(b"[info] nothing of the kind\n", {"s": secret})


def main():
    control()
    with tempfile.TemporaryFile() as log:
        with Server(argument("HAPTICD"), "--log-level", "debug", stderr=log) as server:
            secrets = work(server)
        log.seek(0)
        text = log.read()
    whole = b"session 'python'" in text and b" debug finger: " in text
    assert whole, f"this is not all it can log: {text!r}"
    leaked = found(text, secrets)
    leaked += [f"position {x}" for x in (*POSITION, OUTSIDE[1]) if repr(x)[:6].encode() in text]
    assert not leaked, f"the log holds: {', '.join(leaked)}"
    print(f"{len(secrets)} secrets, {len(text)} bytes of log: nothing of them in it")


main()
