# Delay and loss on the way between simulation and server (sourced by docker/test.sh).

through_relay() { # through_relay SCENARIO
  local id
  id=$(container relay)
  if [[ -n $id ]]; then "$engine" rm --force "$id" >/dev/null; fi
  HAPTICD_TROUBLE=$1 compose up --detach --no-build --no-deps relay >>"$logs/compose.log" 2>&1
  eventually 20 "$engine" exec "$(container relay)" true || fail "the relay did not start"
  mark
  simulate relay:50051
  pressing "$1"
}

test_relay() {
  through_relay delay_30ms
  mark
  sleep 4
  judge "30 ms of delay: force stays" never-lost "$since"
  through_relay loss_10
  mark
  sleep 4
  judge "10 % of loss, over UDP" transport UDP "$since"
  judge "10 % of loss: force stays" never-lost "$since"
  simulate
  pressing "without the relay"
}
