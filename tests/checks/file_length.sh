#!/bin/sh
# No source file over 450 lines: one concept per file (CONTRIBUTING.md#style).
#
#   file_length.sh [ROOT]
set -u
root=$(cd "${1:-$(dirname "$0")/../..}" && pwd)
. "$(dirname "$0")/files.sh"
cd "$root" || exit 2

limit=450
checked=0
status=0
for file in $(files_of "$root" | grep -E '\.(hpp|cpp|h|c|proto|sh|py|cmake|gp|awk|textproto|txt)$|/run$' |
  grep -v '^proto/google/'); do
  [ -f "$file" ] || continue
  checked=$((checked + 1))
  lines=$(wc -l <"$file")
  if [ "$lines" -gt "$limit" ]; then
    echo "$file: $lines lines; at most $limit"
    status=1
  fi
done
echo "$checked files checked"
[ "$checked" -gt 0 ] || exit 2
exit $status
