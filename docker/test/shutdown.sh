# `docker stop` under load: orderly, in time, without force (sourced by docker/test.sh).

test_shutdown() {
  local id took status
  id=$(container hand)
  pressing "before the stop"
  mark
  "$engine" stop --time 60 "$id" >/dev/null
  status=$("$engine" inspect --format '{{.State.ExitCode}}' "$id")
  [[ $status == 0 ]] || fail "the server ended with $status"
  "$engine" logs "$id" >"$scratch/words" 2>&1
  took=$(python3 "$root/docker/test/log_span.py" "$scratch/words" "SIGTERM: " "stopped") ||
    fail "the server's last words are not those of an orderly end"
  ((took <= 5000)) || fail "the server took $took ms to end"
  # RELEASING is left at g = 0 and not before.
  grep -q 'RELEASING -> CLOSING' "$scratch/words" || fail "the server closed before the force was gone"
  step "SIGTERM under load: status 0 after $took ms"
  fades_out

  id=$(container board)
  "$engine" stop --time 60 "$id" >/dev/null
  status=$("$engine" inspect --format '{{.State.ExitCode}}' "$id")
  [[ $status == 0 ]] || fail "the server with the board ended with $status"
}

# Where the observer had gone blind before the end, the server's own word for g = 0 stands alone.
fades_out() {
  local status=0
  observed closing >"$scratch/verdict" 2>&1 || status=$?
  if ((status == 1)); then fail "SIGTERM under load: $(cat "$scratch/verdict")"; fi
  step "SIGTERM under load: $(cat "$scratch/verdict")"
}
