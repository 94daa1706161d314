#!/usr/bin/env bash
# Clients that come and go over every carrier, under the thread sanitizer.
#
#   tests/churn/run.sh [SECONDS]      default: 60 s
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
seconds=${1:-60}
case "$seconds" in
  -h | --help) sed -n '2,${/^#/!q;s/^# \{0,1\}//p}' "$0"; exit 0 ;;
  *[!0-9]* | 0) echo "run.sh: seconds '$seconds': must be a whole number above 0" >&2; exit 2 ;;
esac
cd "$root"
cmake --preset tsan
cmake --build --preset tsan --target haptic_churn_tests
TSAN_OPTIONS="suppressions=$root/tests/tsan.supp" HAPTIC_CHURN_SECONDS=$seconds \
  build/tsan/tests/haptic_churn_tests
