# Three servers and their Prometheus as composed (sourced by docker/test.sh). What the rules say is
# tested by tests/package/hosts_test.py; this shows that the containers work together.
readonly PROMETHEUS=9090

test_hosts() {
  local began=$SECONDS
  export HAPTICD_IMAGE=$image HAPTICD_BASE=$base PROMETHEUS_PORT=
  compose_hosts build prometheus >>"$logs/build.log" 2>&1 ||
    fail "Prometheus' image does not build; see $logs/build.log"
  compose_hosts up --detach --no-build >"$logs/hosts.log" 2>&1 ||
    fail "the composition of three servers does not start; see $logs/hosts.log"
  eventually 60 measures 'count(up{job="hapticd"} == 1) == 3' ||
    fail "Prometheus does not scrape three servers: $(cat "$scratch/last")"
  "$engine" exec "$(container right)" hapticctl estop >>"$logs/hosts.log"
  eventually 60 measures 'ALERTS{alertname="HapticFaultLatched", instance="right:29472"}' ||
    fail "a stop raises no alert: $(cat "$scratch/last")"
  step "hosts: Prometheus scrapes three servers and alerts for a stop, in $((SECONDS - began)) s"
}

compose_hosts() {
  local program=podman-compose
  if [[ $engine == docker ]]; then program="docker compose"; fi
  $program -p "$project" -f "$root/docker/hosts/compose.yaml" "$@"
}

measures() { # measures QUERY: has it an answer?
  "$engine" exec "$(container prometheus)" promtool query instant \
    "http://localhost:$PROMETHEUS" "$1" | tee /dev/stderr | grep -q .
}
