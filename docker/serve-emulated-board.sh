#!/bin/sh
# Runs hapticd with a board: haptic-board-emulator on a pseudo-terminal of the same container.
# Arguments are hapticd's. Ends with hapticd's status.
set -eu
board=$PWD/board
scenes=/usr/share/haptic/scenes
# The board's watchdog waits longer than a shared machine without real-time scheduling is late.
haptic-board-emulator --link "$board" --watchdog-ms 1000 \
  --motion "$scenes/motion/reach_and_grasp.csv" &
emulator=$!
while [ ! -L "$board" ]; do
  kill -0 "$emulator"
  sleep 0.1
done
hapticd --scene "$scenes/finger_board.textproto" --set "device[0].board.port=$board" "$@" &
server=$!
stopping=false
trap 'stopping=true; kill -TERM "$server"' TERM INT
status=0
wait "$server" || status=$?
if $stopping; then # the signal ended that wait; this one returns the server's status
  status=0
  wait "$server" || status=$?
fi
kill "$emulator"
wait "$emulator" || true
exit "$status"
