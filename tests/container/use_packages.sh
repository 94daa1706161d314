#!/bin/sh
# Inside a clean container: installs the packages of /debs, runs the daemon as its unit would, talks
# to it with hapticctl and from Python.
set -eu
apt-get -qq -o Acquire::Retries=3 update
apt-get -qq -o Acquire::Retries=3 install -y --no-install-recommends /debs/*.deb >/dev/null
grep -qx 'ExecStart=/usr/bin/hapticd --scene /etc/hapticd/scene.textproto' \
  /usr/lib/systemd/system/hapticd.service
getent group haptic >/dev/null
grep -q '^@haptic - rtprio 95$' /etc/security/limits.d/haptic.conf
hapticd --scene /etc/hapticd/scene.textproto --set loop.late_bucket_full=1000000 &
server=$!
tries=0
until hapticctl health >/dev/null 2>&1; do
  tries=$((tries + 1))
  [ "$tries" -lt 600 ]
  sleep 0.2
done
timeout 120 python3 - <<'PYTHON'
import haptic

with haptic.Connection("127.0.0.1:29470") as server:
    with server.session(client_name="clean container", nominal_rate_hz=60) as session:
        session.engage_when_ready()
        while session.wait_for_state().state != "ENGAGED":
            session.publish(haptic.FREE)
PYTHON
kill -TERM "$server"
wait "$server"
# A purge removes the settings too.
apt-get -qq purge -y hapticd hapticd-client python3-haptic >/dev/null
[ ! -e /etc/hapticd/scene.textproto ] && [ ! -e /etc/security/limits.d/haptic.conf ]
echo "installed, engaged from Python, stopped with status 0, purged"
