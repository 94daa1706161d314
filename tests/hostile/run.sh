#!/usr/bin/env bash
# Attacks a running hapticd with a controller in contact, row by row, and writes what it did as CSV
# and as a table (README.md).
#
#   tests/hostile/run.sh [--row NAME]... [--hogs] [--repeat N] [--list] [--build FOLDER]
#     [--out FILE]
#
# NAME: a row, or how rows begin and then '*'. --hogs: next to two processes that compute. FOLDER:
# build/release by default, built before (tests/run.sh does). FILE: hostile.csv in FOLDER by
# default. Exit status 1 if a row failed.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
build=$root/build/release
out=
arguments=()
while (($#)); do
  case "$1" in
    --build) build=$(cd "${2:?--build needs a folder}" && pwd); shift 2 ;;
    --out) out=${2:?--out needs a file}; shift 2 ;;
    -h | --help) sed -n '2,${/^#/!q;s/^# \{0,1\}//p}' "$0"; exit 0 ;;
    --row | --repeat) arguments+=("$1" "${2:?"$1 needs a value"}"); shift 2 ;;
    --hogs | --list) arguments+=("$1"); shift ;;
    *) echo "run.sh: unknown argument '$1' (see --help)" >&2; exit 2 ;;
  esac
done
for program in server/hapticd client/hapticctl hw/haptic-board-emulator; do
  if [[ ! -x $build/$program ]]; then
    echo "run.sh: no $build/$program: build first (tests/run.sh)" >&2
    exit 2
  fi
done
export HAPTICD=$build/server/hapticd HAPTICCTL=$build/client/hapticctl
export HAPTIC_EMULATOR=$build/hw/haptic-board-emulator HAPTIC_RELAY=$build/tests/relay/haptic-relay
export HAPTIC_FRONT_ATTACKER=$build/tests/haptic-front-attacker
export PYTHONPATH=$build/tests/interop/proto PYTHONDONTWRITEBYTECODE=1  # the messages
export HAPTIC_PYTHON=$build/client/python  # the package haptic, for the client that is attacked
exec sh "$root/tests/interop/run_python.sh" /usr/bin/python3 "grpc;google.protobuf;cryptography" \
  "$root/tests/hostile/suite.py" --out "${out:-$build/hostile.csv}" "${arguments[@]}"
