#!/bin/sh
# The quick part of tests/report/run.sh bits: the beginning of one seed of every shipped scene has
# the stored bits, and one wrong bit of one reading is found.
#
#   bits_test.sh HAPTIC-BITS STORED-HASHES FOLDER
set -u
bits=$1
stored=$2
scenes=$3
status=0
"$bits" --scenes "$scenes" --stored "$stored" --seeds 1 --ticks 1000 2>/dev/null || status=$?
# 77: stored by another compiler or processor; what that says is printed.
[ "$status" -eq 0 ] || exit "$status"

# A run of the stored length with a wrong bit in its tick 1200.
found=$("$bits" --scenes "$scenes" --stored "$stored" --only finger_soft_grasp/finger --seeds 1 \
  --flip 1200 2>/dev/null) && { echo "FAILED: a flipped bit is not found"; exit 1; }
for words in "the force differs first in ticks 1201 to 1300" " q " " tau_a"; do
  case $found in
    *"$words"*) ;;
    *) echo "FAILED: a flipped bit must give '$words', not: $found"; exit 1 ;;
  esac
done
