#!/bin/sh
# A Debian base image without a registry, by debootstrap, once: localhost/debian:bookworm.
#
#   docker/base-image.sh ENGINE [MIRROR]
#
# Needs root and debootstrap (docker/install-deps.sh containers). Does nothing where the image is there.
set -eu
engine=${1:?the engine: docker or podman}
mirror=${2:-http://deb.debian.org/debian}
image=localhost/debian:bookworm
if "$engine" image inspect "$image" >/dev/null 2>&1; then exit 0; fi
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
command -v debootstrap >/dev/null || { echo "base-image.sh: no debootstrap" >&2; exit 1; }
debootstrap --variant=minbase bookworm "$folder/root" "$mirror" >"$folder/log" 2>&1 || {
  tail -n 20 "$folder/log" >&2
  echo "base-image.sh: debootstrap failed" >&2
  exit 1
}
# Before the import: a later layer would hide it and weigh as much.
rm -rf "$folder"/root/var/cache/apt/* "$folder"/root/var/lib/apt/lists/* "$folder"/root/usr/share/doc/* \
  "$folder"/root/usr/share/man/* "$folder"/root/usr/share/locale/* "$folder"/root/usr/share/info/* \
  "$folder"/root/var/log/*.log
tar -C "$folder/root" -c . | "$engine" import - "$image" >/dev/null
echo "base-image.sh: $image" >&2
