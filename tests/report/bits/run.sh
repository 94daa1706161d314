#!/usr/bin/env bash
# Runs every shipped scene in virtual time (three seeds, 3000 ticks each) and compares what the loop
# computes, to the bit, with stored.txt. It names each run that differs, the block of ticks in which
# the force first does, and the fields. Exit status 77: the stored bits are those of another
# compiler or processor.
#
#   tests/report/run.sh bits [--write] [--against DIR] [--build DIR]
#
#   --write        stores the bits of a change that is meant
#   --against DIR  a build folder of the older tree: also prints the first tick and field that
#                  differ, by both programs ("<": the older one; doubles by their bits)
#   --build DIR    uses haptic-bits of this build folder; neither installs nor builds
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
root=$(cd "$here/../../.." && pwd)

write=()
against=
build=
while (($#)); do
  case "$1" in
    --write) write=(--write); shift ;;
    --against) against=$(realpath -e -- "${2:?--against needs a build folder}"); shift 2 ;;
    --build) build=$(realpath -e -- "${2:?--build needs a folder}"); shift 2 ;;
    -h | --help) sed -n '2,${/^#/!q;s/^# \{0,1\}//p}' "$0"; exit 0 ;;
    *) echo "run.sh bits: unknown argument '$1' (see --help)" >&2; exit 2 ;;
  esac
done

if [[ -z $build ]]; then
  sh "$root/docker/install-deps.sh" build test
  (cd "$root" && cmake --preset release --log-level=WARNING >/dev/null &&
    cmake --build --preset release --parallel "$(nproc)" --target haptic-bits)
  build=$root/build/release
fi
program_of() {  # program_of FOLDER: haptic-bits of a build folder
  local program=$1/tests/report/haptic-bits
  [[ -x $program ]] ||
    { echo "run.sh bits: no program haptic-bits in $1; build it first" >&2; exit 1; }
  echo "$program"
}
program=$(program_of "$build")
[[ -z $against ]] || older=$(program_of "$against")

status=0
said=$("$program" --scenes "$root/server/scenes" --stored "$here/stored.txt" "${write[@]}" \
  2>/dev/null) || status=$?
[[ -z $said ]] || echo "$said"
[[ -n $against && $status -eq 1 ]] || exit "$status"

trace() {  # trace PROGRAM DEVICE SEED
  "$1" --trace --scenes "$root/server/scenes" --only "$2" --seeds "$3"
}
sed -nE 's/^([^ ]+) seed ([0-9]+): the force.*/\1 \2/p' <<<"$said" |
  while read -r device seed; do
    echo "$device seed $seed, first tick,field:"
    { diff <(trace "$older" "$device" "$seed") <(trace "$program" "$device" "$seed") || true; } |
      awk '/^[<>]/ && !seen[$1]++'
  done
exit "$status"
