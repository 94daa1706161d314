#!/bin/sh
# The project runs anywhere: no file of it names a machine's folder, a fixed temporary folder (tests
# may: a socket's path must be short), or a host that is not one of those below.
#
#   no_machine_names.sh [ROOT]
set -u
root=$(cd "${1:-$(dirname "$0")/../..}" && pwd)
. "$(dirname "$0")/files.sh"
cd "$root" || exit 2

hosts='([a-z0-9-]+\.)*example|host|name|x|localhost|127\.0\.0\.1|(www\.)?(github\.com|doi\.org|apache\.org|w3\.org|keepachangelog\.com|semver\.org|connectrpc\.com|debian\.org|ietf\.org|rfc-editor\.org|opensource\.org|type\.googleapis\.com)'
status=0
checked=0
for file in $(files_of "$root" | grep -v -e '^tests/checks/' -e '^LICENSE$' -e '^proto/google/'); do
  [ -f "$file" ] || continue
  grep -qI . "$file" || continue  # binary or empty
  checked=$((checked + 1))
  folders='work|root|home'
  case "$file" in tests/*) ;; *) folders="$folders|tmp" ;; esac
  # A folder name counts at the beginning of a path, not inside a longer one.
  if grep -nE "(^|[^A-Za-z0-9_.}/-])/($folders)/" "$file" | sed "s|^|$file:|" | grep .; then
    status=1
  fi
  if grep -noE '(https?|ftp|git|ssh)://[A-Za-z0-9.-]+' "$file" |
    grep -vE "://($hosts)\$" | sed "s|^|$file:|" | grep .; then
    status=1
  fi
done
echo "$checked files checked"
[ "$checked" -gt 0 ] || exit 2
exit $status
