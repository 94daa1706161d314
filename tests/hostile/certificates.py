"""TLS: keys that others may change, peers that are old or not who they say."""

import os
import pathlib
import shutil
import subprocess
import time

from daemon import CONTROL, FINGER, Daemon
from files import run


def certificate(folder, name, *more):
    subprocess.run(["openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt",
                    "ec_paramgen_curve:prime256v1", "-nodes", "-keyout", f"{folder}/{name}.key",
                    "-out", f"{folder}/{name}.pem", "-subj", f"/CN={name}", "-days", "2", "-addext",
                    "subjectAltName=DNS:localhost", *more], check=True, capture_output=True)


def tls_of(folder, name, more=""):
    return (f'tls {{ certificate: "{folder}/{name}.pem" key: "{folder}/{name}.key" {more} }}')


def key_mode(folder):
    """A TLS key that everyone may change is refused, or warned of."""
    if shutil.which("openssl") is None:
        return {"notes": ["not on this host: no openssl"]}
    certificate(folder, "server")
    wrong, notes = [], []
    for mode, allowed in ((0o600, True), (0o644, None), (0o646, False), (0o666, False)):
        os.chmod(f"{folder}/server.key", mode)
        scene = pathlib.Path(folder) / "tls.textproto"
        scene.write_text('name: "tls"\n' + FINGER + "server { " + tls_of(folder, "server") + " }")
        status, words, _ = run(["--scene", scene, "--check-scene"])
        if allowed and status != 0:
            wrong.append(f"mode {mode:o}: status {status}: {words[-80:]}")
        said = status != 0 or "mode" in words or "permission" in words
        if allowed is False and not said:
            wrong.append(f"mode {mode:o}: accepted without a word")
        notes.append(f"{mode:o}: {'said' if said else 'accepted'}")
    return {"wrong": wrong, "notes": notes}


def priority(daemon, folder, name):
    """What becomes of a controller that asks for the highest one with this certificate."""
    from calls import OPERATOR, controls, grpc, stubs
    pems = [pathlib.Path(f"{folder}/{file}").read_bytes()
            for file in ("server.pem", f"{name}.key", f"{name}.pem")]
    channel = grpc.secure_channel(daemon.address, grpc.ssl_channel_credentials(*pems), options=[
        ("grpc.ssl_target_name_override", "localhost"), ("grpc.use_local_subchannel_pool", 1)])
    try:
        return controls(stubs.HapticServiceStub(channel), priority=OPERATOR)
    finally:
        channel.close()


def tls_peers(folder):
    """TLS 1.0 and 1.1, NULL and CBC, no, forged, expired and server-only certificates."""
    if shutil.which("openssl") is None:
        return {"notes": ["not on this host: no openssl"]}
    for name in ("server", "ca", "stranger"):
        certificate(folder, name)
    issue = ["openssl", "req", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1",
             "-nodes"]
    for name, days, use in (("good", "2", "clientAuth"), ("expired", "-1", "clientAuth"),
                            ("server_only", "2", "serverAuth"), ("posing", "2", "clientAuth"),
                            ("surgeon", "2", "clientAuth")):
        common = "surgeon" if name == "posing" else name  # its alternative name is its own
        subprocess.run([*issue, "-keyout", f"{folder}/{name}.key", "-out", f"{folder}/{name}.csr",
                        "-subj", f"/CN={common}"], check=True, capture_output=True)
        pathlib.Path(f"{folder}/ext").write_text(
            f"subjectAltName=DNS:{name}\nextendedKeyUsage={use}\n")
        subprocess.run(["openssl", "x509", "-req", "-in", f"{folder}/{name}.csr", "-CA",
                        f"{folder}/ca.pem", "-CAkey", f"{folder}/ca.key", "-CAcreateserial",
                        "-days", days, "-extfile", f"{folder}/ext", "-out", f"{folder}/{name}.pem"],
                       check=True, capture_output=True)
    daemon = Daemon(f"{folder}/run", wait=False, record=False,
                    server=tls_of(folder, "server", f'client_ca: "{folder}/ca.pem" client {{ '
                                  'name: "surgeon" highest_priority: "operator" }'))
    wrong, notes = [], []
    try:
        def info(*words):
            done = subprocess.run([CONTROL, "--server", daemon.address, "--ca",
                                   f"{folder}/server.pem", "--server-name", "localhost", *words,
                                   "info"], capture_output=True, stdin=subprocess.DEVNULL,
                                  timeout=20.0)
            return done.returncode

        def of(name):
            return ["--cert", f"{folder}/{name}.pem", "--key", f"{folder}/{name}.key"]
        end = time.monotonic() + 10.0
        while info(*of("good")) != 0:
            if time.monotonic() > end:
                return {"wrong": ["a good certificate is refused: " + daemon.text()[-200:]]}
            time.sleep(0.1)
        for name in ("expired", "stranger"):
            if info(*of(name)) == 0:
                wrong.append(f"{name} certificate accepted")
        if info() == 0:
            wrong.append("no certificate, and served")
        if priority(daemon, folder, "surgeon") != "OK":
            wrong.append("the surgeon may not be an operator")
        if priority(daemon, folder, "posing") != "PERMISSION_DENIED":
            wrong.append("a common name counts next to alternative names")
        notes.append(f"server-only certificate: status {info(*of('server_only'))}")
        for words in (["-tls1"], ["-tls1_1"], ["-tls1_2", "-cipher", "NULL:@SECLEVEL=0"],
                      ["-tls1_2", "-cipher", "AES128-SHA:@SECLEVEL=0"],
                      ["-tls1_2", "-cipher", "ECDHE-ECDSA-AES128-SHA:@SECLEVEL=0"]):
            done = subprocess.run(["openssl", "s_client", "-connect", daemon.address, *words,
                                   "-cert", f"{folder}/good.pem", "-key", f"{folder}/good.key"],
                                  capture_output=True, stdin=subprocess.DEVNULL, timeout=10.0)
            if b"Cipher is (NONE)" not in done.stdout and b"New, TLS" in done.stdout:
                wrong.append(f"{' '.join(words)}: a handshake")
    finally:
        daemon.stop()
    return {"wrong": wrong, "notes": notes}
