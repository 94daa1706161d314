#!/usr/bin/env bash
# Measures what the network's path costs, in one run, by the rule of CONTRIBUTING.md#measuring:
# alternating blocks, median paired ratio with its bootstrap 95 % interval, an A/A row in the same
# line. Writes CSV to standard output. Run it on a machine that does nothing else.
#
#   tests/bench/network.sh [datagram|udp|stream|age]...   default: all, about half an hour
#
#   datagram  one datagram at the server, split: receive, AEAD, parse, ingress
#   udp       from a sample to the mailbox, against raw UDP of the same size
#   stream    from publish() to the mailbox by gRPC, TCP and UNIX socket, against a bare gRPC stream
#   age       the proxy's age at use behind the relay, 10 ms and losses, by UDP and gRPC, against
#             a WebSocket and JSON service of the npm package ws (fetched into the build folder)
#
# BLOCKS=2 shortens it, to see that it works; figures to be quoted need the default, 20.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
cd "$root"
case "${1:-}" in -h | --help) sed -n '2,${/^#/!q;s/^# \{0,1\}//p}' "$0"; exit 0 ;; esac
build=${BUILD_DIR:-build/release}
parts=("$@")
[ ${#parts[@]} -gt 0 ] || parts=(datagram udp stream age)
for part in "${parts[@]}"; do
  case "$part" in
    datagram | udp | stream | age) ;;
    *) echo "network.sh: unknown part '$part' (datagram, udp, stream, age)" >&2; exit 2 ;;
  esac
done
if [ -z "${BUILD_DIR:-}" ]; then
  sh docker/install-deps.sh build test >&2
  cmake --preset release -DHAPTIC_BUILD_BENCHMARKS=ON >&2
  cmake --build --preset release --parallel "$(nproc)" --target haptic-bench-network >&2
fi

peer=()
case " ${parts[*]} " in
  *" age "*)
    command -v npm > /dev/null || sh docker/install-deps.sh node >&2
    folder=$build/bench-peer
    mkdir -p "$folder"
    cp tests/bench/peer/package.json tests/bench/peer/*.js "$folder/"
    [ -d "$folder/node_modules/ws" ] || npm install --prefix "$folder" --no-audit --no-fund >&2
    coproc SERVICE { exec node "$folder/service.js"; }
    service=$SERVICE_PID
    trap 'kill "$service" 2> /dev/null || true' EXIT
    read -r -t 20 port <&"${SERVICE[0]}" || {
      echo "network.sh: the peer's service did not start" >&2
      exit 2
    }
    peer=(--peer-client "node $folder/publisher.js" --peer-port "$port")
    ;;
esac
"$build/tests/bench/haptic-bench-network" "${parts[@]}" ${peer[@]+"${peer[@]}"} \
  --blocks "${BLOCKS:-20}"
