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

# Four seconds without a loss of force. A stall of this machine looks like one: there are five windows, and where
# a witness on this machine overslept in every one of them, it cannot be told here.
steady() { # steady WHAT
  local window before stalls=0
  for window in 1 2 3 4 5; do
    pressing "$1"
    mark
    before=$(wc -l <"$scratch/stalls")
    eventually 120 observed spans 4 || fail "$1: the observer is blind"
    if observed never-lost 2>"$scratch/verdict"; then
      step "$1: force stays (window $window)"
      return 0
    fi
    if (($(wc -l <"$scratch/stalls") > before)); then stalls=$((stalls + 1)); fi
    step "$1: $(cat "$scratch/verdict") (window $window, $(tail -n +$((before + 1)) "$scratch/stalls" | wc -l) stalls)"
  done
  ((stalls == window)) || fail "$1: force does not stay"
  step "$1: not resolvable here: this machine stalled in every window"
}

watch_machine() {
  python3 "$root/docker/test/witness.py" "$scratch/stalls" &
  witness=$!
  eventually 60 test -e "$scratch/stalls"
}
forget_machine() {
  if [[ -z ${witness:-} ]]; then return 0; fi
  kill "$witness" 2>/dev/null || true
  wait "$witness" 2>/dev/null || true
  witness=
}

test_relay() {
  watch_machine
  through_relay delay_30ms
  steady "30 ms of delay"
  through_relay loss_10
  eventually 120 observed transport UDP || fail "10 % of loss: $(cat "$scratch/last")"
  judge "10 % of loss" transport UDP
  steady "10 % of loss"
  forget_machine
  simulate
  pressing "without the relay"
}
