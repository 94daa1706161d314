#!/bin/sh
# tests/report/run.sh makes what it promises, of the parts that are quick: CSV, pictures, index.md.
#
#   run_test.sh BUILD-FOLDER OUTPUT-FOLDER
set -eu
here=$(cd "$(dirname "$0")" && pwd)
. "$here/../support/scratch.sh"
fresh_folder "$2"
"$here/run.sh" --build "$1" --output "$2" scan radius 2>/dev/null

for file in scan.csv scan_list.csv scan.svg scan.png radius.svg radius.png index.md; do
  [ -s "$2/$file" ] || { echo "FAILED: $file is missing or empty"; exit 1; }
done
grep -q 'polyline\|<path' "$2/scan.svg" || { echo "FAILED: scan.svg has no curve"; exit 1; }
grep -qF '| subspace_linear | 168 | 88 | 52.4 |' "$2/index.md" ||
  { echo "FAILED: index.md has no table"; exit 1; }
grep -qF '(scan.svg)' "$2/index.md" || { echo "FAILED: index.md shows no figure"; exit 1; }
# Parts that were not made are not spoken of, and every picture that is spoken of is there.
if grep -q 'At the finger' "$2/index.md"; then echo "FAILED: a part that was not made"; exit 1; fi
grep -oE '[(][a-z0-9_]+[.](svg|png)[)]' "$2/index.md" | tr -d '()' | while read -r picture; do
  [ -s "$2/$picture" ] || { echo "FAILED: index.md shows $picture"; exit 1; }
done
if "$here/run.sh" --build "$1" --output "$2" no_such_part 2>/dev/null; then
  echo "FAILED: an unknown part must be refused"
  exit 1
fi
