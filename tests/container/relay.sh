# Delay and loss on the way between simulation and server (sourced by docker/test.sh).

through_relay() { # through_relay SCENARIO
  local id
  id=$(container relay)
  if [[ -n $id ]]; then "$engine" rm --force "$id" >>"$logs/engine.log" 2>&1; fi
  HAPTICD_TROUBLE=$1 compose up --detach --no-build --no-deps relay >>"$logs/compose.log" 2>&1
  eventually 120 "$engine" exec "$(container relay)" true || fail "the relay did not start"
  mark
  simulate relay:29470
  pressing "$1"
}

# Four seconds of pressing, judged by what must never happen. On a busy machine force may be lost
# meanwhile; the text says how often.
bears() { # bears WHAT
  pressing "$1"
  mark
  eventually 120 observed spans 4 || fail "$1: the observer is blind"
  judge "$1" safe
}

test_relay() {
  through_relay delay_30ms
  bears "30 ms of delay"
  through_relay loss_10
  eventually 120 observed transport UDP || fail "10 % of loss: $(cat "$scratch/last")"
  judge "10 % of loss" transport UDP
  bears "10 % of loss"
  simulate
  pressing "without the relay"
}
