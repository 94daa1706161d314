#!/bin/sh
# The positive control of proto/buf.sh check: it finds a name that is not snake_case, and a field
# that a client of the last release knows and that is gone.
#
#   proto_rules_test.sh PROTO SCRATCH-FOLDER
set -eu
. "$(dirname "$0")/../support/scratch.sh"
fresh_folder "$2"
cp -R "$1/." "$2"
session=$2/haptic/v1/session.proto

finds() { # finds SOURCE COPY TEXT
  if sh "$1/buf.sh" check "$2" >"$2/log" 2>&1 || ! grep -qF "$3" "$2/log"; then
    echo "FAILED: '$3' was not found:"
    cat "$2/log"
    exit 1
  fi
}
sh "$1/buf.sh" check "$2"
cp "$session" "$2/kept"
echo 'message Extra { int32 notSnake = 1; }' >>"$session"
finds "$1" "$2" 'should be lower_snake_case'
sed '0,/uint64 seq = 1;/s///' "$2/kept" >"$session"
finds "$1" "$2" 'was deleted'
