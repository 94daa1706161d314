#!/bin/sh
# A Debian base image without a registry, by debootstrap, once: localhost/debian:bookworm.
#
#   docker/base-image.sh ENGINE [MIRROR]
#
# Needs root and debootstrap (docker/install-deps.sh containers). Does nothing if the image exists.
set -eu
engine=${1:?the engine: docker or podman}
mirror=${2:-} # default: debootstrap's own
image=localhost/debian:bookworm
if "$engine" image inspect "$image" >/dev/null 2>&1; then exit 0; fi
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
command -v debootstrap >/dev/null || { echo "base-image.sh: no debootstrap" >&2; exit 1; }
debootstrap --variant=minbase bookworm "$folder/tree" ${mirror:+"$mirror"} >"$folder/log" 2>&1 || {
  tail -n 20 "$folder/log" >&2
  echo "base-image.sh: debootstrap failed" >&2
  exit 1
}
# Before the import: a later layer would hide these files, and the image stay as large.
rm -rf "$folder"/tree/var/cache/apt/* "$folder"/tree/var/lib/apt/lists/* \
  "$folder"/tree/usr/share/doc/* \
  "$folder"/tree/usr/share/man/* "$folder"/tree/usr/share/locale/* "$folder"/tree/usr/share/info/* \
  "$folder"/tree/var/log/*.log
tar -C "$folder/tree" -c . | "$engine" import - "$image" >/dev/null
echo "base-image.sh: $image" >&2
