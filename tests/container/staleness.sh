# The staleness contract from outside: whatever happens to the client, an observer sees zero force
# within 200 ms, and force come back by a ramp (sourced by docker/test.sh).

# Judges what came since the mark. The whole log grows by 250 lines a second, and reading it would
# load the machine.
marked=
mark() { marked=$(date -u +%Y-%m-%dT%H:%M:%S.%NZ); }
observed() { # observed COMMAND [ARGUMENT]
  "$engine" logs ${marked:+--since "$marked"} "$(container observer)" 2>/dev/null \
    >"$scratch/records"
  python3 "$root/tests/container/contract.py" "$1" "$scratch/records" "${@:2}"
}
judge() { # judge WHAT COMMAND [ARGUMENT...]: printed, or the end
  local what=$1
  shift
  observed "$@" >"$scratch/verdict" 2>&1 || fail "$what: $(cat "$scratch/verdict")"
  step "$what: $(cat "$scratch/verdict")"
}
pressing() {
  eventually 120 is_pressing || fail "$1: force did not come back: $(tail -n 1 "$scratch/last")"
}
# A simulation that finds no server ends with an error. It is started again, as a person would.
is_pressing() {
  local id
  id=$(container simulation)
  if [[ $("$engine" inspect --format '{{.State.Status}}' "$id") == exited ]]; then
    "$engine" start "$id" >/dev/null
  fi
  "$engine" logs --tail 3 "$(container observer)" 2>/dev/null >"$scratch/tail"
  python3 "$root/tests/container/contract.py" pressing "$scratch/tail"
}

simulate() { # simulate [SERVER [CARRIERS]]: a simulation in the place of any other
  local id
  id=$(container simulation)
  if [[ -n $id ]]; then
    "$engine" logs "$id" >>"$logs/simulation.log" 2>&1 || true
    "$engine" unpause "$id" >/dev/null 2>&1 || true
    "$engine" rm --force "$id" >>"$logs/engine.log" 2>&1
  fi
  HAPTICD_SERVER=${1:-hand:29470} HAPTICD_CARRIERS=${2:-auto} compose up --detach --no-build \
    --no-deps simulation >>"$logs/compose.log" 2>&1
}

# Force comes back by itself if the client is heard again before its lease ends (2 s of silence). If
# this machine is so slow that the lease has ended, a new client asks for force.
comes_back() { # comes_back WHAT
  if eventually 20 is_pressing 2>/dev/null; then return 0; fi
  step "$1: its lease had ended, another client takes over"
  simulate
  pressing "$1"
}

# Makes trouble, and judges what the observer saw. If this machine was too busy for the observer to
# see the loss of force, the text says so.
silences() { # silences WHAT TROUBLE RECOVERY
  local status=0
  pressing "before: $1"
  mark
  "$2" >>"$logs/engine.log" 2>&1 || fail "$1: $(tail -n 1 "$logs/engine.log")"
  eventually 120 observed quiet 1 || fail "$1: the proxy was not lost: $(tail -n 1 "$scratch/last")"
  observed silence >"$scratch/verdict" 2>&1 || status=$?
  if ((status == 1)); then fail "$1: $(cat "$scratch/verdict")"; fi
  step "$1: $(cat "$scratch/verdict")"
  "$3" "$1"
}

kill_client() { "$engine" kill --signal KILL "$(container simulation)"; }
replace_client() {
  simulate # while the server runs
  pressing "client replaced"
  step "client replaced: force is back"
}
pause_client() { "$engine" pause "$(container simulation)"; }
resume_client() {
  "$engine" unpause "$(container simulation)" >/dev/null
  comes_back "client resumed"
  judge "client resumed" ramp
}
laboratory() { "$engine" network ls --format '{{.Name}}' --filter "name=^${project}_"; }
disconnect_client() {
  "$engine" network disconnect --force "$(laboratory)" "$(container simulation)"
}
reconnect_client() {
  "$engine" network connect "$(laboratory)" "$(container simulation)" >/dev/null
  comes_back "network reconnected"
  judge "network reconnected" ramp
}

# With the stream as the only carrier, so that the force can have come by nothing else.
test_stream() {
  simulate hand:29470 grpc
  pressing "soft grasp over gRPC"
  mark
  eventually 120 observed only GRPC || fail "soft grasp over gRPC: $(cat "$scratch/last")"
  judge "soft grasp over gRPC" only GRPC
  simulate
  pressing "soft grasp over any carrier"
  mark
}

test_staleness() {
  eventually 120 observed transport UDP || fail "soft grasp: no force by UDP"
  judge "soft grasp over UDP" transport UDP
  silences "client killed" kill_client replace_client
  silences "client paused" pause_client resume_client
  silences "network disconnected" disconnect_client reconnect_client
}
