#!/usr/bin/env bash
# Commands that documents show and that take minutes to hours: each says what it takes, and refuses
# anything else before it builds or measures. What they run has tests of its own.
#
#   long_commands_test.sh ROOT
set -euo pipefail
cd "${1:?the root of the tree}"
failures=0
fail() {
  echo "FAILED: $*"
  failures=$((failures + 1))
}
# Who builds or installs after all is found out: these do nothing but say so.
tools=$(mktemp -d)
trap 'rm -rf "$tools"' EXIT
for tool in cmake ninja ctest apt-get podman docker; do
  printf '#!/bin/sh\necho "%s was called" >&2\nexit 99\n' "$tool" >"$tools/$tool"
  chmod +x "$tools/$tool"
done
for script in tests/bench/run.sh tests/bench/network.sh tests/bench/soak.sh tests/bench/serial.sh \
  tests/churn/run.sh tests/fuzz/run.sh tests/relay/matrix.sh tests/report/run.sh tests/run.sh \
    docker/test.sh \
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
