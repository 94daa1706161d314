#!/bin/sh
# The .deb packages: what is in them and what they ask for. docker/test.sh installs them in a clean
# container. 77: dpkg-deb, dpkg-shlibdeps or file is not there.
#
#   deb_test.sh BUILD FOLDER
set -eu
for tool in dpkg-deb dpkg-shlibdeps file; do
  command -v $tool >/dev/null || { echo "skipped: no $tool"; exit 77; }
done
fail() {
  echo "deb_test.sh: $*" >&2
  exit 1
}
. "$(dirname "$0")/../support/scratch.sh"
fresh_folder "$2"
cpack -G DEB --config "$1/CPackConfig.cmake" -B "$2" >"$2.log" 2>&1 || { cat "$2.log"; fail "cpack"; }

package() { # package NAME: its file
  set -- "$2"/"$1"_*.deb
  [ -f "$1" ] || fail "no package $1"
  echo "$1"
}
holds() { # holds NAME PATH...
  list=$(dpkg-deb --contents "$(package "$1" "$folder")" | awk '{ print $6 }')
  name=$1
  shift
  for path in "$@"; do
    echo "$list" | grep -qx "$path" || fail "$name has no $path"
  done
}
folder=$2
holds hapticd ./usr/bin/hapticd ./usr/lib/systemd/system/hapticd.service ./etc/hapticd/scene.textproto \
  ./usr/share/haptic/scenes/finger_soft_grasp.textproto ./usr/share/haptic/scenes/motion/reach_and_grasp.csv
holds hapticd-client ./usr/bin/hapticctl ./usr/bin/haptic-example-soft-grasp
holds python3-haptic ./usr/lib/python3/dist-packages/haptic/__init__.py ./usr/lib/python3/dist-packages/haptic/py.typed \
  ./usr/lib/python3/dist-packages/haptic/v1/session_pb2.py
holds libhaptic-dev ./usr/include/haptic/client/client.hpp ./usr/share/haptic/proto/haptic/v1/session.proto

field() { dpkg-deb --field "$(package "$1" "$folder")" "$2"; }
for library in libgrpc++ libsystemd0 libssl3 libserialport0; do
  field hapticd Depends | grep -qF "$library" || fail "hapticd does not ask for $library"
done
field libhaptic-dev Depends | grep -qF libgrpc++-dev || fail "libhaptic-dev does not ask for gRPC"
field python3-haptic Depends | grep -qF python3-grpcio || fail "python3-haptic does not ask for gRPC"
for name in hapticd hapticd-client python3-haptic libhaptic-dev; do
  holds $name ./usr/share/doc/$name/copyright
  field $name Description | sed -n 1p >>"$folder/synopses"
  stray=$(dpkg-deb --contents "$(package $name "$folder")" | awk '{ print $6 }' |
    grep -vE '^\./$|^\./(usr|etc)/' || true)
  [ -z "$stray" ] || fail "$name puts files at $stray"
done
[ "$(sort -u "$folder/synopses" | wc -l)" = 4 ] || fail "packages that say the same of themselves: $(cat "$folder/synopses")"

# The unit runs what is in the package; the scene is the owner's to change.
root=$2/root
dpkg-deb --extract "$(package hapticd "$folder")" "$root"
grep -qxF 'ExecStart=/usr/bin/hapticd --scene /etc/hapticd/scene.textproto' \
  "$root/usr/lib/systemd/system/hapticd.service" || fail "the unit starts something else"
[ "$(dpkg-deb --info "$(package hapticd "$folder")" conffiles)" = /etc/hapticd/scene.textproto ] ||
  fail "the scene is no conffile"
