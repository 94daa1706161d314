#!/bin/sh
# hapticd and hapticctl with TLS and client certificates, made by openssl on the spot; what is
# refused without; what a log must not hold.
#
#   tls_test.sh HAPTICD HAPTICCTL SCENE
set -u
hapticd=$1 hapticctl=$2 scene=$3
folder=$(mktemp -d)
server=
end() {
  [ -z "$server" ] || kill -TERM "$server" 2>/dev/null
  rm -rf "$folder"
}
trap end EXIT
failures=0
fail() {
  echo "FAILED: $*"
  failures=$((failures + 1))
}
command -v openssl >/dev/null || { echo "openssl is needed (docker/install-deps.sh)"; exit 1; }

# says STATUS TEXT COMMAND...: it ends with STATUS and its words contain TEXT.
says() {
  expected=$1 text=$2
  shift 2
  output=$(timeout 60 "$@" 2>&1 </dev/null)
  status=$?
  if [ "$status" -ne "$expected" ] || ! printf '%s' "$output" | grep -qF -- "$text"; then
    fail "$* (status $status, expected $expected and '$text'):"
    echo "$output" | sed 's/^/    /'
  fi
}

key='-newkey ec -pkeyopt ec_paramgen_curve:prime256v1 -nodes'
cd "$folder" || exit 1
# shellcheck disable=SC2086
{
  openssl req -x509 $key -keyout ca.key -out ca.pem -subj /CN=issuer -days 2
  openssl req -x509 -newkey rsa:1024 -nodes -keyout weak.key -out weak.pem -subj /CN=weak
  for who in localhost surgeon; do
    openssl req $key -keyout $who.key -out $who.csr -subj /CN=$who
    echo "subjectAltName=DNS:$who" >$who.ext
    openssl x509 -req -in $who.csr -CA ca.pem -CAkey ca.key -CAcreateserial -days 2 \
      -extfile $who.ext -out $who.pem
  done
} >/dev/null 2>&1 || exit 1
tls="server.tls={certificate: \"$folder/localhost.pem\" key: \"$folder/localhost.key\""
tls="$tls client_ca: \"$folder/ca.pem\""
tls="$tls client { name: \"surgeon\" highest_priority: \"operator\" }}"

# Refusals, and their words.
says 1 'is not loopback' "$hapticd" --scene "$scene" --listen 0.0.0.0:0
says 1 '--insecure-lab' "$hapticd" --scene "$scene" --listen 0.0.0.0:0
says 1 "UDP address" "$hapticd" --scene "$scene" --listen "unix:$folder/u" --insecure-lab \
  --set 'server.udp_listen="robot:0"'
says 2 'must be a PEM file' "$hapticd" --scene "$scene" --check-scene \
  --set 'server.tls={certificate: "none.pem" key: "none.key"}'
says 2 'server.tls.certificate' "$hapticd" --scene "$scene" --check-scene --set 'server.tls={}'
key_pair="certificate: \"$folder/ca.pem\" key: \"$folder/ca.key\""
says 2 'needs server.tls.client_ca' "$hapticd" --scene "$scene" --check-scene --set \
  "server.tls={$key_pair client { name: \"a\" highest_priority: \"test\" }}"
says 2 'must be "test", "primary" or "operator"' "$hapticd" --scene "$scene" --check-scene --set \
  "server.tls={$key_pair client_ca: \"$folder/ca.pem\"
               client { name: \"a\" highest_priority: \"king\" }}"
says 1 'must be that of the certificate' "$hapticd" --scene "$scene" --check-scene --set \
  "server.tls={certificate: \"$folder/localhost.pem\" key: \"$folder/ca.key\"}"
says 1 'OpenSSL refuses it: ee key too small' "$hapticd" --scene "$scene" --check-scene --set \
  "server.tls={certificate: \"$folder/weak.pem\" key: \"$folder/weak.key\"}"
says 0 'ok' "$hapticd" --scene "$scene" --check-scene --set "$tls"
says 0 ' days: give a new one' "$hapticd" --scene "$scene" --check-scene --set "$tls"

"$hapticd" --scene "$scene" --listen 127.0.0.1:0 --listen "unix:$folder/s" --set "$tls" \
  --set 'server.udp_listen="127.0.0.1:0"' --set loop.late_bucket_full=1000000 \
  --set 'loop.loop_late_fault={seconds: 5}' --realtime=off --log-level debug 2>log &
server=$!
tries=0
until grep -q 'serving .* on 127.0.0.1' log || [ "$tries" -ge 300 ]; do
  tries=$((tries + 1))
  sleep 0.1
done
address=$(sed -n 's/.* on \(127\.0\.0\.1:[0-9]*\) .*/\1/p' log | head -1)
[ -n "$address" ] || fail "no address in the log: $(cat log)"
grep -q 'TLS, clients by certificate' log || fail "the log does not say what protects $address"

says 3 'no hapticd answers' "$hapticctl" --server "$address" info
says 3 'no hapticd answers' "$hapticctl" --server "$address" --ca ca.pem --server-name localhost \
  info
says 2 '--key' "$hapticctl" --cert surgeon.pem info
says 2 'must be a PEM file of at most 1 MB' "$hapticctl" --server "$address" --ca none.pem info
set -- --server "$address" --ca ca.pem --cert surgeon.pem --key surgeon.key --server-name localhost
says 0 'hapticd' "$hapticctl" "$@" info
says 0 'hapticd' "$hapticctl" --server "unix:$folder/s" info

# A controller for a while, and what its link is doing. It comes by a name, which gRPC's resolver
# finds, the certificate holds and the UDP path uses.
timeout 60 "$hapticctl" --server "dns:///localhost:${address##*:}" --ca ca.pem --cert surgeon.pem \
  --key surgeon.key engage --priority operator --seconds 20 >engage.log 2>&1 &
engaged=$!
tries=0
until "$hapticctl" "$@" link --json | grep -q '"samples_by": "UDP"' || [ "$tries" -ge 100 ]; do
  tries=$((tries + 1))
  sleep 0.1
done
says 0 '"samples_by": "UDP"' "$hapticctl" "$@" link --json
says 0 '"holds_lease": true' "$hapticctl" "$@" link --json
says 0 "'hapticctl engage', controller" "$hapticctl" "$@" link
says 0 'clock offset' "$hapticctl" "$@" link
kill -INT "$engaged" 2>/dev/null
wait "$engaged"

kill -TERM "$server"
wait "$server" || fail "hapticd ended with status $?"
server=
grep -q "certificate of 'surgeon'" log || fail "the log does not name the certificate"
# No line of a key or of a certificate, no session's secret name.
for secret in localhost.key surgeon.key localhost.pem; do
  while IFS= read -r line; do
    case "$line" in -----* | '') continue ;; esac
    ! grep -qF -- "$line" log || fail "the log holds a line of $secret"
  done <"$secret"
done
! grep -qE '(^|[^0-9a-f])[0-9a-f]{32}([^0-9a-f]|$)' log || fail "the log holds a session's name"

[ "$failures" -eq 0 ] && echo "TLS: served, refused and said as promised"
exit "$failures"
