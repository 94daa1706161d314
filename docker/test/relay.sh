# Delay and loss on the way between simulation and server (sourced by docker/test.sh).

through_relay() { # through_relay SCENARIO
  local id
  id=$(container relay)
  if [[ -n $id ]]; then "$engine" rm --force "$id" >>"$logs/engine.log" 2>&1; fi
  HAPTICD_TROUBLE=$1 compose up --detach --no-build --no-deps relay >>"$logs/compose.log" 2>&1
  eventually 120 "$engine" exec "$(container relay)" true || fail "the relay did not start"
  mark
  simulate relay:50051
  pressing "$1"
}

# Four seconds without a loss of force. A stall of this machine looks like one, and so there are three windows.
steady() { # steady WHAT
  local window
  for window in 1 2 3; do
    pressing "$1"
    mark
    eventually 120 observed spans 4 "$since" || fail "$1: the observer is blind"
    if observed never-lost "$since" 2>"$scratch/verdict"; then
      step "$1: force stays (window $window)"
      return 0
    fi
    step "$1: $(cat "$scratch/verdict") (window $window)"
  done
  fail "$1: force does not stay"
}

test_relay() {
  through_relay delay_30ms
  steady "30 ms of delay"
  through_relay loss_10
  eventually 120 observed transport UDP "$since" || fail "10 % of loss: $(cat "$scratch/last")"
  judge "10 % of loss" transport UDP "$since"
  steady "10 % of loss"
  simulate
  pressing "without the relay"
}
