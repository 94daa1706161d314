# shellcheck shell=sh disable=SC2034  # failed: for those who source it
# Sourced by the tests of haptic-report with its path as their first argument: runs it on the
# linkage of the page's figures and notes what fails.
haptic_report=$1
report() {
  "$haptic_report" --linkage finger_sign_change "$@"
}
failed=0
fail() {
  echo "FAILED: $*"
  failed=1
}
refused() {  # refused arguments...: exit status 2, a reason on standard error, nothing on output
  output=$(report "$@" 2>/dev/null)
  [ $? -eq 2 ] || fail "haptic-report $*: must end with 2"
  [ -z "$output" ] || fail "haptic-report $*: must print nothing"
  [ -n "$(report "$@" 2>&1 >/dev/null)" ] || fail "haptic-report $*: must say why"
}
