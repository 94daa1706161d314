#!/usr/bin/env bash
# Measures the age of the proxy when a tick uses it, behind a relay with 10 ms each way and losses
# of 0, 1, 5 and 10 %, by UDP and by WebSocket, each against gRPC, by the rule of
# CONTRIBUTING.md#measuring. Writes CSV to standard output. Run it on a machine that does nothing
# else.
#
#   tests/bench/network.sh      about 30 minutes
#
# BLOCKS=2 shortens it, to see that it works; figures to be quoted need the default, 20.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
case "${1:-}" in
  "") ;;
  -h | --help) sed -n '2,${/^#/!q;s/^# \{0,1\}//p}' "$0"; exit 0 ;;
  *) echo "network.sh: unknown argument '$1'" >&2; exit 2 ;;
esac
cd "$root"
sh docker/install-deps.sh build test >&2
cmake --preset release -DHAPTIC_BUILD_BENCHMARKS=ON >&2
cmake --build --preset release --parallel "$(nproc)" --target haptic-bench-network >&2
build/release/tests/bench/haptic-bench-network --blocks "${BLOCKS:-20}"
