# hapticd behind haproxy as composed (sourced by docker/test.sh). docker/haproxy/test.sh has the
# attacks; this shows that the containers work together.
# shellcheck source=/dev/null
. "$root/docker/haproxy/laboratory.sh"

test_haproxy() {
  local began=$SECONDS
  export HAPTICD_IMAGE=$image HAPTICD_BASE=$base HAPTICD_TLS=$scratch/tls DOOR=127.0.0.1:
  mkdir "$HAPTICD_TLS"
  (cd "$HAPTICD_TLS" && make_laboratory 0.0.0.0:29470)
  chown -R 990:990 "$HAPTICD_TLS"
  chmod a+x "$scratch"
  compose_door build door >>"$logs/build.log" 2>&1 ||
    fail "haproxy's image does not build; see $logs/build.log"
  compose_door up --detach --no-build hapticd door >"$logs/door.log" 2>&1 ||
    fail "the composition with haproxy does not start; see $logs/door.log"
  eventually 30 through_door surgeon door info ||
    fail "no answer through haproxy: $(cat "$scratch/last")"
  grep -q finger "$scratch/last" || fail "the answer through haproxy names no device"
  if through_door thief door info >"$scratch/thief" 2>&1; then
    fail "a stranger's certificate passed haproxy and hapticd"
  fi
  if through_door surgeon hapticd info >"$scratch/around" 2>&1; then
    fail "hapticd can be reached without haproxy"
  fi
  step "haproxy: the laboratory's client passes, a stranger does not, in $((SECONDS - began)) s"
}

compose_door() {
  local program=podman-compose
  if [[ $engine == docker ]]; then program="docker compose"; fi
  $program -p "$project" -f "$root/docker/haproxy/compose.yaml" "$@"
}

through_door() { # through_door CERTIFICATE HOST WORDS...: hapticctl on the network outside
  local name=$1 host=$2
  shift 2
  "$engine" run --rm --label "com.docker.compose.project=$project" \
    --network "${project}_outside" --volume "$HAPTICD_TLS:/tls:ro" "$image" \
    hapticctl --server "$host:29470" --ca /tls/laboratory.pem --server-name localhost \
    --cert "/tls/$name.pem" --key "/tls/$name.key" "$@"
}
