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
for row in bit_flips wrong_key replayed_capture spoofed_source nan huge_values junk_100000_per_s \
  sigterm_under_load client_killed client_paused_300ms 16_observers; do
  need "$row"
done
# Real sockets: one proof of each kind, and what only sockets and processes can show.
for row in bit_flips nan sigterm_under_load client_killed client_stopped_300ms cut_connection \
  flood_100000_per_s; do
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
