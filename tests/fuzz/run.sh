#!/usr/bin/env bash
# Fuzzes with libFuzzer, address and undefined behaviour sanitizers, until a target has had so many
# executions.
#
#   tests/fuzz/run.sh [--fast] TARGET|all [EXECUTIONS]
#   tests/fuzz/run.sh keep
#
# Targets, and their executions by default: frame, datagram, crossing 1e8; scene, replay 1e6
# (tests/fuzz/targets.hpp says what each one is). The corpus grows in build/fuzz/corpus/TARGET, what
# was reached is in build/fuzz/TARGET.csv, and a run that was ended goes on from there. `keep` packs
# both into tests/fuzz/corpora, from where a build folder that has none begins. --fast does without
# the address sanitizer: 3 to 4 times as many executions per second, of the same corpus, counted in
# build/fuzz/TARGET-fast.csv; the library's own assertions are on. Each target ends with a line:
# executions, hours, corpus, coverage, and what the last tenth found that was new. A finding ends
# the run with 1 and leaves its input in the corpus as crash-*, which
# build/fuzz/tests/fuzz/haptic-libfuzzer-TARGET FILE replays; 3: the last tenth still found new
# edges.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
build=build/fuzz
suffix=
sanitizers=address,undefined
assertions=
if [[ ${1:-} == --fast ]]; then
  build=build/fuzz-fast
  suffix=-fast
  sanitizers=undefined
  assertions=-D_GLIBCXX_ASSERTIONS
  shift
fi
wanted=${1:-}
amount=${2:-}
known=(scene replay crossing frame datagram)
case "$wanted" in
  frame | datagram | crossing | scene | replay) targets=("$wanted") ;;
  all) targets=("${known[@]}") ;;
  keep)
    cd "$root"
    mkdir -p tests/fuzz/corpora
    for target in "${known[@]}"; do
      [[ -d build/fuzz/corpus/$target ]] || continue
      (cd build/fuzz && tar --sort=name --mtime=@0 --owner=0 --group=0 --numeric-owner \
        -cJf "$root/tests/fuzz/corpora/$target.tar.xz" "$target"*.csv "corpus/$target")
    done
    exit 0
    ;;
  -h | --help) sed -n '2,${/^#/!q;s/^# \{0,1\}//p}' "$0"; exit 0 ;;
  *)
    echo "run.sh: '$wanted': must be frame, datagram, crossing, scene, replay, all or keep" >&2
    exit 2
    ;;
esac
if [[ -n $amount && ! $amount =~ ^[1-9][0-9]*(e[0-9]+)?$ ]]; then
  echo "run.sh: executions '$amount': must be a whole number above 0, such as 1000000 or 1e6" >&2
  exit 2
fi
cd "$root"
command -v clang++ >/dev/null ||
  { echo "run.sh: no clang++ (docker/install-deps.sh test)" >&2; exit 2; }
# Tracing of every comparison costs half of the time; the targets build what comparisons would find.
# The check of virtual calls (vptr) has a cache of addresses: the edges of one corpus would differ
# from process to process. The asan preset has it.
cmake -S . -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=RelWithDebInfo -DCMAKE_C_COMPILER=clang \
  -DCMAKE_CXX_COMPILER=clang++ -DHAPTIC_FUZZERS=ON \
  "-DHAPTIC_SANITIZE=fuzzer-no-link,$sanitizers;-fno-sanitize=vptr" \
  -DCMAKE_C_FLAGS=-fno-sanitize-coverage=trace-cmp \
  "-DCMAKE_CXX_FLAGS=-fno-sanitize-coverage=trace-cmp $assertions" >&2
cmake --build "$build" --target "${targets[@]/#/haptic-libfuzzer-}" >&2
status=0
for target in "${targets[@]}"; do
  program=$build/tests/fuzz/haptic-libfuzzer-$target
  corpus=build/fuzz/corpus/$target
  kept=tests/fuzz/corpora/$target.tar.xz
  if [[ ! -d $corpus && -e $kept ]]; then tar -C build/fuzz -xJf "$kept"; fi
  mkdir -p "$corpus"
  HAPTIC_FUZZ_SEEDS=$corpus "$program" -runs=0 2>/dev/null
  default=1e8
  case $target in
    scene) default=1e6 longest=4096 ;;
    replay) default=1e6 longest=2048 ;;
    frame) longest=512 ;;
    datagram) longest=2048 ;;
    crossing) longest=1024 ;;
  esac
  dictionary=()
  if [[ $target == scene ]]; then  # the names of fields and of values, which mutation hardly finds
    dictionary=(build/fuzz/scene.dict)
    sed -nE 's/^ +([A-Za-z0-9_.]+ )*([A-Za-z0-9_]+) = [0-9]+[; ].*/"\2"/p' \
      proto/haptic/v1/scene.proto | sort -u >"${dictionary[0]}"
  fi
  python3 tests/fuzz/campaign.py "$program" "$corpus" "build/fuzz/$target$suffix.csv" \
    "${amount:-$default}" "$longest" "${dictionary[@]}" || status=$?
  if ((status == 1)); then exit 1; fi
done
exit "$status"
