#!/bin/sh
# hapticd's ports are written once per language: ports.hpp for C++, _ports.py for Python. This check
# compares the two, keeps them below Linux's ephemeral range and out of /etc/services, and fails on
# a copy in the sources of the product and on another port in a page, a scene or a container file.
#
#   ports.sh [ROOT]
set -u
root=$(cd "${1:-$(dirname "$0")/../..}" && pwd)
. "$(dirname "$0")/files.sh"
cd "$root" || exit 2
header=proto/wire/include/haptic/wire/ports.hpp
python=client/python/haptic/_ports.py
status=0

complain() {
  echo "$*"
  status=1
}

numbers=$(sed -nE 's/.* k[A-Za-z]+Port = ([0-9]+);.*/\1/p' "$header")
[ -n "$numbers" ] || { echo "$header: no port found"; exit 2; }
server=127.0.0.1:$(sed -nE 's/.* kGrpcPort = ([0-9]+);.*/\1/p' "$header")
grep -qF "kDefaultServer = \"$server\"" "$header" ||
  complain "$header: kDefaultServer is not $server"
grep -qF "DEFAULT_SERVER = \"$server\"" "$python" ||
  complain "$python: DEFAULT_SERVER is not $server"
one_of=$(echo "$numbers" | paste -s -d '|')
for number in $numbers; do
  [ "$number" -lt 32768 ] || complain "$number: within the ephemeral range, which begins at 32768"
  if grep -sE "[[:space:]]$number/(tcp|udp)" /etc/services; then complain "$number: is assigned"; fi
done

host='([0-9]+(\.[0-9]+){3}|localhost|\[::1?\]|robot|hand|relay)'
for file in $(files_of "$root" | grep -v -e '^tests/checks/' -e '^CHANGELOG.md$'); do
  case "$file" in
    "$header" | "$python") continue ;;
    tests/*.md | docker/* | *.textproto | *.md | *.proto)
      wrong=$(grep -nE "$host:[0-9]{4,5}|(^|[^0-9])5005[0-9]([^0-9]|\$)" "$file" |
        grep -vE ":($one_of)([^0-9]|\$)") ;;
    tests/*) wrong=$(grep -nE '(^|[^0-9])5005[0-9]([^0-9]|$)' "$file") ;;
    *.cpp | *.hpp | *.py | *.sh)
      wrong=$(grep -nE "(^|[^0-9])($one_of|5005[0-9])([^0-9]|\$)" "$file") ;;
    *) continue ;;
  esac
  if [ -n "$wrong" ]; then
    complain "$file: a port that $header does not say, or a copy of one:"
    echo "$wrong"
  fi
done
[ "$status" -ne 0 ] || echo "ports: $(echo "$numbers" | paste -s -d ' ')"
exit $status
