#!/usr/bin/env bash
# Fuzzes a target with libFuzzer, address and undefined behaviour sanitizers, for as long as one
# likes.
#
#   tests/fuzz/run.sh datagram|ingress|scene|all [SECONDS]      default: 60 s; all: each of them
#   tests/fuzz/run.sh frames [EXECUTIONS]                       default: 10 million
#
# The corpus grows in build/fuzz/corpus/TARGET and is taken up by the next run; a finding ends the
# run and leaves its input there as crash-*, which the same program replays. A night:
# tests/fuzz/run.sh all 10000. frames: the serial link's codecs, C++ and C99, against each other on
# damaged streams (haptic-fuzz-frames, same streams in every run; address and undefined behaviour
# sanitizers too). Ends with 1 at a finding.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
wanted=${1:-}
amount=${2:-60} unit=seconds
if [[ $wanted == frames ]]; then amount=${2:-10000000} unit=executions; fi
case "$wanted" in
  frames) targets=() ;;
  datagram | ingress | scene) targets=("$wanted") ;;
  all) targets=(datagram ingress scene) ;;
  -h | --help) sed -n '2,${/^#/!q;s/^# \{0,1\}//p}' "$0"; exit 0 ;;
  *) echo "run.sh: target '$wanted': must be datagram, ingress, scene, frames or all" >&2; exit 2 ;;
esac
case "$amount" in
  '' | *[!0-9]* | 0) echo "run.sh: $unit '$amount': must be a whole number above 0" >&2; exit 2 ;;
esac
if [[ $wanted == frames ]]; then
  cd "$root"
  cmake --preset asan >&2
  cmake --build --preset asan --target haptic-fuzz-frames >&2
  exec build/asan/tests/haptic-fuzz-frames "$amount"
fi
command -v clang++ >/dev/null ||
  { echo "run.sh: no clang++ (docker/install-deps.sh test)" >&2; exit 2; }
cd "$root"
cmake -S . -B build/fuzz -G Ninja -DCMAKE_BUILD_TYPE=RelWithDebInfo -DCMAKE_C_COMPILER=clang \
  -DCMAKE_CXX_COMPILER=clang++ -DHAPTIC_FUZZERS=ON \
    -DHAPTIC_SANITIZE=fuzzer-no-link,address,undefined
cmake --build build/fuzz --target "${targets[@]/#/haptic-libfuzzer-}"
for target in "${targets[@]}"; do
  program=build/fuzz/tests/fuzz/haptic-libfuzzer-$target
  corpus=build/fuzz/corpus/$target
  mkdir -p "$corpus"
  HAPTIC_FUZZ_SEEDS=$corpus "$program" -runs=0 2>/dev/null
  echo "run.sh: $target, $amount s" >&2
  "$program" "$corpus" -artifact_prefix="$corpus/" -max_total_time="$amount" -max_len=16384 \
    -timeout=20
done
