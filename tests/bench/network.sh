#!/usr/bin/env bash
# Measures what the network's path costs, in one run, by the rule of CONTRIBUTING.md#measuring:
# alternating blocks, median paired ratio with its bootstrap 95 % interval, an A/A row in the same
# line. Writes CSV to standard output. Run it on a machine that does nothing else.
#
#   tests/bench/network.sh [udp|age]...   default: all, about 20 minutes
#
#   udp  from a sample to the mailbox, against raw UDP of the same size
#   age  the proxy's age at use behind the relay, 10 ms and losses, by UDP against gRPC
#
# BLOCKS=2 shortens it, to see that it works; figures to be quoted need the default, 20.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
cd "$root"
case "${1:-}" in -h | --help) sed -n '2,${/^#/!q;s/^# \{0,1\}//p}' "$0"; exit 0 ;; esac
build=${BUILD_DIR:-build/release}
parts=("$@")
[ ${#parts[@]} -gt 0 ] || parts=(udp age)
for part in "${parts[@]}"; do
  case "$part" in
    udp | age) ;;
    *) echo "network.sh: unknown part '$part' (udp, age)" >&2; exit 2 ;;
  esac
done
if [ -z "${BUILD_DIR:-}" ]; then
  sh docker/install-deps.sh build test >&2
  cmake --preset release -DHAPTIC_BUILD_BENCHMARKS=ON >&2
  cmake --build --preset release --parallel "$(nproc)" --target haptic-bench-network >&2
fi

"$build/tests/bench/haptic-bench-network" "${parts[@]}" --blocks "${BLOCKS:-20}"
