#!/bin/sh
# Runs a test in the system's Python; 77 (skipped) and a word where something is not there.
#
#   run_python.sh PYTHON "MODULE;MODULE" TEST ARGUMENTS...
set -eu
python=$1
modules=$(echo "$2" | tr ';' ' ')
shift 2
if [ ! -x "$python" ]; then
  echo "skipped: no /usr/bin/python3 (package python3)"
  exit 77
fi
for module in $modules; do
  if ! "$python" -c "import $module" 2>/dev/null; then
    echo "skipped: $python has no module '$module' (docker/install-deps.sh test)"
    exit 77
  fi
done
exec "$python" "$@"
