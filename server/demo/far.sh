# shellcheck shell=bash disable=SC2154  # part of demo.sh, which sets the variables
# --delay: a second finger whose simulation is a round trip away.
# Its own hapticd on this host; the relay is on another address of the loopback, same ports.
port=$((12000 + $$ % 8000 * 2))
half=$((delay / 2)).$((delay % 2 * 5))
echo "what: \"a round trip of $delay ms\" duration_s: 1000000" \
  "up { delay_ms: $half } down { delay_ms: $half }" >"$folder/delay.textproto"
"$hapticd" --scene "$scene" --listen "127.0.0.1:$port" "${settings[@]}" \
  --set "record.file=\"$output/recording-delayed.csv\"" \
  --set "server.udp_listen=\"127.0.0.1:$((port + 1))\"" 2>"$folder/far_hapticd.log" &
running[far_hapticd]=$!
"$relay" --scenario "$folder/delay.textproto" --tcp "$port" --udp "$((port + 1))" \
  >"$folder/relay.log" 2>&1 &
running[relay]=$!
for _ in {1..100}; do
  (: >"/dev/tcp/127.0.0.1/$port") 2>/dev/null && break
  alive far_hapticd || give_up "the second hapticd did not start" "$folder/far_hapticd.log"
  sleep 0.1
done
"${grasp[@]}" --server "127.0.0.2:$port" >"$folder/far_grasp.log" 2>&1 &
running[far_grasp]=$!
