#!/bin/sh
# The .deb packages: their contents, their dependencies, and lintian's errors. docker/test.sh
# installs them in a clean container. 77: dpkg-deb, dpkg-shlibdeps, file, help2man or lintian is not
# there.
#
#   deb_test.sh BUILD FOLDER
set -eu
for tool in dpkg-deb dpkg-shlibdeps file help2man lintian; do
  command -v $tool >/dev/null || { echo "skipped: no $tool"; exit 77; }
done
fail() {
  echo "deb_test.sh: $*" >&2
  exit 1
}
. "$(dirname "$0")/../support/scratch.sh"
fresh_folder "$2"
cpack -G DEB --config "$1/CPackConfig.cmake" -B "$2" >"$2.log" 2>&1 ||
  { cat "$2.log"; fail "cpack"; }

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
holds hapticd ./usr/bin/hapticd ./usr/libexec/hapticd/hapticd-front \
  ./usr/lib/sysusers.d/hapticd.conf ./usr/lib/systemd/system/hapticd.service \
  ./etc/hapticd/scene.textproto ./usr/share/doc/hapticd/examples/avahi/hapticd.service \
  ./usr/share/haptic/scenes/finger_soft_grasp.textproto \
    ./usr/share/haptic/scenes/motion/reach_and_grasp.csv \
  ./etc/security/limits.d/haptic.conf ./usr/lib/udev/rules.d/60-haptic.rules \
  ./usr/share/man/man8/hapticd.8.gz ./usr/share/bash-completion/completions/hapticd
holds hapticd-client ./usr/bin/hapticctl ./usr/bin/haptic-example-soft-grasp \
  ./usr/share/man/man1/hapticctl.1.gz ./usr/share/man/man1/hapticctl-watch.1.gz \
  ./usr/share/bash-completion/completions/hapticctl
holds python3-haptic ./usr/lib/python3/dist-packages/haptic/__init__.py \
  ./usr/lib/python3/dist-packages/haptic/py.typed \
  ./usr/lib/python3/dist-packages/haptic/_libhaptic.py
holds libhaptic-dev ./usr/include/haptic/client/client.hpp \
  ./usr/share/haptic/proto/haptic/v1/session.proto
holds libhaptic0 ./usr/lib/libhaptic.so.0
holds libhaptic-c-dev ./usr/include/haptic/haptic.h ./usr/lib/libhaptic.so \
  ./usr/lib/pkgconfig/haptic-c.pc ./usr/lib/cmake/haptic-c/haptic-c-config.cmake

packages="hapticd hapticd-client python3-haptic libhaptic-dev libhaptic0 libhaptic-c-dev"
if ls "$folder"/libhaptic-mujoco-dev_*.deb >/dev/null 2>&1; then  # MuJoCo was here for the build
  packages="$packages libhaptic-mujoco-dev"
  holds libhaptic-mujoco-dev ./usr/include/haptic/mujoco/tool.hpp \
    ./usr/share/haptic/mujoco/finger.xml ./usr/share/haptic/mujoco/hand.xml
fi

field() { dpkg-deb --field "$(package "$1" "$folder")" "$2"; }
for library in libgrpc++ libsystemd0 libssl3 libserialport0; do
  field hapticd Depends | grep -qF "$library" || fail "hapticd does not ask for $library"
done
field libhaptic-dev Depends | grep -qF libgrpc++-dev || fail "libhaptic-dev does not ask for gRPC"
field libhaptic0 Depends | grep -qF libgrpc++ || fail "libhaptic0 does not ask for gRPC"
[ "$(field libhaptic-c-dev Depends)" = "libhaptic0 (= $(field libhaptic0 Version))" ] ||
  fail "libhaptic-c-dev asks for $(field libhaptic-c-dev Depends)"
dpkg-deb --info "$(package libhaptic0 "$folder")" shlibs | grep -q '^libhaptic 0 libhaptic0 ' ||
  fail "libhaptic0 does not tell other packages who has the library"
for needed in python3-cffi-backend "libhaptic0 (= $(field libhaptic0 Version))"; do
  field python3-haptic Depends | grep -qF "$needed" ||
    fail "python3-haptic does not ask for $needed"
done
for name in $packages; do
  holds $name ./usr/share/doc/$name/copyright ./usr/share/doc/$name/changelog.Debian.gz
  field $name Description | sed -n 1p >>"$folder/synopses"
  stray=$(dpkg-deb --contents "$(package $name "$folder")" | awk '{ print $6 }' |
    grep -vE '^\./$|^\./(usr|etc)/' || true)
  [ -z "$stray" ] || fail "$name puts files at $stray"
done
[ "$(sort -u "$folder/synopses" | wc -l)" = "$(echo "$packages" | wc -w)" ] ||
  fail "packages with the same description: $(cat "$folder/synopses")"

lintian --fail-on error "$folder"/*.deb >"$folder/lintian" 2>&1 ||
  { cat "$folder/lintian"; fail "lintian"; }

# The unit runs what is in the package; the user may change the scene and the limits.
root=$2/root
dpkg-deb --extract "$(package hapticd "$folder")" "$root"
grep -qxF 'ExecStart=/usr/bin/hapticd --scene /etc/hapticd/scene.textproto' \
  "$root/usr/lib/systemd/system/hapticd.service" || fail "the unit starts something else"
[ "$(dpkg-deb --info "$(package hapticd "$folder")" conffiles | paste -s -d ' ')" = \
  '/etc/hapticd/scene.textproto /etc/security/limits.d/haptic.conf' ] || fail "other conffiles"
