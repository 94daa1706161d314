#!/usr/bin/env bash
# Fuzzes a target with libFuzzer, address and undefined behaviour sanitizers, for as long as one likes.
#
#   tests/fuzz/run.sh datagram|ingress|scene|all [SECONDS]      default: 60 s; all: each of them
#
# The corpus grows in build/fuzz/corpus/TARGET and is taken up by the next run; a finding ends the run and
# leaves its input there as crash-*, which the same program replays. A night: tests/fuzz/run.sh all 10000.
# The serial link's codecs have a program of their own, haptic-fuzz-frames.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
wanted=${1:-}
seconds=${2:-60}
case "$wanted" in
  datagram | ingress | scene) targets=("$wanted") ;;
  all) targets=(datagram ingress scene) ;;
  -h | --help) sed -n '2,9s/^# \{0,1\}//p' "$0"; exit 0 ;;
  *) echo "run.sh: target '$wanted': must be datagram, ingress, scene or all" >&2; exit 2 ;;
esac
case "$seconds" in
  '' | *[!0-9]* | 0) echo "run.sh: seconds '$seconds': must be a whole number above 0" >&2; exit 2 ;;
esac
command -v clang++ >/dev/null || { echo "run.sh: no clang++ (docker/install-deps.sh test)" >&2; exit 2; }
cd "$root"
cmake -S . -B build/fuzz -G Ninja -DCMAKE_BUILD_TYPE=RelWithDebInfo -DCMAKE_C_COMPILER=clang \
  -DCMAKE_CXX_COMPILER=clang++ -DHAPTIC_FUZZERS=ON -DHAPTIC_SANITIZE=fuzzer-no-link,address,undefined
cmake --build build/fuzz --target "${targets[@]/#/haptic-libfuzzer-}"
for target in "${targets[@]}"; do
  program=build/fuzz/tests/fuzz/haptic-libfuzzer-$target
  corpus=build/fuzz/corpus/$target
  mkdir -p "$corpus"
  HAPTIC_FUZZ_SEEDS=$corpus "$program" -runs=0 2>/dev/null
  echo "run.sh: $target, $seconds s" >&2
  "$program" "$corpus" -artifact_prefix="$corpus/" -max_total_time="$seconds" -max_len=16384 -timeout=20
done
