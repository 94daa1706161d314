#!/bin/sh
# No source file over 450 lines, and none of the product over 300: one concept per file
# (CONTRIBUTING.md#style).
#
#   file_length.sh [ROOT]
set -u
root=$(cd "${1:-$(dirname "$0")/../..}" && pwd)
. "$(dirname "$0")/files.sh"
cd "$root" || exit 2

# The most lines that a file may have.
limit() { # limit FILE
  case $1 in
    # The exceptions, each with its reason.
    proto/haptic/v1/*.proto) echo 490 ;;           # a format is read as one page
    core/src/model/finger_reach.cpp) echo 320 ;;   # one derivation, case by case
    hw/board/board_host.cpp) echo 335 ;;           # one protocol, all its messages
    client/csharp/HapticSession.cs) echo 560 ;;    # one class, and its wire
    tests/* | docker/*) echo 450 ;;
    *.textproto | *.txt) echo 450 ;;
    *) echo 300 ;;
  esac
}

checked=0
status=0
for file in $(files_of "$root" |
  grep -E '\.(hpp|cpp|h|c|cs|proto|sh|py|ts|mjs|cmake|gp|awk|textproto|txt)$|/run$' |
  grep -v '^proto/google/'); do
  [ -f "$file" ] || continue
  checked=$((checked + 1))
  lines=$(wc -l <"$file")
  if [ "$lines" -gt "$(limit "$file")" ]; then
    echo "$file: $lines lines; at most $(limit "$file")"
    status=1
  fi
done
echo "$checked files checked"
[ "$checked" -gt 0 ] || exit 2
exit $status
