#!/usr/bin/env bash
# The serial link as a whole: builds, runs hapticd with the soft grasp over an emulated board on a
# pseudo-terminal, first streaming, then over the paper's 500 Hz link; prints rate, age of samples
# and what became of every frame, against the targets of hw/README.md#the-board-protocol
# (serial.py). Exits with 1 if a target is missed. Run it on a machine that does nothing else.
#
#   tests/bench/serial.sh [--minutes N] [--mode streaming|500hz] [--frames-only] [--paced]
#
# Default: 10 minutes of each mode. --paced: the board's samples begin the ticks (loop.paced_by),
# not the timer.
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
