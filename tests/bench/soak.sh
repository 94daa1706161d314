#!/usr/bin/env bash
# The soak: builds, runs hapticd with a client over UDP next to a bare loop. Judges memory, missed
# deadlines against the bare loop's, and lateness against that at the start (soak.py). Run it on a
# machine that does nothing else.
#
#   tests/bench/soak.sh [--minutes N] [--csv FILE]      default: 30 minutes
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
given=("$@")
while (($#)); do
  case "$1" in
    -h | --help) sed -n '2,${/^#/!q;s/^# \{0,1\}//p}' "$0"; exit 0 ;;
    --minutes | --csv) shift 2 || { echo "soak.sh: $1 needs a value" >&2; exit 2; } ;;
    *) echo "soak.sh: unknown argument '$1' (see --help)" >&2; exit 2 ;;
  esac
done
build=$root/build/release
sh "$root/docker/install-deps.sh" build test >&2
(cd "$root" && cmake --preset release &&
  cmake --build --preset release --parallel "$(nproc)" \
    --target hapticd haptic-example-soft-grasp haptic-bare-loop) >&2
exec python3 "$root/tests/bench/soak.py" --programs "$build" \
  --scene "$root/server/scenes/finger_soft_grasp.textproto" "${given[@]}"
