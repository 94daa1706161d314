#!/bin/sh
# What a person gets wrong: each ends with a status and a sentence that names it.
#
#   mistakes_test.sh HAPTICD HAPTICCTL SCENE
set -u
hapticd=$1 hapticctl=$2 scene=$3
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
failures=0

# says STATUS TEXT COMMAND...: it ends with STATUS and its words contain TEXT.
says() {
  expected=$1 text=$2
  shift 2
  output=$(timeout 20 "$@" 2>&1 </dev/null)
  status=$?
  if [ "$status" -ne "$expected" ] || ! printf '%s' "$output" | grep -qF -- "$text"; then
    echo "FAILED: $*"
    echo "  status $status, expected $expected; words, expected to contain '$text':"
    echo "$output" | sed 's/^/    /'
    failures=$((failures + 1))
  fi
}

sed 's/stiffness_n_per_m/stifness_n_per_m/' "$scene" >"$folder/typo.textproto"
printf 'time_s,q_o1_mcp_rad\n0,0\n0.01,0\n' >"$folder/column.csv"
printf 'time_s,q_o1_mcp_rad,q_o2_pip_rad\n0,0,0\n0.01,nonsense,0\n' >"$folder/number.csv"
motion='device[0].simulated_finger.motion_file'

says 2 '--scene is required' "$hapticd"
says 2 'No such file' "$hapticd" --scene "$folder/none"
says 2 'stifness_n_per_m: unknown field' "$hapticd" --scene "$folder/typo.textproto" --check-scene
says 2 'at most what the device can give, 40' "$hapticd" --scene "$scene" --check-scene \
  --set 'device[0].limits.force_n=41'
says 2 "device[3]" "$hapticd" --scene "$scene" --check-scene --set 'device[3].name=x'
says 2 'must be a whole number' "$hapticd" --scene "$scene" --check-scene --set loop.priority=abc
says 2 '--realtime: maybe not in {require,try,off}' "$hapticd" --scene "$scene" --realtime=maybe
says 1 'missing: q_o2_pip_rad' "$hapticd" --scene "$scene" --check-scene \
  --set "$motion=$folder/column.csv"
says 1 'missing: q_o2_pip_rad' "$hapticd" --scene "$scene" --listen "unix:$folder/s" \
  --set "$motion=$folder/column.csv"
says 1 'nonsense' "$hapticd" --scene "$scene" --check-scene --set "$motion=$folder/number.csv"
says 0 'ok' "$hapticd" --scene "$scene" --check-scene
printf 'time_s,q_o1_mcp_rad,q_o2_pip_rad\n0,0,0\n0.01,0,0\n' >"$folder/run.csv"
ln "$folder/run.csv" "$folder/link.csv"
says 2 'would be overwritten' "$hapticd" --scene "$scene" --listen "unix:$folder/s" \
  --set "$motion=$folder/run.csv" --set "record.file=$folder/link.csv"
says 2 'must be UTF-8' "$hapticd" --scene "$scene" --check-scene --set 'name="\377"'
says 2 'no lease ends under force' "$hapticd" --scene "$scene" --check-scene \
  --set 'device[0].staleness.fade_end={seconds: 2 nanos: 500000000}' \
  --set 'device[0].staleness.hold_end={seconds: 2}'

says 1 'no hapticd answers' "$hapticctl" --server "unix:$folder/nobody" info
says 1 'must be host:port or unix:/path' "$hapticctl" --server 127.0.0.1 info
says 1 'must be host:port or unix:/path' "$hapticctl" --server '' info
says 2 'wach' "$hapticctl" wach
says 2 'a command: info, watch' "$hapticctl"
says 2 '--bogus' "$hapticctl" engage --bogus
says 2 '--rate' "$hapticctl" watch --rate 0
says 2 '--rate' "$hapticctl" watch --rate nan
says 2 '--seconds' "$hapticctl" watch --seconds -3
says 2 '--seconds' "$hapticctl" engage --seconds nan

# Beside a server: an address in use, a device that is not there.
"$hapticd" --scene "$scene" --listen "unix:$folder/s" --realtime=off --log-level error 2>/dev/null &
server=$!
tries=0
until [ -S "$folder/s" ] || [ "$tries" -ge 100 ]; do tries=$((tries + 1)); sleep 0.1; done
says 1 'in use' "$hapticd" --scene "$scene" --listen "unix:$folder/s"
says 1 'must be one of finger' "$hapticctl" --server "unix:$folder/s" --device thumb info
says 0 'finger' "$hapticctl" --server "unix:$folder/s" info
kill -TERM "$server"
wait "$server" || { echo "FAILED: hapticd ended with status $?"; failures=$((failures + 1)); }

[ "$failures" -eq 0 ] && echo "every mistake was named"
exit "$failures"
