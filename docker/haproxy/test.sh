#!/usr/bin/env bash
# Tests haproxy.cfg: hapticd with client certificates behind this host's haproxy, on loopback.
#
#   docker/haproxy/test.sh [BUILD]     BUILD: build/release by default
#
# Exit status 0: passed; 1: failed; 77: skipped, with the reason.
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
build=$(cd "${1:-$here/../../build/release}" && pwd)
PATH=$PATH:/usr/sbin
for program in haproxy openssl python3; do
  if ! command -v "$program" >/dev/null; then
    echo "test.sh: SKIPPED: no $program on this host" >&2
    exit 77
  fi
done
scratch=$(mktemp -d)
pids=()
finish() {
  local status=$?
  trap - EXIT
  for pid in "${pids[@]}"; do kill "$pid" 2>/dev/null || true; done
  wait
  if ((status)); then tail -n 20 "$scratch"/*.log >&2; fi
  rm -rf "$scratch"
  if ((status)); then echo "haproxy test FAILED" >&2; else echo "haproxy test passed"; fi
  exit "$status"
}
trap finish EXIT
fail() { echo "test.sh: $*" >&2; exit 1; }

read -r behind door < <(python3 -c '
import socket
ends = [socket.socket() for _ in range(2)]
for end in ends: end.bind(("127.0.0.1", 0))
print(*(end.getsockname()[1] for end in ends))')
cd "$scratch"
# shellcheck source=/dev/null
. "$here/laboratory.sh"
make_laboratory "127.0.0.1:$behind"
"$build/server/hapticd" --scene scene.textproto --realtime off >hapticd.log 2>&1 &
pids+=($!)
DOOR_LISTEN="127.0.0.1:$door" HAPTICD="127.0.0.1:$behind" \
  haproxy -db -f "$here/haproxy.cfg" >haproxy.log 2>&1 &
pids+=($!)

control() { # control CERTIFICATE PORT WORDS...
  local name=$1 port=$2
  shift 2
  timeout 10 "$build/client/hapticctl" --server "127.0.0.1:$port" --ca laboratory.pem \
    --server-name localhost --cert "$name.pem" --key "$name.key" "$@"
}
for _ in {1..100}; do
  if control surgeon "$door" health >/dev/null 2>&1; then break; fi
  sleep 0.1
done
control surgeon "$door" info >info.log || fail "no answer through haproxy"
grep -q finger info.log || fail "the answer names no device"
control thief "$door" info >thief.log 2>&1 && fail "a stranger's certificate got in"
# The certificate, not haproxy, speaks for the client.
timeout 3 "$build/client/hapticctl" --server "127.0.0.1:$door" --ca laboratory.pem \
  --server-name localhost --cert surgeon.pem --key surgeon.key engage >engage.log 2>&1 || true
grep -q "certificate of 'surgeon'" hapticd.log || fail "hapticd does not know the certificate"

python3 - "$door" <<'ATTACK' || fail "haproxy let the attack through"
import socket, sys, time
port = int(sys.argv[1])

def closed(end, seconds):
    end.settimeout(seconds)
    try:
        return end.recv(1) == b""
    except socket.timeout:
        return False
    except OSError:
        return True

time.sleep(1)
plain = socket.create_connection(("127.0.0.1", port))
plain.sendall(b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n" + b"\0" * 100)
assert closed(plain, 6), "plain text is served"
ends = [socket.create_connection(("127.0.0.1", port)) for _ in range(40)]
time.sleep(0.5)
kept = sum(not closed(end, 0.01) for end in ends)
assert kept <= 16, f"{kept} connections of one address"
assert all(closed(end, 6) for end in ends), "silent connections are kept"
ATTACK
control surgeon "$behind" estop --reason haproxy >/dev/null || fail "no stop on the host itself"
