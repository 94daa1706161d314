#!/bin/sh
# Every relative link in every Markdown file leads to a file or folder that exists.
#
#   markdown_links.sh [ROOT]
set -u
root=$(cd "${1:-$(dirname "$0")/../..}" && pwd)
. "$(dirname "$0")/files.sh"
cd "$root" || exit 2

status=0
checked=0
for file in $(files_of "$root" | grep '\.md$'); do
  [ -f "$file" ] || continue
  # Code blocks show links of other worlds; leave them out.
  for link in $(awk '/^ *```/ { code = !code; next } !code' "$file" |
    sed -E 's/`[^`]*`//g' | grep -oE '\]\([^)[:space:]]+\)' | sed -E 's/^\]\(//; s/\)$//'); do
    case "$link" in
      *://* | mailto:* | '#'*) continue ;;
    esac
    checked=$((checked + 1))
    if [ ! -e "$(dirname "$file")/${link%%#*}" ]; then
      echo "$file: no such file: $link"
      status=1
    fi
  done
done
echo "$checked links checked"
[ "$checked" -gt 0 ] || exit 2
exit $status
