#!/usr/bin/env bash
# The man pages and bash completions that an installation makes: each option that the sources of
# hapticd and hapticctl define is in both, and bash completes commands and options with them. 77: no
# help2man.
#
#   documents_test.sh SOURCE HAPTICD HAPTICCTL FOLDER
set -euo pipefail
source=$1 folder=$4
command -v help2man >/dev/null || { echo "skipped: no help2man"; exit 77; }
. "$(dirname "$0")/../support/scratch.sh"
fresh_folder "$folder"
mkdir "$folder/bin"
cp "$2" "$3" "$folder/bin/"
sh "$source/docker/packaging/documents.sh" 1.2.3 "$folder/bin" "$folder" hapticd hapticctl
fail() {
  echo "documents_test.sh: $*" >&2
  exit 1
}

completions=$folder/bash-completion/completions
defined() { grep -ohE '"--[a-z][a-z-]*"' "$@" | tr -d '"' | sort -u; } # defined FILE...
check() { # check PROGRAM SOURCE
  local option count=0
  zcat "$folder"/man/man?/"$1"*.gz | tr -d '\\' >"$folder/pages"
  for option in $(defined "$2"); do
    grep -qE -- "['\" ]$option['\" ]" "$completions/$1" ||
      fail "the completion of $1 has no $option"
    grep -qF -- "$option" "$folder/pages" || fail "no man page of $1 has $option"
    count=$((count + 1))
  done
  ((count > 8)) || fail "$2: only $count options found"
}
check hapticd "$source/server/owner/main.cpp"
check hapticctl "$source/client/hapticctl/command_line.cpp"

for command in info health watch engage link estop clear-fault restart-front doctor calibrate; do
  page=$folder/man/man1/hapticctl-$command.1.gz
  [[ -s $page ]] || fail "no man page for hapticctl $command"
done
for page in "$folder"/man/man?/*.gz; do
  zcat "$page" >"$folder/page"
  grep -q "^.SH SYNOPSIS" "$folder/page" || fail "$page has no synopsis"
  if grep -F "$folder" "$folder/page"; then fail "$page names a folder of this machine"; fi
done
[[ $(zcat "$folder/man/man1/hapticctl.1.gz") == *'device is in FAULT'* ]] ||
  fail "no table of exit status"

# completes EXPECTED WORDS...: what bash offers for the last word.
completes() {
  local expected=$1
  shift
  COMP_WORDS=("$@") COMP_CWORD=$(($# - 1)) COMPREPLY=()
  "_$1"
  [[ "${COMPREPLY[*]}" == "$expected" ]] ||
    fail "'$*' completes to '${COMPREPLY[*]}', expected '$expected'"
}
. "$completions/hapticctl"
. "$completions/hapticd"
completes "health" hapticctl he
completes "--rate" hapticctl watch --ra
completes "--json" hapticctl watch --js
completes "" hapticctl watch --rate --js
completes "--scene" hapticd --sc
complete -p hapticctl hapticd >/dev/null
echo "man pages and completions have every option"
