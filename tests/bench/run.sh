#!/usr/bin/env bash
# Measures what README.md promises, in one run, by the rule of CONTRIBUTING.md#measuring:
# alternating blocks, median paired ratio with its bootstrap 95 % interval, an A/A row in the same
# line. Writes CSV to standard output. Run it on a machine that does nothing else.
#
#   tests/bench/run.sh [core|linear|loop|wire|memory]...      default: all, about 8 minutes
#
# MEMORY_SECONDS=600 makes `memory` watch for that long.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
for part in "$@"; do
  case "$part" in
    core | linear | loop | wire | memory) ;;
    -h | --help) sed -n '2,${/^#/!q;s/^# \{0,1\}//p}' "$0"; exit 0 ;;
    *) echo "run.sh: unknown part '$part' (core, linear, loop, wire, memory)" >&2; exit 2 ;;
  esac
done
cd "$root"
sh docker/install-deps.sh build test >&2
cmake --preset release -DHAPTIC_BUILD_BENCHMARKS=ON >&2
cmake --build --preset release --parallel "$(nproc)" \
  --target haptic-bench-core haptic-bench-linear haptic-bench-loop haptic-bench-wire hapticd >&2
bin=build/release

# Resident memory of an idle hapticd, after 5 s and at the end, without and with locking.
memory() {
  local seconds=${MEMORY_SECONDS:-30}
  echo "what,after_s,resident_kb"
  for mode in off try; do
    local folder
    folder=$(mktemp -d)
    "$bin/server/hapticd" --scene server/scenes/finger_constant.textproto --realtime="$mode" \
      --listen "unix:$folder/socket" --log-level error &
    local id=$!
    for after in 5 "$seconds"; do
      sleep "$([ "$after" = 5 ] && echo 5 || echo $((seconds - 5)))"
      echo "hapticd --realtime=$mode,$after,$(awk '/VmRSS/ {print $2}' "/proc/$id/status")"
    done
    kill -TERM "$id"
    wait "$id"
    rm -rf "$folder"
  done
}

for part in ${@:-core linear loop wire memory}; do
  echo "# $part"
  if [ "$part" = memory ]; then memory; else "$bin/tests/bench/haptic-bench-$part"; fi
done
