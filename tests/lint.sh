#!/bin/sh
# The project's own C++ is formatted by .clang-format and clean under .clang-tidy.
#
#   tests/lint.sh [format] [tidy [BUILD-FOLDER]]     default: both, with build/release
#
# `tidy` reads the compile database of BUILD-FOLDER, which must have been built (generated headers).
set -eu
root=$(cd "$(dirname "$0")/.." && pwd)
. "$root/tests/checks/files.sh"
cd "$root"

format() {
  files_of "$root" | grep -E '\.(hpp|cpp|h|c)$' | while read -r file; do
    [ ! -f "$file" ] || echo "$file"
  done | xargs clang-format --dry-run -Werror
}

tidy() {  # tidy BUILD-FOLDER
  database=$1/compile_commands.json
  [ -f "$database" ] || { echo "lint.sh: no $database; build first" >&2; exit 2; }
  sed -nE 's/^ *"file": "([^"]+)".*/\1/p' "$database" | sort -u | grep "^$root/" |
    grep -v "^$root/build/" |
    xargs -P "$(nproc)" -n 1 clang-tidy -p "$1" --quiet --warnings-as-errors='*'
}

case "${1:-both}" in
  both) format; tidy "$root/build/release" ;;
  format) format ;;
  tidy) tidy "$(cd "${2:-$root/build/release}" && pwd)" ;;
  *) sed -n '2,6s/^# \{0,1\}//p' "$0"; exit 2 ;;
esac
