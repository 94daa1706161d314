#!/usr/bin/env bash
# The serial link as a whole: builds, runs hapticd with the soft grasp over an emulated board on a
# pseudo-terminal, first streaming, then over the paper's 500 Hz link; prints rate, age of samples
# and where every frame went, against the targets of hw/README.md#the-board-protocol (serial.py).
# Ends with 1 where one is not held. Run it on a machine that does nothing else.
#
#   tests/bench/serial.sh [--minutes N] [--mode streaming|500hz] [--frames-only] [--paced]     
#   default: 10 minutes of each --paced: ticks begin with the board's samples (loop.paced_by) in
#   place of the timer
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
given=("$@")
while (($#)); do
  case "$1" in
    -h | --help) sed -n '2,${/^#/!q;s/^# \{0,1\}//p}' "$0"; exit 0 ;;
    --frames-only | --paced) shift ;;
    --minutes | --mode) shift 2 || { echo "serial.sh: $1 needs a value" >&2; exit 2; } ;;
    *) echo "serial.sh: unknown argument '$1' (see --help)" >&2; exit 2 ;;
  esac
done
build=$root/build/release
sh "$root/docker/install-deps.sh" build >&2
(cd "$root" && cmake --preset release &&
  cmake --build --preset release --parallel "$(nproc)" \
    --target hapticd haptic-example-soft-grasp haptic-board-emulator) >&2
exec python3 "$root/tests/bench/serial.py" --programs "$build" --root "$root" "${given[@]}"
