#!/bin/sh
# The project's own C++ is formatted by .clang-format and clean under .clang-tidy.
#
#   tests/lint.sh [format|batches|tidy]     default: all
#
# `batches`: the sources of a room, and of one folder of tests, compile as one, so that no new file
# breaks the release build, which compiles them in batches. This and `tidy` configure build/lint, a
# build with every source on its own, and make the generated headers.
set -eu
root=$(cd "$(dirname "$0")/.." && pwd)
. "$root/tests/checks/files.sh"
cd "$root"

format() {
  files_of "$root" | grep -E '\.(hpp|cpp|h|c)$' | while read -r file; do
    [ ! -f "$file" ] || echo "$file"
  done | xargs clang-format --dry-run -Werror
}

configure() {
  cmake -S . -B build/lint -G Ninja -DCMAKE_BUILD_TYPE=Debug -DCMAKE_EXPORT_COMPILE_COMMANDS=ON
  cmake --build build/lint --target haptic_proto haptic_proto_grpc haptic_state_header \
    haptic_core_lists haptic_crossing_fields \
    client_readme_pieces hw_readme_pieces
}

batches() {
  configure
  python3 tests/checks/batches.py build/lint/compile_commands.json
}

tidy() {
  configure
  sed -nE 's/^ *"file": "([^"]+)".*/\1/p' build/lint/compile_commands.json | sort -u |
    grep "^$root/.*\.cpp$" | grep -v "^$root/build/" |
    xargs -P "$(nproc)" -n 1 clang-tidy -p build/lint --quiet --warnings-as-errors='*'
}

case "${1:-all}" in
  all) format; batches; tidy ;;
  format) format ;;
  batches) batches ;;
  tidy) tidy ;;
  *) sed -n '2,${/^#/!q;s/^# \{0,1\}//p}' "$0"; exit 2 ;;
esac
