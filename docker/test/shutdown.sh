# `docker stop` under load: orderly, in time, without force (sourced by docker/test.sh).

test_shutdown() {
  local id before took status
  id=$(container hand)
  pressing "before the stop"
  mark
  before=$(date +%s%N)
  "$engine" stop --time 10 "$id" >/dev/null
  took=$((($(date +%s%N) - before) / 1000000))
  status=$("$engine" inspect --format '{{.State.ExitCode}}' "$id")
  [[ $status == 0 ]] || fail "the server ended with $status"
  ((took <= 5000)) || fail "the server took $took ms to end"
  "$engine" logs "$id" 2>&1 | tail -n 1 | grep -q 'stopped' || fail "the server's last word is not 'stopped'"
  # RELEASING is left at g = 0 and not before.
  "$engine" logs "$id" 2>&1 | grep -q 'RELEASING -> CLOSING' || fail "the server closed before the force was gone"
  step "SIGTERM under load: status 0 after $took ms"
  judge "SIGTERM under load" closing "$since"

  id=$(container board)
  "$engine" stop --time 10 "$id" >/dev/null
  status=$("$engine" inspect --format '{{.State.ExitCode}}' "$id")
  [[ $status == 0 ]] || fail "the server with the board ended with $status"
}
