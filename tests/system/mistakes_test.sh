#!/bin/sh
# Mistakes of a user: each ends with its own exit status and a message that names the mistake.
#
#   mistakes_test.sh HAPTICD HAPTICCTL SCENE
set -u
hapticd=$1 hapticctl=$2 scene=$3
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
failures=0

# says STATUS TEXT COMMAND...: the command ends with STATUS and its output contains TEXT.
says() {
  expected=$1 text=$2
  shift 2
  output=$(timeout 20 "$@" 2>&1 </dev/null)
  status=$?
  if [ "$status" -ne "$expected" ] || ! printf '%s' "$output" | grep -qF -- "$text"; then
    echo "FAILED: $*"
    echo "  status $status, expected $expected; output, expected to contain '$text':"
    echo "$output" | sed 's/^/    /'
    failures=$((failures + 1))
  fi
}

sed 's/stiffness_n_per_m/stifness_n_per_m/' "$scene" >"$folder/typo.textproto"
printf 'time_s,q_o1_mcp_rad\n0,0\n0.01,0\n' >"$folder/column.csv"
printf 'time_s,q_o1_mcp_rad,q_o2_pip_rad\n0,0,0\n0.01,nonsense,0\n' >"$folder/number.csv"
printf 'time_s,q_o1_mcp_rad,q_o2_pip_rad\n0,20,0.2\n0.01,54.3,0.2\n' >"$folder/degrees.csv"
printf '\357\273\277' | cat - "$scene" >"$folder/bom.textproto"
tr -d '}' <"$scene" >"$folder/open.textproto"
motion='device[0].simulated_finger.motion_file'

says 2 '--scene is missing' "$hapticd"
says 2 'finger_constant  ' "$hapticd"
says 0 'ok' "$hapticd" --scene finger_constant --check-scene
says 0 'device[0].unguarded: no passivity.tank' "$hapticd" --scene finger_constant --check-scene \
  --set 'device[0].unguarded={}'
says 2 'No such file' "$hapticd" --scene "$folder/none"
says 2 'finger_soft_gras: no such file or scene; did you mean finger_soft_grasp?' \
  "$hapticd" --scene finger_soft_gras
says 0 'bom.textproto: ok' "$hapticd" --scene "$folder/bom.textproto" --check-scene \
  --set "$motion=$(dirname "$scene")/motion/reach_and_grasp.csv"
says 2 ': a } is missing, for the { of line ' "$hapticd" --scene "$folder/open.textproto"
says 0 "degrees.csv: column q_o1_mcp_rad: values to 54.3: degrees? a finger's joints bend by -1 to \
2.2 rad" "$hapticd" --scene "$scene" --check-scene --set "$motion=$folder/degrees.csv"
says 2 'stifness_n_per_m: unknown field' "$hapticd" --scene "$folder/typo.textproto" --check-scene
says 2 'at most what the device can give, 40' "$hapticd" --scene "$scene" --check-scene \
  --set 'device[0].limits.force_n=41'
says 2 "device[3]" "$hapticd" --scene "$scene" --check-scene --set 'device[3].name=x'
says 2 'must be a whole number' "$hapticd" --scene "$scene" --check-scene --set loop.priority=abc
says 2 '--realtime: maybe not in {require,try,off}' "$hapticd" --scene "$scene" --realtime=maybe
says 2 '--listen: must be "host:port"' "$hapticd" --scene "$scene" --listen nonsense
says 1 'missing: q_o2_pip_rad' "$hapticd" --scene "$scene" --check-scene \
  --set "$motion=$folder/column.csv"
says 1 'missing: q_o2_pip_rad' "$hapticd" --scene "$scene" --listen "unix:$folder/s" \
  --set "$motion=$folder/column.csv"
says 1 'nonsense' "$hapticd" --scene "$scene" --check-scene --set "$motion=$folder/number.csv"
printf 'time_s,q_o1_mcp_rad,q_o2_pip_rad\n0,\342\200\256,0\n' >"$folder/turns.csv"
says 1 '\xe2\x80\xae' "$hapticd" --scene "$scene" --check-scene --set "$motion=$folder/turns.csv"
says 0 'ok' "$hapticd" --scene "$scene" --check-scene
printf 'time_s,q_o1_mcp_rad,q_o2_pip_rad\n0,0,0\n0.01,0,0\n' >"$folder/run.csv"
ln "$folder/run.csv" "$folder/link.csv"
says 2 'would be overwritten' "$hapticd" --scene "$scene" --listen "unix:$folder/s" \
  --set "$motion=$folder/run.csv" --set "record.file=$folder/link.csv"
(umask 077 && echo short >"$folder/token")
says 1 'must hold 16 to 128' "$hapticd" --scene "$scene" --check-scene \
  --set "server.web={token {name: 'a' rights: 'test' file: '$folder/token'}}"
