#!/bin/sh
# Runs a test in a browser, which is Debian's chromium (docker/install-deps.sh browser), or the one
# that $CHROMIUM names. Ends with 77, and says why, if it cannot.
#
#   run.sh MODULES TEST       MODULES: a folder for playwright-core and axe-core, which npm fetches
set -eu
here=$(cd "$(dirname "$0")" && pwd)
modules=$1
test=$2

skip() {
  echo "skipped: $*" >&2
  exit 77
}

CHROMIUM=${CHROMIUM:-$(command -v chromium || command -v chromium-browser || true)}
[ -n "$CHROMIUM" ] || skip "there is no chromium (docker/install-deps.sh browser)"
mkdir -p "$modules"
for file in package.json package-lock.json; do
  cmp -s "$here/$file" "$modules/$file" || rm -rf "$modules/node_modules"
  cp "$here/$file" "$modules/"
done
if [ ! -e "$modules/node_modules/.package-lock.json" ]; then
  npm ci --prefix "$modules" --prefer-offline --ignore-scripts --no-audit --no-fund \
    --loglevel=error --fetch-retries=1 || skip "npm could not fetch playwright-core and axe-core"
fi
export CHROMIUM HAPTIC_PAGE_MODULES="$modules"
exec "${NODE:-node}" --test --test-reporter=spec "$here/$test"
