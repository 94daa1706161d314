#!/usr/bin/env bash
# Tests the containers: the image, the composition, network trouble, .deb packages in a clean
# container. Works with docker and podman, also without a registry and without systemd.
#
#   docker/test.sh [--prebuilt BUILD] [--engine docker|podman] [--logs FOLDER] [--keep-images]
#
# --prebuilt BUILD  takes programs and packages from a build folder of this tree, which it updates,
#                   if the image has this host's distribution; else they are compiled in the image
# --logs FOLDER     for the output of every container; default: build/container-logs
# --keep-images     leaves the images that it built for the next run
# Removes every container, network and volume of its own, and every image but the base that it made.
# Exit status 0: every test passed; 1: one failed; 3: no engine works, with the reason. If you know
# that and accept it, HAPTIC_SKIP_CONTAINERS='the reason' skips the tests with it and status 77.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

prebuilt=
wanted=
logs=$root/build/container-logs
keep_images=false
while (($#)); do
  case "$1" in
    --prebuilt) prebuilt=$(cd "${2:?--prebuilt needs a folder}" && pwd); shift 2 ;;
    --engine) wanted=${2:?--engine needs docker or podman}; shift 2 ;;
    --logs) logs=${2:?--logs needs a folder}; shift 2 ;;
    --keep-images) keep_images=true; shift ;;
    -h | --help) sed -n '2,${/^#/!q;s/^# \{0,1\}//p}' "$0"; exit 0 ;;
    *) echo "test.sh: unknown argument '$1' (see --help)" >&2; exit 2 ;;
  esac
done
if [[ -n ${HAPTIC_SKIP_CONTAINERS:-} ]]; then
  echo "container tests SKIPPED, HAPTIC_SKIP_CONTAINERS says: $HAPTIC_SKIP_CONTAINERS" >&2
  exit 77
fi
mkdir -p "$logs"
scratch=$(mktemp -d)
project=haptictest$$
image=localhost/hapticd-test:$$
engine=
base=
for part in engine image staleness shutdown relay package haproxy hosts; do
  # shellcheck source=/dev/null
  . "$root/tests/container/$part.sh"
done

collect() { # the output of the containers that still run; that of the others is collected already
  local service id
  for service in hand board simulation observer relay; do
    id=$(container "$service") || continue
    if [[ -n $id ]]; then "$engine" logs "$id" >>"$logs/$service.log" 2>&1 || true; fi
  done
}
# shellcheck disable=SC2317  # called by the trap
finish() {
  local status=$?
  trap - EXIT
  exec >&3 2>&4
  if [[ -n $engine ]]; then
    collect
    tear_down 2>>"$logs/engine.log" || status=1
    if ! $keep_images; then
      "$engine" rmi --force "$image" "$image-packages" "${project}_door" \
        "${project}_prometheus" >/dev/null 2>&1 || true
      remove_layers
    fi
    local rest
    rest=$(left_behind)
    if [[ -n $rest ]]; then
      echo "test.sh: left behind: $rest" >&2
      status=1
    fi
  fi
  if [[ -n $engine ]]; then rm -rf "$root/build/container"; fi
  rm -rf "$scratch"
  case $status in
    0) echo "container tests passed in $SECONDS s" ;;
    3) echo "container tests FAILED: no container engine works here, for the reasons above" >&2 ;;
    *) echo "container tests FAILED; see $logs" >&2 ;;
  esac
  exit "$status"
}
# This script's own output, also when a signal comes while a condition's output is redirected.
exec 3>&1 4>&2
trap finish EXIT
trap 'exit 130' INT TERM

fail() {
  echo "test.sh: $*" >&2
  exit 1
}
step() { printf '%4d s  %s\n' "$SECONDS" "$*"; }
eventually() { # eventually SECONDS COMMAND...: until it succeeds
  local latest=$((SECONDS + $1))
  shift
  until "$@" >"$scratch/last" 2>&1; do
    ((SECONDS < latest)) || { cat "$scratch/last" >&2; return 1; }
    sleep 0.3
  done
}

rm -f "$logs"/*.log
choose_engine "$wanted" || exit 3
step "engine: $engine $("$engine" --version | grep -oE '[0-9]+\.[0-9.]+' | head -n 1)"

build_image
start_composition
test_stream
test_staleness
test_relay
test_shutdown
test_packages
test_haproxy
test_hosts
