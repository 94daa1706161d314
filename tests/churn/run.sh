#!/usr/bin/env bash
# Clients that come and go over every transport, under the thread sanitizer, for as long as one likes.
#
#   tests/churn/run.sh [SECONDS]      default: 60 s
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
cd "$root"
cmake --preset tsan
cmake --build --preset tsan --target haptic_churn_tests
TSAN_OPTIONS="suppressions=$root/tests/tsan.supp" HAPTIC_CHURN_SECONDS=${1:-60} \
  build/tsan/tests/haptic_churn_tests
