#!/bin/sh
# The positive control of proto/buf.sh check: it finds a name that is not snake_case, and a field or
# a value of an enumeration that a client of the last release knows and that is gone, unless both
# its number and its name are reserved.
#
#   proto_rules_test.sh PROTO SCRATCH-FOLDER
set -eu
. "$(dirname "$0")/../support/scratch.sh"
fresh_folder "$2"
cp -R "$1/." "$2"
proto=$1 folder=$2 session=$2/haptic/v1/session.proto
cp "$session" "$folder/kept"

fail() {
  echo "FAILED: $1:"
  cat "$folder/log"
  exit 1
}
check() { sh "$proto/buf.sh" check "$folder" >"$folder/log" 2>&1; }
finds() { # finds TEXT WHAT: the check fails, and says the text of what is wrong
  ! check || fail "$2 passes"
  grep -qF "$1" "$folder/log" || fail "'$1' is not said of $2"
}
instead() { # instead LINE TEXT: session.proto with the text for the line
  grep -qF "$1" "$folder/kept" || fail "there is no '$1'"
  sed "0,/^.*$1.*\$/s//$2/" "$folder/kept" >"$session"
}

status=0
check || status=$?
[ "$status" -ne 77 ] || { cat "$folder/log"; exit 77; }
[ "$status" -eq 0 ] || fail "the messages as they are"
echo 'message Extra { int32 notSnake = 1; }' >>"$session"
finds 'should be lower_snake_case' 'a name of another form'
removed() { # removed LINE NUMBER NAME
  instead "$1" ''
  finds 'without reserving the number' "$1, removed"
  finds 'without reserving the name' "$1, removed"
  instead "$1" "reserved $2;"
  finds 'without reserving the name' "$1, its number reserved"
  instead "$1" "reserved \"$3\";"
  finds 'without reserving the number' "$1, its name reserved"
  instead "$1" "reserved $2; reserved \"$3\";"
  check || fail "$1, reserved"
}
removed 'uint32 hold_us = 4;' 4 hold_us
removed 'PRIORITY_OPERATOR = 3;' 3 PRIORITY_OPERATOR
