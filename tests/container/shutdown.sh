# `docker stop` under load: an orderly end, in time, without force (sourced by docker/test.sh).

test_shutdown() {
  local id took status began last
  id=$(container hand)
  pressing "before the stop"
  mark
  "$engine" stop --time 60 "$id" >/dev/null
  status=$("$engine" inspect --format '{{.State.ExitCode}}' "$id")
  [[ $status == 0 ]] || fail "the server ended with $status"
  "$engine" logs "$id" >"$scratch/words" 2>&1
  began=$(grep 'SIGTERM: ' "$scratch/words" | tail -n 1)
  last=$(tail -n 1 "$scratch/words")
  [[ -n $began && $last == *stopped* ]] ||
    fail "the server's last lines do not show an orderly end"
  took=$(($(date -d "${last%% *}" +%s%3N) - $(date -d "${began%% *}" +%s%3N)))
  ((took <= 5000)) || fail "the server took $took ms to end"
  # The device leaves RELEASING when g = 0, not before.
  grep -q 'RELEASING -> CLOSING' "$scratch/words" ||
    fail "the server closed before the force was gone"
  step "SIGTERM under load: status 0 after $took ms"
  fades_out

  id=$(container board)
  "$engine" stop --time 60 "$id" >/dev/null
  status=$("$engine" inspect --format '{{.State.ExitCode}}' "$id")
  [[ $status == 0 ]] || fail "the server with the board ended with $status"
}

# If the observer lost its stream before the end, the server's log alone shows that g was 0.
fades_out() {
  local status=0
  observed closing >"$scratch/verdict" 2>&1 || status=$?
  if ((status == 1)); then fail "SIGTERM under load: $(cat "$scratch/verdict")"; fi
  step "SIGTERM under load: $(cat "$scratch/verdict")"
}
