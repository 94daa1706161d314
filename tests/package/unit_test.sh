#!/bin/sh
# The systemd unit as installed: systemd finds no fault with it, and it has the lines that the pages
# promise. 77: systemd-analyze is not there.
#
#   unit_test.sh BUILD FOLDER
set -eu
command -v systemd-analyze >/dev/null || { echo "skipped: no systemd-analyze"; exit 77; }
. "$(dirname "$0")/../support/scratch.sh"
fresh_folder "$2"
cmake --install "$1" --prefix "$2" --component server >/dev/null
unit=$2/lib/systemd/system/hapticd.service
complaints=$(systemd-analyze verify --man=no "$unit" 2>&1 || true)
if [ -n "$complaints" ]; then
  echo "$complaints" >&2
  exit 1
fi
for line in "Documentation=man:hapticd(8) man:hapticctl(1)" Type=notify NotifyAccess=main \
  'SupplementaryGroups=dialout haptic' KillMode=mixed \
  'ExecReload=/bin/kill -HUP $MAINPID' User=hapticd \
  WatchdogSec=2s LimitRTPRIO=95 LimitMEMLOCK=infinity \
  "ExecStart=$2/bin/hapticd --scene $2/etc/hapticd/scene.textproto"; do
  grep -qxF "$line" "$unit" || { echo "unit_test.sh: no line '$line'" >&2; exit 1; }
done
# The scene that it serves is there and valid.
"$2/bin/hapticd" --scene "$2/etc/hapticd/scene.textproto" --check-scene
