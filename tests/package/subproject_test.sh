#!/bin/sh
# hapticd inside another project (add_subdirectory): its client is a target there; neither its tests
# nor its installation are part of that project. Configures only: the client is the same code.
#
#   subproject_test.sh FOLDER
set -eu
here=$(cd "$(dirname "$0")" && pwd)
. "$here/../support/scratch.sh"
fresh_folder "$1"
folder=$(cd "$1" && pwd)
fail() {
  echo "subproject_test.sh: $*" >&2
  exit 1
}
source=$(cd "$here/../.." && pwd)
cmake -S "$here/containing" -B "$folder/build" -G Ninja -DSOURCE="$source" \
  >"$folder/configure.log" 2>&1 ||
  { cat "$folder/configure.log"; fail "cannot be configured"; }
ctest --test-dir "$folder/build" -N | grep -q 'Total Tests: 0' || fail "its tests are there"
cmake --install "$folder/build" --prefix "$folder/prefix" >"$folder/install.log" 2>&1 ||
  { cat "$folder/install.log"; fail "cannot be installed"; }
[ -z "$(find "$folder/prefix" -type f 2>/dev/null)" ] || fail "it installs itself"
ninja -C "$folder/build" -t query foreign_client | grep -q libhaptic_client.a ||
  fail "the client is not linked"
