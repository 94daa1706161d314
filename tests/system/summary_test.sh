#!/bin/sh
# The demo's summary on recordings made by hand: its figures and its verdicts.
#
#   summary_test.sh
set -eu
summary=$(cd "$(dirname "$0")/../../server/demo" && pwd)/summary.awk
failures=0

# recording FREE-FORCE CONTACT-FORCE: 1 s free, 1 s contact, 1 s free, at 1 kHz. In contact the
# force is CONTACT-FORCE; after it, for 100 ms, a tenth of it; else FREE-FORCE. The last 100 ms are
# in state LAST.
recording() {
  awk -v free="$1" -v contact="$2" -v last="$3" 'BEGIN {
    print "time_s,seq,state,proxy_age_us,mode,active_planes,gain,tau_a_l_x_n,lateness_us,skipped,faults"
    for (i = 0; i < 3000; ++i) {
      held = i >= 1000 && i < 2000
      force = held ? contact : i >= 2000 && i < 2100 ? contact / 10 : free
      # Lateness 0..99 us, each a hundredth of the ticks; one skipped deadline in all.
      state = i < 2900 ? "ENGAGED" : last
      fault = state == "FAULT" ? "LOOP_LATE" : ""
      printf("%.3f,%d,%s,%d,%s,1,%.6f,%d,%d,%s\n", i / 1000, i + 1, state, 4000,
             held ? "HELD," : "FREE,", force, i % 100, i == 1500, fault)
    }
  }'
}

expect() {  # expect STATUS PATTERN FREE-FORCE CONTACT-FORCE [LAST]
  status=0
  text=$(recording "$3" "$4" "${5:-ENGAGED}" | awk -f "$summary") || status=$?
  if [ "$status" -ne "$1" ] || ! echo "$text" | grep -qE "$2"; then
    echo "FAILED: force $3 N free, $4 N in contact: status $status, expected $1 and /$2/ in"
    echo "$text"
    failures=1
  fi
}

expect 0 'peak \|tau_a\| 5.00 N at 1.00 s' 0.02 -5
expect 0 'max 0.020 N = 0.40 % .*within 2 %' 0.02 -5
expect 0 'letting go +max \|tau_a\| 0.500 N' 0.02 -5
expect 0 'lateness +p50 49 us, p99 98 us, max 99 us' 0.02 -5
expect 0 '3000 ticks, 1 skipped, 0 records dropped' 0.02 -5
expect 0 'in contact +1.0 s in 1 contacts' 0.02 -5
expect 0 'max 0.100 N = 2.00 %' 0.1 5
expect 4 'MORE THAN 2 %' 0.101 5
expect 4 'MORE THAN 2 %' -0.2 5
expect 3 'no contact' 0 0
expect 7 'FAULT +LOOP_LATE, 100 ticks' 0.02 5 FAULT
expect 0 'free motion +2.0 s' 0.02 5
expect 0 'free motion +1.9 s' 0.02 5 IDLE

# A bound that half of the contact has.
text=$(recording 0.02 -5 ENGAGED | awk -F, -v OFS=, 'NR == 1 { print $0, "error_bound_l_x_n"; next }
  { print $0, $1 < 1.5 ? 0.25 : "" }' | awk -f "$summary")
if ! echo "$text" | grep -q 'known in 50.0 % of contact, median 0.2500 N, max 0.250 N'; then
  echo "FAILED: the error bound: expected half of the contact in"
  echo "$text"
  failures=1
fi

# A proxy behind planes is in contact like a held one if one of them holds it, and else free.
text=$(recording 0.02 -5 ENGAGED | sed 's/HELD,/PLANES,3|4/; s/FREE/PLANES/' | awk -f "$summary")
for pattern in 'in contact +1.0 s in 1 contacts' 'free motion +2.0 s'; do
  if ! echo "$text" | grep -qE "$pattern"; then
    echo "FAILED: planes that hold and that do not: expected /$pattern/ in"
    echo "$text"
    failures=1
  fi
done

status=0
echo "time_s,tick" | awk -f "$summary" >/dev/null || status=$?
if [ "$status" -ne 6 ]; then
  echo "FAILED: a recording without columns: status $status"
  failures=1
fi
exit $failures
