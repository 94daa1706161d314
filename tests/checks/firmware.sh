#!/bin/sh
# The board's side of the serial protocol compiles as firmware: C99, freestanding, no warning.
# Prints its size.
#
#   firmware.sh COMPILER [OPTION...]     exit status 77 (skipped) without that compiler
set -eu
root=$(cd "$(dirname "$0")/../.." && pwd)
compiler=$1
shift
if ! command -v "$compiler" >/dev/null 2>&1; then
  echo "skipped: no $compiler here (docker/install-deps.sh firmware installs one for Cortex-M)"
  exit 77
fi
objects=$(mktemp -d)
trap 'rm -rf "$objects"' EXIT
count=0
for source in "$root"/hw/firmware/*.c; do
  "$compiler" -std=c99 -ffreestanding -Wall -Wextra -pedantic -Werror -Wconversion -Wshadow -Os \
    "$@" \
    -c "$source" -o "$objects/$(basename "$source" .c).o"
  count=$((count + 1))
done
[ "$count" -ge 2 ] || { echo "no firmware found"; exit 2; }
size=size
case "$compiler" in *-gcc) size=${compiler%-gcc}-size ;; esac
"$size" -t "$objects"/*.o

# From a C library only the functions that a compiler may call by itself.
nm=nm
case "$compiler" in *-gcc) nm=${compiler%-gcc}-nm ;; esac
"$nm" -u "$objects"/*.o | sed -nE 's/^ *U (.*)/\1/p' |
  grep -vE '^(h[bf]_.*|mem(cpy|set|move|cmp)|__aeabi_.*|__gnu_.*|_GLOBAL_OFFSET_TABLE_|__stack_chk_fail)$' &&
  { echo "the firmware needs the functions above, and may not"; exit 1; }
exit 0
