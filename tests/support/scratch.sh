# shellcheck shell=sh
# Sourced by tests that work in a folder given to them.

# fresh_folder FOLDER: makes it, empty. It never removes a folder that it did not make, so that a
# wrong argument does no harm: FOLDER.scratch marks those that it made.
fresh_folder() {
  if [ -e "$1" ] && [ ! -e "$1.scratch" ]; then
    echo "$1: exists and was not made by a test; remove it yourself" >&2
    return 2
  fi
  rm -rf "$1"
  mkdir -p "$1"
  : >"$1.scratch"
}
