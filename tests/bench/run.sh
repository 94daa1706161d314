#!/usr/bin/env bash
# Measures what README.md promises, in one run, by the rule of CONTRIBUTING.md#measuring:
# alternating blocks, median paired ratio with its bootstrap 95 % interval, an A/A row in the same
# line. Writes CSV to standard output. Run it on a machine that does nothing else.
#
#   tests/bench/run.sh [core|linear|loop|wire|web|crossing|memory]...
#     default: all, about 21 minutes
#
# MEMORY_SECONDS=600 makes `memory` watch for that long.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
for part in "$@"; do
  case "$part" in
    core | linear | loop | wire | web | crossing | memory) ;;
    -h | --help) sed -n '2,${/^#/!q;s/^# \{0,1\}//p}' "$0"; exit 0 ;;
    *)
      echo "run.sh: unknown part '$part' (core, linear, loop, wire, web, crossing, memory)" >&2
      exit 2
      ;;
  esac
done
cd "$root"
sh docker/install-deps.sh build test >&2
cmake --preset release >&2
cmake --build --preset release --parallel "$(nproc)" \
  --target haptic-bench-core haptic-bench-linear haptic-bench-loop haptic-bench-wire \
  haptic-bench-web haptic-bench-crossing hapticd >&2
bin=build/release

resident_kb() {
  awk '/VmRSS/ {print $2}' "/proc/$1/status"
}

# Resident memory of an idle hapticd, its launcher and its front, after 5 s and at the end, without
# and with locking.
memory() {
  local seconds=${MEMORY_SECONDS:-30} launcher
  echo "what,after_s,owner_kb,launcher_kb,front_kb"
  for mode in off try; do
    local folder
    folder=$(mktemp -d)
    "$bin/server/hapticd" --scene server/scenes/finger_soft_grasp.textproto --realtime="$mode" \
      --listen "unix:$folder/socket" --log-level error &
    local id=$!
    for after in 5 "$seconds"; do
      sleep "$([ "$after" = 5 ] && echo 5 || echo $((seconds - 5)))"
      launcher=$(pgrep -P "$id")
      echo "hapticd --realtime=$mode,$after,$(resident_kb "$id"),$(resident_kb "$launcher"),$(
        resident_kb "$(pgrep -P "$launcher")")"
    done
    kill -TERM "$id"
    wait "$id"
    rm -rf "$folder"
  done
}

for part in ${@:-core linear loop wire web crossing memory}; do
  echo "# $part"
  case "$part" in
    memory) memory ;;
    crossing) "$bin/tests/bench/haptic-bench-crossing" "$bin/server/hapticd-front" ;;
    *) "$bin/tests/bench/haptic-bench-$part" ;;
  esac
done
