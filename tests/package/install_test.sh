#!/bin/sh
# Installs the build into an empty folder and builds a foreign project against it, by CMake and by
# pkg-config; runs its client against the installed hapticd.
#
#   install_test.sh BUILD FOLDER
set -eu
build=$1
folder=$2
here=$(cd "$(dirname "$0")" && pwd)
. "$here/../support/scratch.sh"
fresh_folder "$folder"
folder=$(cd "$folder" && pwd)
prefix=$folder/prefix
server=
finish() {
  if [ -n "$server" ]; then
    kill "$server" 2>/dev/null || true
    wait "$server" || true
  fi
}
trap finish EXIT
fail() {
  echo "install_test.sh: $*" >&2
  exit 1
}

for component in server client python dev c c_dev mujoco; do  # mujoco: nothing, if it was not here
  cmake --install "$build" --prefix "$prefix" --component $component >"$folder/$component.log"
done

# Nothing that was installed may point back at the sources or the build.
source=$(cd "$here/../.." && pwd)
if grep -rI -e "$source" "$prefix" --include='*.cmake' --include='*.pc' --include='*.service' |
  sed "s|$prefix||g" | grep -F "$source"; then
  fail "these name the source tree"
fi

# The installed tree alone: it is moved before it is used.
mv "$prefix" "$folder/moved"
prefix=$folder/moved
unset CMAKE_PREFIX_PATH PKG_CONFIG_PATH
cmake -S "$here/foreign" -B "$folder/foreign" -DCMAKE_PREFIX_PATH="$prefix" \
  -DCMAKE_BUILD_TYPE=Release \
  >"$folder/configure.log" 2>&1 ||
    { cat "$folder/configure.log"; fail "find_package(haptic) failed"; }
if cmake -S "$here/foreign" -B "$folder/glove" -DCMAKE_PREFIX_PATH="$prefix" -DALSO=glove \
  >"$folder/glove.log" 2>&1; then
  fail "find_package(haptic COMPONENTS glove) did not fail"
fi
grep -q "no component 'glove'" "$folder/glove.log" || { cat "$folder/glove.log"; fail "not named"; }
if [ -e "$prefix/include/haptic/mujoco/tool.hpp" ]; then
  cmake -DALSO=mujoco "$folder/foreign" >"$folder/mujoco.log" ||
    { cat "$folder/mujoco.log"; fail "find_package(haptic COMPONENTS mujoco) failed"; }
fi
cmake --build "$folder/foreign" >"$folder/build.log" ||
  { cat "$folder/build.log"; fail "no build"; }

pc=$(dirname "$(find "$prefix" -name haptic-client.pc)")
export PKG_CONFIG_PATH=$pc
# shellcheck disable=SC2046  # words are what is wanted
"${CXX:-c++}" -std=c++20 "$here/foreign/client.cpp" $(pkg-config --cflags --libs haptic-client) \
  -o "$folder/by_pkg_config"
if [ -e "$prefix/include/haptic/mujoco/tool.hpp" ]; then
  # shellcheck disable=SC2046
  "${CXX:-c++}" -std=c++20 "$here/foreign/mujoco.cpp" $(pkg-config --cflags --libs haptic-mujoco) \
    -o "$folder/mujoco_by_pkg_config" || fail "no build with pkg-config haptic-mujoco"
fi

# A C compiler alone, and nothing that haptic::client asks for.
cmake -S "$here/foreign/c" -B "$folder/foreign_c" -DCMAKE_PREFIX_PATH="$prefix" \
  >"$folder/configure_c.log" 2>&1 ||
    { cat "$folder/configure_c.log"; fail "find_package(haptic-c) failed"; }
cmake --build "$folder/foreign_c" >"$folder/build_c.log" ||
  { cat "$folder/build_c.log"; fail "no build in C"; }
# shellcheck disable=SC2046  # words are what is wanted
"${CC:-cc}" -std=c99 -pedantic -Werror "$source/client/c/examples/virtual_wall.c" \
  $(pkg-config --cflags --libs haptic-c) -o "$folder/c_by_pkg_config"

# The vector of proto/README.md.
"$folder/foreign/foreign_proto" >"$folder/sample"
grep -q "\`$(cat "$folder/sample")\`" "$source/proto/README.md" ||
  fail "not the vector: $(cat "$folder/sample")"

socket=$folder/socket
"$prefix/bin/hapticd" --scene "$prefix/etc/hapticd/scene.textproto" --realtime=off \
  --set loop.late_bucket_full=1000000 --set 'loop.loop_late_fault={seconds: 10}' \
  --listen "unix:$socket" 2>"$folder/hapticd.log" &
server=$!
for _ in $(seq 100); do
  [ -S "$socket" ] && break
  kill -0 "$server" || fail "$(cat "$folder/hapticd.log")"
  sleep 0.1
done
timeout 30 "$folder/foreign/foreign_client" "unix:$socket" || fail "the client found by CMake"
timeout 30 "$folder/by_pkg_config" "unix:$socket" || fail "the client found by pkg-config"
for program in "$folder/foreign_c/foreign_c" "$folder/c_by_pkg_config"; do
  LD_LIBRARY_PATH=${pc%/pkgconfig} timeout 30 "$program" "unix:$socket" 1 || fail "$program"
done
timeout 30 "$prefix/bin/hapticctl" --server "unix:$socket" info >/dev/null || fail "hapticctl"
# Python finds the library of its own prefix.
if /usr/bin/python3 -c "import _cffi_backend" 2>/dev/null; then
  PYTHONDONTWRITEBYTECODE=1 PYTHONPATH=$prefix/lib/python3/dist-packages timeout 30 \
    /usr/bin/python3 -c "import haptic, sys; print(haptic.Connection(sys.argv[1]).devices())" \
    "unix:$socket" >/dev/null || fail "the package haptic"
fi
