#!/usr/bin/env bash
# docker/test.sh where no container engine can be made to work: it fails, and says of each engine
# why, or how to install one. It is skipped only if its user said so.
#
#   no_engine_test.sh DOCKER/TEST.SH
set -euo pipefail
test_sh=$1
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
fail() {
  echo "no_engine_test.sh: $*" >&2
  exit 1
}

# Engines that are there and do nothing, each for a reason of its own.
mkdir "$folder/bin"
for engine in docker podman; do
  printf '#!/bin/sh\necho "%s: the kernel said no" >&2\nexit 125\n' "$engine" >"$folder/bin/$engine"
  chmod +x "$folder/bin/$engine"
done
run() { # run STATUS ARGUMENTS...: it ends with STATUS; what it said is in `words`
  local status=0 wanted=$1
  shift
  words=$(PATH="$folder/bin:$PATH" bash "$test_sh" --logs "$folder/logs" "$@" 2>&1) || status=$?
  [[ $status == "$wanted" ]] || fail "status $status, not $wanted: $words"
}
says() { [[ $words == *"$1"* ]] || fail "no word of '$1': $words"; }

unset HAPTIC_SKIP_CONTAINERS
run 3
says 'no container engine works here'
says 'docker: docker: the kernel said no'
says 'podman: podman: the kernel said no'
says 'container tests FAILED'

run 3 --engine podman
says 'podman: the kernel said no'
[[ $words != *docker:* ]] || fail "an engine that the command did not name: $words"
[[ $words != *install-deps* ]] || fail "it is installed: $words"

# An engine that is not installed at all is a reason too.
run 3 --engine "no-such-engine-$$"
says "no-such-engine-$$: not installed"
says 'docker/install-deps.sh containers'

export HAPTIC_SKIP_CONTAINERS='no engine on this host'
run 77
says 'SKIPPED'
says 'no engine on this host'
[[ $words != *FAILED* ]] || fail "skipped and failed: $words"
