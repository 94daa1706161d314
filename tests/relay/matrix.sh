#!/usr/bin/env bash
# Runs the rows of tests/relay/README.md#rows and writes their table: `row,expected,got,verdict`.
#
#   tests/relay/matrix.sh [--network] [--calm] [--build FOLDER] [--out FILE]
#
# Without --network: every row on virtual time, seconds. With it also over real sockets through the
# relay: a quarter of an hour. --calm also judges times, so the machine must do nothing else.
# FOLDER: build/release by default, built before (tests/run.sh does). FILE: matrix.csv in FOLDER by
# default. Exit status 1 if a row failed.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
build=$root/build/release
out=
programs=(haptic_matrix_tests)
calm=false
while (($#)); do
  case "$1" in
    --network) programs+=(haptic_network_tests); shift ;;
    --calm) calm=true; shift ;;
    --build) build=${2:?--build needs a folder}; shift 2 ;;
    --out) out=${2:?--out needs a file}; shift 2 ;;
    -h | --help) sed -n '2,${/^#/!q;s/^# \{0,1\}//p}' "$0"; exit 0 ;;
    *) echo "matrix.sh: unknown argument '$1' (see --help)" >&2; exit 2 ;;
  esac
done
out=${out:-$build/matrix.csv}
if $calm; then export HAPTIC_CALM=1; else unset HAPTIC_CALM; fi
rows=$(mktemp)
trap 'rm -f "$rows"' EXIT
status=0
for program in "${programs[@]}"; do
  if [[ ! -x $build/tests/$program ]]; then
    echo "matrix.sh: no $build/tests/$program: build first (tests/run.sh)" >&2
    exit 2
  fi
  HAPTIC_MATRIX_CSV=$rows "$build/tests/$program" --gtest_brief=1 >&2 || status=1
done
# A client that turns its own clock, which no link can do.
if $calm; then
  HAPTIC_MATRIX_CSV=$rows HAPTICD=$build/server/hapticd \
    HAPTIC_RELAY=$build/tests/relay/haptic-relay \
    HAPTIC_PYTHON_PROTO=$build/tests/interop/proto PYTHONDONTWRITEBYTECODE=1 \
    sh "$root/tests/interop/run_python.sh" /usr/bin/python3 "grpc;google.protobuf;cryptography" \
    "$root/tests/interop/clock_rows_test.py" >&2 || status=1
fi
{ echo "row,expected,got,verdict"; sort "$rows"; } >"$out"
awk -F, 'NR > 1 { if ($NF == "ok") ++ok; else { ++failed; print "FAILED: " $1 } }
         END { printf "%d rows ok, %d failed\n", ok, failed }' "$out"
echo "$out"
exit $status
