#!/bin/sh
# The one command of the matrix, on virtual time: every scenario that is shipped has its row, every
# row of tests/relay/README.md#rows without a scenario too, all of them ok; and a failure would
# show. Over real sockets, which takes minutes, the rows are there to be run.
#
#   matrix_test.sh ROOT BUILD FOLDER
set -eu
root=$1
build=$2
folder=$3
mkdir -p "$folder"
out=$folder/matrix.csv
rm -f "$out"
bash "$root/tests/relay/matrix.sh" --build "$build" --out "$out"
[ "$(head -n 1 "$out")" = "row,expected,got,verdict" ]
status=0
need() {
  if ! grep -q "^virtual/$1,.*,ok\$" "$out"; then
    echo "no row virtual/$1 that is ok"
    status=1
  fi
}
for scenario in "$root"/tests/relay/scenarios/*.textproto; do
  need "$(basename "$scenario" .textproto)"
done
need junk_100000_per_s
# Real sockets: what only sockets and processes can show.
for row in cut_connection web_cut_connection web_client_killed web_client_stopped_300ms \
  sigterm_under_load flood_100000_per_s; do
  if ! grep -qE "\"(network/)?$row\"" "$root"/tests/relay/network_rows_test.cpp \
    "$root/tests/relay/flood_test.cpp"; then
    echo "no row network/$row"
    status=1
  fi
done
if bash "$root/tests/relay/matrix.sh" --build "$folder/nothing" --out "$out.2" 2>/dev/null; then
  echo "matrix.sh is content with a build that is not there"
  status=1
fi
exit $status
