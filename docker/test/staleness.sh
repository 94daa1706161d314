# The staleness contract from outside: whatever happens to the client, an observer sees the force at zero
# within 200 ms, and back by a ramp (sourced by docker/test.sh).

records() { "$engine" logs "$(container observer)" 2>/dev/null >"$scratch/records"; }
mark() { # from here on
  records
  since=$(grep -c '^{.*}$' "$scratch/records" || true)
}
observed() { # observed COMMAND [NAME] [FROM]
  records
  python3 "$root/docker/test/contract.py" "$1" "$scratch/records" "${@:2}"
}
judge() { # judge WHAT COMMAND [ARGUMENT...]: printed, or the end
  local what=$1
  shift
  observed "$@" >"$scratch/verdict" 2>&1 || fail "$what: $(cat "$scratch/verdict")"
  step "$what: $(cat "$scratch/verdict")"
}
pressing() { eventually 60 is_pressing || fail "$1: force did not come back: $(tail -n 1 "$scratch/last")"; }
# A simulation that found no server at its start says so and ends: it is started again, as a person would.
is_pressing() {
  local id
  id=$(container simulation)
  if [[ $("$engine" inspect --format '{{.State.Status}}' "$id") == exited ]]; then
    "$engine" start "$id" >/dev/null
  fi
  "$engine" logs --tail 3 "$(container observer)" 2>/dev/null >"$scratch/tail"
  python3 "$root/docker/test/contract.py" pressing "$scratch/tail"
}

simulate() { # simulate [SERVER]: a simulation in the place of any other
  local id
  id=$(container simulation)
  if [[ -n $id ]]; then
    "$engine" logs "$id" >>"$logs/simulation.log" 2>&1 || true
    "$engine" unpause "$id" >/dev/null 2>&1 || true
    "$engine" rm --force "$id" >/dev/null
  fi
  HAPTICD_SERVER=${1:-hand:50051} compose up --detach --no-build --no-deps simulation >>"$logs/compose.log" 2>&1
}

# The force of a client that is heard again comes back by itself while its lease lasts (2 s of silence). On a slow
# machine the trouble may have outlasted that: then it takes a client that asks anew.
comes_back() { # comes_back WHAT
  if eventually 15 is_pressing 2>/dev/null; then return 0; fi
  step "$1: its lease had ended, another client takes over"
  simulate
  pressing "$1"
}

test_staleness() {
  judge "soft grasp over UDP" transport UDP 0
  mark
  "$engine" kill --signal KILL "$(container simulation)" >/dev/null
  sleep 1.5
  judge "client killed" silence "$since"

  mark
  simulate # while the server runs
  pressing "client replaced"
  step "client replaced: force is back"

  mark
  "$engine" pause "$(container simulation)" >/dev/null
  sleep 1.5
  judge "client paused" silence "$since"
  "$engine" unpause "$(container simulation)" >/dev/null
  comes_back "client resumed"
  judge "client resumed" ramp "$since"

  local network
  network=$("$engine" network ls --format '{{.Name}}' --filter "name=^${project}_")
  mark
  "$engine" network disconnect --force "$network" "$(container simulation)" >/dev/null
  sleep 1.5
  judge "network disconnected" silence "$since"
  "$engine" network connect "$network" "$(container simulation)" >/dev/null
  comes_back "network reconnected"
  judge "network reconnected" ramp "$since"
}
