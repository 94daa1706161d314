#!/bin/sh
# Runs the README's first client against a hapticd on a socket in a temporary folder.
#
#   first_client.sh HAPTICD CLIENT SCENE
set -eu
folder=$(mktemp -d)
server=
finish() {
  if [ -n "$server" ]; then
    kill "$server" 2>/dev/null || true
    wait "$server" || true
  fi
  rm -rf "$folder"
}
trap finish EXIT

"$1" --scene "$3" --realtime=off --listen "unix:$folder/socket" &
server=$!
for _ in $(seq 100); do
  [ -S "$folder/socket" ] && break
  kill -0 "$server" || exit 1
  sleep 0.1
done
timeout 30 "$2" "unix:$folder/socket"
kill -0 "$server"  # the client's visit must not have ended it
