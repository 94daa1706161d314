#!/usr/bin/env bash
# Builds everything and runs the tests: one command, from any folder, with no terminal.
#
#   tests/run.sh [--preset release|debug|asan|tsan] [-L|--label REGEX] [--no-install] [-- CTEST-ARGS]
#
# Without --label: every test but those labelled network, slow and lint; with the sanitizers' presets
# those labelled unit and service. Labels: unit, service, system, interop, check,
# lint, network, slow, container.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

preset=release
label=
install=true
while (($#)); do
  case "$1" in
    --preset) preset=${2:?--preset needs a name}; shift 2 ;;
    -L | --label) label=${2:?--label needs a regular expression}; shift 2 ;;
    --no-install) install=false; shift ;;
    --) shift; break ;;
    -h | --help) sed -n '2,8s/^# \{0,1\}//p' "$0"; exit 0 ;;
    *) echo "run.sh: unknown argument '$1' (see --help)" >&2; exit 2 ;;
  esac
done

if $install; then sh "$root/docker/install-deps.sh" build test; fi

jobs=$(nproc)
cd "$root"
cmake --preset "$preset"
cmake --build --preset "$preset" --parallel "$jobs"

if [[ -n $label ]]; then
  which=(--label-regex "$label")
elif [[ $preset == asan || $preset == tsan ]]; then
  which=(--label-regex '^(unit|service)$')
else
  which=(--label-exclude '^(network|slow|lint|container)$')
fi
log=build/$preset/ctest.log
status=0
ctest --preset "$preset" --parallel "$jobs" "${which[@]}" "$@" </dev/null 2>&1 | tee "$log" || status=$?

# Tests that keep real time lose when the host is taken away for long enough. One more run, alone, tells
# a lost processor from a fault; which tests needed it is said last. No other test gets a second run.
real_time='^(service|system|interop)$'
again=
lost=build/$preset/Testing/Temporary/LastTestsFailed.log
if ((status)) && [[ -s $lost ]]; then
  numbers=0,0,0,$(cut -d: -f1 "$lost" | paste -sd,)
  names=$(cut -d: -f2- "$lost" | paste -sd' ')
  others=$(ctest --preset "$preset" -N -I "$numbers" --label-exclude "$real_time" | grep -c '^ *Test *#' || true)
  if ((others == 0)); then
    echo "run.sh: a second run, alone, of: $names"
    status=0
    ctest --preset "$preset" -I "$numbers" </dev/null 2>&1 | tee -a "$log" || status=$?
    ((status)) || again="run.sh: passed only in a second run: $names"
  fi
fi
# The lines that count, last.
grep -E '^[0-9]+% tests passed' "$log" || true
[[ -z $again ]] || echo "$again"
exit "$status"
