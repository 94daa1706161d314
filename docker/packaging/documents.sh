#!/bin/sh
# Makes man pages and bash completions of installed programs from what their --help prints; part of
# `cmake --install`. Needs help2man; without it there are completions only, and a message.
#
#   documents.sh VERSION BIN SHARE PROGRAM...
#
# Writes SHARE/man/man[18]/*.gz (hapticd is in section 8; each subcommand has a page of its own,
# such as hapticctl-watch) and SHARE/bash-completion/completions/PROGRAM.
set -eu
version=$1 bin=$2 share=$3
shift 3
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

subcommands() { # subcommands PROGRAM
  "$bin/$1" --help | sed -n '/^Subcommands:/,/^$/s/^  \([a-z][a-z-]*\) .*/\1/p'
}

# options HELP-TEXT all|valued: the long options in it; only those that take a value
options() {
  printf '%s\n' "$1" | awk -v which="$2" '/^  -/ {
    count = split($1, names, ",")
    if (which == "valued" && $2 !~ /^[A-Z]+([:=]|$)/) next
    if (names[count] ~ /^--/) print names[count]
  }' | paste -s -d ' '
}

# page NAME SECTION: the man page of $folder/NAME, which is the program or runs a subcommand of it
page() {
  what=$("$folder/$1" --help | sed -n '1s/^[a-z-]* - //p;1q')
  [ -n "$what" ] || what=$("$folder/$1" --help | sed -n 1p)
  mkdir -p "$share/man/man$2"
  help2man --no-info --section="$2" --name="$what" --source="hapticd $version" \
    --version-string="$version" "$folder/$1" >"$folder/page"
  gzip -9nc "$folder/page" >"$share/man/man$2/$1.$2.gz"
}

completion() { # completion PROGRAM
  function=_$(echo "$1" | tr - _)
  help=$("$bin/$1" --help)
  commands=$(subcommands "$1" | paste -s -d ' ')
  valued=$(options "$help" valued)
  common=$(options "$help" all)
  echo "# bash completion of $1, made from its --help."
  echo "$function() {"
  echo '  local word=${COMP_WORDS[COMP_CWORD]} command= words= i'
  echo "  for ((i = 1; i < COMP_CWORD; ++i)); do"
  echo "    [[ \" $commands \" == *\" \${COMP_WORDS[i]} \"* ]] && command=\${COMP_WORDS[i]}"
  echo "  done"
  echo '  case $command in'
  echo "    '') words='$common $commands' ;;"
  for command in $commands; do
    help=$("$bin/$1" "$command" --help)
    valued="$valued $(options "$help" valued)"
    echo "    $command) words='$(options "$help" all) $common' ;;"
  done
  echo '  esac'
  echo '  # After an option with a value: nothing here, so that bash offers files.'
  echo "  [[ \" $valued \" == *\" \${COMP_WORDS[COMP_CWORD - 1]} \"* ]] && return"
  echo '  mapfile -t COMPREPLY < <(compgen -W "$words" -- "$word")'
  echo "}"
  echo "complete -o default -F $function $1"
}

mkdir -p "$share/bash-completion/completions"
for program in "$@"; do
  completion "$program" >"$share/bash-completion/completions/$program"
done
command -v help2man >/dev/null || { echo "documents.sh: no help2man, so no man pages"; exit 0; }
for program in "$@"; do
  section=1
  [ "$program" != hapticd ] || section=8
  # With the name alone: help2man writes down how it was called.
  ln -s "$(realpath "$bin/$program")" "$folder/$program"
  page "$program" "$section"
  for command in $(subcommands "$program"); do
    printf '#!/bin/sh\nexec "%s" %s "$@"\n' "$folder/$program" "$command" \
      >"$folder/$program-$command"
    chmod +x "$folder/$program-$command"
    page "$program-$command" "$section"
  done
done
