#!/usr/bin/env bash
# Builds everything and runs the tests: one command, from any folder, with no terminal.
#
#   tests/run.sh [--preset release|debug|asan|tsan] [-L|--label REGEX] [--ci] [--no-install] [-- CTEST-ARGS]
#
# Without --label: every test but those labelled network, slow, lint and container; with the sanitizers' presets
# those labelled unit and service. Labels: unit, service, system, interop, check, lint, network, slow, container.
# --ci: and then the container tests, with what was just built; where no container engine works they fail with
# the reason, unless HAPTIC_SKIP_CONTAINERS='why not here' is set.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

preset=release
label=
install=true
ci=false
while (($#)); do
  case "$1" in
    --preset) preset=${2:?--preset needs a name}; shift 2 ;;
    -L | --label) label=${2:?--label needs a regular expression}; shift 2 ;;
    --ci) ci=true; shift ;;
    --no-install) install=false; shift ;;
    --) shift; break ;;
    -h | --help) sed -n '2,${/^#/!q;s/^# \{0,1\}//p}' "$0"; exit 0 ;;
    *) echo "run.sh: unknown argument '$1' (see --help)" >&2; exit 2 ;;
  esac
done

if $install; then
  sh "$root/docker/install-deps.sh" build test
  if ! command -v npm >/dev/null || ! sh "$root/proto/buf.sh" install; then
    echo "run.sh: buf could not be installed (needs npm: docker/install-deps.sh node);" \
      "its check will be skipped" >&2
  fi
fi

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
# run_tests LOG CTEST-ARGS...
# Tests that keep real time lose when the host is taken away for long enough. One more run, alone, tells
# a lost processor from a fault; which tests needed it is said last. No other test gets a second run.
again=
run_tests() {
  local log=$1 lost=build/$preset/Testing/Temporary/LastTestsFailed.log status=0 numbers names others
  shift
  rm -f "$lost"
  ctest --preset "$preset" "$@" </dev/null 2>&1 | tee "$log" || status=$?
  if ((status == 0)) || [[ ! -s $lost ]]; then return $status; fi
  numbers=0,0,0,$(cut -d: -f1 "$lost" | paste -sd,)
  names=$(cut -d: -f2- "$lost" | paste -sd' ')
  others=$(ctest --preset "$preset" -N -I "$numbers" -LE '^(service|system|interop|container)$' | grep -c '^ *Test *#' || true)
  if ((others > 0)); then return $status; fi
  echo "run.sh: a second run, alone, of: $names"
  ctest --preset "$preset" --verbose -I "$numbers" </dev/null 2>&1 | tee -a "$log" || return $?
  again+="run.sh: passed only in a second run: $names"$'\n'
}

log=build/$preset/ctest.log
container_log=build/$preset/container.log
status=0
run_tests "$log" --parallel "$jobs" "${which[@]}" "$@" || status=$?
if $ci; then
  if $install && ! timeout 600 sh docker/install-deps.sh containers; then
    echo "run.sh: what runs containers could not be installed; trying what is here" >&2
  fi
  # With their output: it has the times, and the reason where they cannot run.
  run_tests "$container_log" --label-regex '^container$' --verbose || status=$?
fi

# The lines that count, last.
if $ci; then grep -oE 'container tests (passed|FAILED|SKIPPED).*' "$container_log" || true; fi
grep -E '^[0-9]+% tests passed' "$log" || true
printf '%s' "$again"
exit "$status"
