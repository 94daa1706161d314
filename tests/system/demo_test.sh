#!/bin/sh
# The demo, short: contact is felt, here and 100 ms away, free motion is free, the pictures are
# there and show something.
# With --serial: through an emulated board, a program that a busy host holds up, unlike a board.
# With --hand: the hand grasps the ball, and is filmed.
# Its forces are judged unless samples came later than they fade: then the machine was busy.
#
#   demo_test.sh BUILD-FOLDER OUTPUT-FOLDER [--serial | --hand]
set -eu
demo=$(cd "$(dirname "$0")/../../server" && pwd)/demo.sh
output=$2
. "$(dirname "$0")/../support/scratch.sh"
fresh_folder "$output"

check() {  # check WHAT COMMAND...
  what=$1
  shift
  "$@" || { echo "FAILED: $what"; exit 1; }
}
summary=$output/summary.txt

run_demo() {  # run_demo ARGUMENTS...; sets `judged`
  judged=true
  status=0
  "$demo" "$@" --output "$output" </dev/null || status=$?
  case $status in
    0) return ;;
    3 | 4 | 5 | 8) ;;  # force was not as promised
    *) check "the demo ends well, not with $status" false ;;
  esac
  faded=$(cat "$output"/recording*.csv | awk -F, '
    /^time_s/ { for (i = 1; i <= NF; i++) column[$i] = i; next }
    $column["proxy_age_us"] > 100000 && $column["mode"] != "NONE" { n++ }
    END { print n + 0 }')
  check "as promised, by samples that all came in time" test "$faded" -gt 0
  echo "force is not judged: in $faded ticks it faded, because samples came late"
  judged=false
}

if [ "${3:-}" = --serial ]; then
  # It ends with 0 if contact was felt and free motion was free.
  check "the demo over serial" "$demo" --serial --build "$1" --seconds 10 --output "$output" \
    </dev/null
  check "its summary says so" grep -q 'over a serial link to an emulated board' "$summary"
  check "it names a contact force" grep -qE 'contact +peak \|tau_a\| [0-9.]+ N' "$summary"
  exit 0
fi

if [ "${3:-}" = --hand ]; then
  command -v ffmpeg >/dev/null || { echo "ffmpeg is not here"; exit 77; }
  # It ends with 0 if every finger felt the ball, free motion was free and no sample was refused.
  run_demo --hand --build "$1" --seconds 8
  if $judged; then
    check "ten contacts at once" grep -qE 'contacts at once +1[0-9]' "$summary"
    check "its verdict" grep -q 'within 2 %' "$summary"
  fi
  check "the film shows something" test "$(wc -c <"$output/hand.webm")" -gt 300000
  check "the picture shows something" test "$(wc -c <"$output/hand.png")" -gt 40000
  check "the forces are drawn" test "$(wc -c <"$output/hand-forces.png")" -gt 40000
  exit 0
fi

run_demo --build "$1" --seconds 6 --delay 100
if $judged; then
  check "the summary names a contact force" grep -qE 'contact +peak \|tau_a\| [0-9.]+ N' "$summary"
  check "the summary gives its verdict" grep -q 'within 2 %' "$summary"
  check "the summary compares it" grep -qE '100 ms round trip +force differs by [0-9.]+ N rms' \
    "$summary"
fi
check "the summary counts ticks" grep -qE '[1-9][0-9]{3} ticks' "$summary"
# A figure without curves is a few kB.
check "the PNG shows something" test "$(wc -c <"$output/soft-grasp.png")" -gt 40000
check "the PNG is one" sh -c 'head -c 8 "$1" | od -An -tx1 | grep -q "89 50 4e 47"' - \
  "$output/soft-grasp.png"
! $judged || check "the delayed force is drawn" test "$(wc -c <"$output/delay.png")" -gt 40000
check "the SVG shows curves" test "$(grep -c '<path' "$output/soft-grasp.svg")" -gt 10
check "the recording compares the methods" grep -q 'tau_subspace_exact_l_x_n' \
  "$output/recording.csv"

# Errors are said, not swallowed.
if "$demo" --build "$1" --seconds x --output "$output" 2>/dev/null; then
  echo "FAILED: --seconds x was accepted"
  exit 1
fi
if "$demo" --build "$1" --seconds 3 --motion "$output/nowhere.csv" 2>/dev/null; then
  echo "FAILED: a motion file that does not exist was accepted"
  exit 1
fi
