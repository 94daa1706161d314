# shellcheck shell=sh
# Sourced by tests that work in a folder given to them.

# fresh_folder FOLDER: makes it anew, empty. A folder that was not made here is never removed:
# whoever gives the wrong argument loses nothing. The mark lies beside the folder, whose content is
# the test's.
fresh_folder() {
  if [ -e "$1" ] && [ ! -e "$1.scratch" ]; then
    echo "$1: is there already, and was not made by a test; remove it yourself" >&2
    return 2
  fi
  rm -rf "$1"
  mkdir -p "$1"
  : >"$1.scratch"
}
