#!/bin/sh
# Checks the messages with buf (https://github.com/bufbuild/buf), which needs no network to run.
#
#   proto/buf.sh check [PROTO]  lints by buf.yaml, then compares with the last release,
#                               released.binpb: what breaks its clients is an error. Ends with 77
#                               if buf is not installed. PROTO: another folder than this one.
#   proto/buf.sh release        writes released.binpb from the present messages: at each release
#   proto/buf.sh install        installs buf from npm (docker/install-deps.sh node) into build/buf
#
# $BUF names another buf than the installed one.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
folder=$(dirname "$here")/build/buf
version=1.75.0

find_buf() {
  for buf in "${BUF:-}" "$(command -v buf || true)" "$folder/node_modules/.bin/buf"; do
    if [ -n "$buf" ] && [ -x "$buf" ]; then return 0; fi
  done
  echo "skipped: buf is not installed; proto/buf.sh install does it, with npm" >&2
  exit 77
}

case "${1:-}" in
  check)
    find_buf
    cd "${2:-$here}"
    "$buf" lint
    "$buf" breaking --against released.binpb
    echo "the messages pass buf lint and break no client of the last release"
    ;;
  release)
    find_buf
    cd "$here"
    "$buf" build --exclude-source-info --output released.binpb
    ;;
  install)
    if [ -x "$folder/node_modules/.bin/buf" ]; then exit 0; fi
    mkdir -p "$folder"
    npm install --prefix "$folder" --no-audit --no-fund --silent --fetch-retries=1 \
      "@bufbuild/buf@$version"
    ;;
  *)
    sed -n '2,${/^#/!q;s/^# \{0,1\}//p}' "$0"
    case "${1:-}" in -h | --help) exit 0 ;; *) exit 2 ;; esac
    ;;
esac