# A front that only looks at itself.
printf '#!/bin/sh\nid -u >"%s/user"\n' "$folder" >"$folder/front"
chmod 777 "$folder" && chmod 755 "$folder/front"
says 1 'another build' env HAPTICD_FRONT="$folder/front" "$hapticd" --scene "$scene" --check-scene \
  --set "server.web={token {name: 'a' rights: 'test' file: '$folder/token'}}"
[ "$(cat "$folder/user")" != 0 ] || says none 'a check runs its front as root' true
says 2 'must be UTF-8' "$hapticd" --scene "$scene" --check-scene --set 'name="\377"'
says 2 'no lease ends under force' "$hapticd" --scene "$scene" --check-scene \
  --set 'device[0].staleness.fade_end={seconds: 2 nanos: 500000000}' \
  --set 'device[0].staleness.hold_end={seconds: 2}'

ctl() { # ctl STATUS TEXT ARGUMENT...: hapticctl at the socket of this test
  status=$1 text=$2
  shift 2
  says "$status" "$text" "$hapticctl" --server "unix:$folder/s" "$@"
}
says 2 'must be host:port or unix:/path' "$hapticctl" --server 127.0.0.1 info
says 2 'must be host:port or unix:/path' "$hapticctl" --server '' info
says 2 'must be host:port or unix:/path' "$hapticctl" --server 127.0.0.1:65536 info
says 2 'wach' "$hapticctl" wach
says 2 'a command is required' "$hapticctl"
says 2 '--bogus' "$hapticctl" engage --bogus
for option in '--rate 0' '--rate nan' '--seconds -3'; do
  # shellcheck disable=SC2086
  says 2 "${option% *}" "$hapticctl" watch $option
done
says 2 '--seconds' "$hapticctl" engage --seconds nan
says 2 '--cert requires --key' env HAPTIC_CERT=client.pem "$hapticctl" info
says 2 'none.toml' "$hapticctl" --config "$folder/none.toml" info
printf 'json = true\n\nservr = "unix:/x"\n' >"$folder/broken.toml"
says 2 'broken.toml:3: no option of hapticctl: servr' \
  "$hapticctl" --config "$folder/broken.toml" info
printf '\357\273\277server = "unix:/marked"\n' >"$folder/marked.toml"
says 3 'no hapticd answers at unix:/marked' "$hapticctl" --config "$folder/marked.toml" info
printf '\377\376s\0' >"$folder/wide.toml"
says 2 'wide.toml:1: is UTF-16, must be UTF-8' "$hapticctl" --config "$folder/wide.toml" info
says 2 "'EMERGENCY' must be a number from 1 to 31 or one of DEVICE_SILENT, DEVICE_LOST, " \
  "$hapticctl" clear-fault EMERGENCY
printf '[watch]\nrate = "fast"\n' >"$folder/broken.toml"
says 2 'broken.toml:2: --rate: must be a number' "$hapticctl" --config "$folder/broken.toml" info

# The command line wins over the environment, that over the configuration file.
export XDG_CONFIG_HOME="$folder" HOME="$folder"
echo 'server = "unix:/of-file"' >"$folder/hapticctl.toml"
ctl 3 "no hapticd answers at unix:$folder/s" info
says 3 'no hapticd answers at unix:/of-file' "$hapticctl" info
says 3 'no hapticd answers at unix:/of-environment' \
  env HAPTIC_SERVER=unix:/of-environment "$hapticctl" info
says 3 'no hapticd answers at unix:/of-command' \
  env HAPTIC_SERVER=unix:/of-environment "$hapticctl" --server unix:/of-command info

# With a server: an address in use, a device that is not there, one in FAULT; JSON from each
# command.
"$hapticd" --scene "$scene" --listen "unix:$folder/s" --realtime=off --log-level error 2>/dev/null \
  --set loop.late_bucket_full=1000000 --set 'loop.loop_late_fault={seconds: 10}' &
server=$!
tries=0
until [ -S "$folder/s" ] || [ "$tries" -ge 100 ]; do tries=$((tries + 1)); sleep 0.1; done
says 1 "hapticd: listen address 'unix:$folder/s': in use by another process; choose another one: \
--listen, or --set a field of server" "$hapticd" --scene "$scene" --listen "unix:$folder/s"
[ "$(echo "$output" | wc -l)" -eq 1 ] || says none 'an address in use is said first' true
ctl 4 'must be one of finger' --device thumb info
ctl 0 'finger' info
ctl 0 '"state":"' engage --json --seconds 0.2
ctl 0 '"sessions": []' link --json
ctl 0 '{"locally":true,"stopped":["finger"]}' estop --json
ctl 5 'EMERGENCY_STOP' engage
ctl 0 '{"cleared":["EMERGENCY_STOP"]}' clear-fault emergency_stop --json
kill -TERM "$server"
wait "$server" || { echo "FAILED: hapticd ended with status $?"; failures=$((failures + 1)); }

[ "$failures" -eq 0 ] && echo "every mistake was named"
exit "$failures"
