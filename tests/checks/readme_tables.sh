#!/bin/sh
# Every path in README.md's tables (in backquotes, with a slash) exists.
#
#   readme_tables.sh [ROOT]
set -u
root=$(cd "${1:-$(dirname "$0")/../..}" && pwd)
cd "$root" || exit 2

status=0
checked=0
for path in $(grep '^|' README.md | grep -oE '`[A-Za-z0-9_.{},*/-]+/[A-Za-z0-9_.{},*/-]*`' | tr -d '`' | sort -u); do
  case "$path" in
    */*.hpp | */*.cpp | */*.sh | */*.proto | */*.md | */*.txt | */) ;;
    *) continue ;;
  esac
  checked=$((checked + 1))
  if [ ! -e "$path" ]; then
    echo "README.md: no such file: $path"
    status=1
  fi
done
echo "$checked paths checked"
[ "$checked" -ge 10 ] || { echo "README.md's tables name too few files: has their form changed?"; exit 2; }
exit $status
