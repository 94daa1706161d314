#!/usr/bin/env bash
# Commands that documents show and that take minutes to hours: each shows its arguments, and refuses
# any other before it builds or measures. Their parts have tests.
#
#   long_commands_test.sh ROOT
set -euo pipefail
cd "${1:?the root of the tree}"
failures=0
fail() {
  echo "FAILED: $*"
  failures=$((failures + 1))
}
# Stand-ins for the tools: a script that builds or installs after all fails.
tools=$(mktemp -d)
trap 'rm -rf "$tools"' EXIT
for tool in cmake ninja ctest apt-get podman docker; do
  printf '#!/bin/sh\necho "%s was called" >&2\nexit 99\n' "$tool" >"$tools/$tool"
  chmod +x "$tools/$tool"
done
for script in tests/bench/run.sh tests/bench/network.sh tests/bench/soak.sh tests/bench/serial.sh \
  tests/churn/run.sh tests/fuzz/run.sh tests/relay/matrix.sh tests/report/run.sh tests/run.sh \
    docker/test.sh tests/hostile/run.sh \
  server/demo.sh; do
  status=0
  words=$(PATH="$tools:$PATH" "$script" --help 2>&1 </dev/null) || status=$?
  [[ $status == 0 ]] || fail "$script --help ends with $status: $words"
  [[ $words == *"$script"* ]] || fail "$script --help does not show how it is called: $words"
  status=0
  words=$(PATH="$tools:$PATH" "$script" --no-such-option 2>&1 </dev/null) || status=$?
  [[ $status == 2 ]] || fail "$script --no-such-option ends with $status: $words"
  [[ $words == *--no-such-option* ]] || fail "$script does not name what it refuses: $words"
done
exit "$((failures > 0))"
