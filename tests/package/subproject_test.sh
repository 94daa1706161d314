#!/bin/sh
# hapticd inside another project (add_subdirectory): its client is a target there; neither its tests
# nor its installation are part of that project, and what only the server, the programs and the
# page need is not asked for. Configures only: the client is the same code.
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
# Acts as a host that has none of these: a search for them fails, and a required one ends it.
absent=
for package in Eigen3 CLI11 spdlog Boost nlohmann_json; do
  absent="$absent -DCMAKE_DISABLE_FIND_PACKAGE_$package=ON"
done
# shellcheck disable=SC2086  # one word each
configure() {  # configure BUILD-FOLDER [ARGUMENTS...]
  build=$1
  shift
  cmake -S "$here/containing" -B "$build" -G Ninja \
    -DSOURCE="$source" $absent "$@" >"$folder/configure.log" 2>&1
}
configure "$folder/build" ||
  { cat "$folder/configure.log"; fail "cannot be configured"; }
! grep -qiE '^(serialport|systemd|seccomp|haptic_npm)_?' "$folder/build/CMakeCache.txt" ||
  fail "it asks for the server's libraries, or for npm"
! configure "$folder/whole" -DHAPTIC_CLIENT_ONLY=OFF || fail "the packages are not hidden"
ctest --test-dir "$folder/build" -N | grep -q 'Total Tests: 0' || fail "its tests are there"
cmake --install "$folder/build" --prefix "$folder/prefix" >"$folder/install.log" 2>&1 ||
  { cat "$folder/install.log"; fail "cannot be installed"; }
[ -z "$(find "$folder/prefix" -type f 2>/dev/null)" ] || fail "it installs itself"
ninja -C "$folder/build" -t query foreign_client | grep -q libhaptic_client.a ||
  fail "the client is not linked"
