#!/usr/bin/env bash
# Builds everything and runs the tests: one command, from any folder, with no terminal.
#
#   tests/run.sh [--preset release|debug|asan|tsan] [-L|--label REGEX] [--ci] [--no-install] [--
#     CTEST-ARGS]
#
# Without --label: every test except those labelled network, calm, hostile, kernel, model, mutation,
# lint and container; with the presets of the sanitizers those labelled unit and service. Labels:
# unit, service, system, interop, haproxy, browser, check, lint, network, calm, hostile, kernel,
# model, mutation, container. A failed test is not run again.
# --ci: then also the container tests, with the programs just built. If no container engine works
# they fail with the reason, unless HAPTIC_SKIP_CONTAINERS='why not here' is set.
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
  which=(--label-exclude '^(network|calm|hostile|kernel|model|mutation|lint|container)$')
fi
results=()
run_tests() { # run_tests NAME CTEST-ARGS...
  rm -f "build/$preset/$1.xml"
  results+=("$root/build/$preset/$1.xml")
  # Room for the reason of a test that is skipped, or that skips a part of itself.
  ctest --preset "$preset" --output-junit "${results[-1]}" --test-output-size-passed 16384 \
    "${@:2}" </dev/null 2>&1 | tee "build/$preset/$1.log"
}

status=0
run_tests ctest --parallel "$jobs" "${which[@]}" "$@" || status=$?
if $ci; then
  if $install && ! timeout 600 sh docker/install-deps.sh containers; then
    echo "run.sh: no container engine could be installed; trying what is here" >&2
  fi
  # With their output: it has the times, and the reason if they cannot run.
  run_tests container --label-regex '^container$' --verbose || status=$?
  grep -oE 'container tests (passed|FAILED|SKIPPED).*' "build/$preset/container.log" || true
fi
python3 tests/summary.py "${results[@]}" || status=1
exit "$status"
