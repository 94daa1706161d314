#!/bin/sh
# haptic-report's cheap subcommands against what tests/report/STUDY.md prints: headers, values,
# statuses.
#
#   report_test.sh HAPTIC-REPORT [values|grid]      grid: the presses at the finger alone
set -u
. "$(dirname "$0")/report_checks.sh"

header() {  # header EXPECTED arguments...: the first line
  expected=$1
  shift
  found=$(report "$@" 2>/dev/null | head -n 1)
  [ "$found" = "$expected" ] || fail "haptic-report $*: header '$found', expected '$expected'"
}
# near KEY EXPECTED TOLERANCE: the last column of the line of $csv that begins with KEY. Not in a
# pipe: a failure there would be forgotten.
near() {
  awk -F, -v key="$1" -v expected="$2" -v tolerance="$3" '
    index($0, key ",") == 1 { found = 1; value = $NF }
    END {
      d = value - expected
      if (!found || value == "nan" || d > tolerance || d < -tolerance) {
        printf "FAILED: %s = %s, expected %s +- %s\n", key, found ? value : "(none)", expected,
          tolerance
        exit 1
      }
    }' <<CSV || failed=1
$csv
CSV
}
has() {  # has LINE: $csv holds it, whole
  echo "$csv" | grep -qx "$1" || fail "no line '$1'"
}

if [ "${2:-values}" = grid ]; then
  # tests/report/STUDY.md#chosen-presses-finger_sign_change, 24 runs: deeper than without force
  # standard 2, (6) 4; with the guard none.
  deeper() { report finger --grid "$@" | grep deeper | cut -d, -f1 | sort | uniq -c |
    tr -s ' \n' ' '; }
  found=$(deeper)
  [ "$found" = " 2 standard 4 subspace_exact " ] || fail "finger --grid: deeper are '$found'"
  found=$(deeper --guard)
  [ -z "$found" ] || fail "finger --grid --guard: deeper are '$found'"
  # With the tank behind it no run gives more than the device's own damping takes back.
  found=$(report finger --grid --tank --guard | grep -c ',ok$')
  [ "$found" = 96 ] || fail "finger --grid --tank --guard: $found of 96 runs are ok"
  exit "$failed"
fi

refused

# tests/report/STUDY.md#finite-difference-rule-finger_sign_change, trajectory A.
header "method,metric,value" fig4
csv=$(report fig4 --amplitude 35,50 --phase 15)
fig4() {  # fig4 RENDERER METRIC VALUE TOLERANCE
  near "$1,$2" "$3" "$4"
}
fig4 standard tau_min -5.092 0.05
fig4 standard exact_nonpassive_pct 39.50 0.05
fig4 standard fd_nonpassive_pct 4.75 0.05
fig4 null_space fd_all_nonpassive_pct 3.90 0.05
fig4 null_space cycle_work_pct -7.645 0.05
fig4 subspace_linear tau_min -13.885 0.05
fig4 subspace_linear fd_excluded_pct 5.20 0.05
fig4 subspace_linear cycle_work_reversed_pct -4.970 0.05
fig4 subspace_exact exact_partial_max -1 1e-12
fig4 subspace_exact cycle_work_pct 0 1e-9
refused fig4 --amplitude 200,50
refused fig4 --motion /nowhere.csv

# tests/report/STUDY.md#fig-4-finger_sign_change: 150, 101, 88 and 0 of 168.
header "method,trajectories,any_nonpassive,share_pct,worst_cycle_work_pct" scan
csv=$(report scan | cut -d, -f1-3)
for line in standard,168,150 null_space,168,101 subspace_linear,168,88 subspace_exact,168,0; do
  has "$line"
done

# tests/report/STUDY.md#the-claims-on-other-devices: (9) holds everywhere for Eq. (6), not for Eq.
# (8).
header "device,n_a,n_n,n_x,derivative,Z_x,deviation_pct,method,states,negative_definite_pct,\
no_force_from_sensed_pct,conservative_pct,curl_median_pct,largest_eigenvalue,worst_q" claims
csv=$(report claims | cut -d, -f1,5,7,8,10-13)
[ "$(echo "$csv" | grep -c "subspace_exact,100,100,100,0$")" = 24 ] || fail "claims: Eq. (6)"
csv=$(echo "$csv" | cut -d, -f1-5)
near "finger_sign_change,exact,30,subspace_linear" 54.6 0.05
near "hand 4 of 8,exact,30,subspace_linear" 56.4 0.05

# tests/report/STUDY.md#choice-of-the-linkage.
csv=$(report linkage | cut -d, -f1,6)
near finger_same_sign 100 0
near finger_sign_change 68.3 0.05

# tests/report/STUDY.md#passivity-radius-finger_sign_change: 1 % 5.3, 5 % 7.7, median 19 deg
# (ranges depend on the grid).
header "method,quantile_pct,radius_deg,poses" radius --grid 20
csv=$(report radius | cut -d, -f1-3)
near subspace_linear,1 5.3 0.1
near subspace_linear,5 7.7 0.1
near subspace_linear,50 19.2 0.1

# tests/report/STUDY.md#chosen-presses-finger_sign_change: the end state of each row and the energy
# put into the finger.
header "method,stop_mcp_deg,stop_pip_deg,target_mcp_deg,target_pip_deg,stiffness_n_per_m,end_mcp_deg,\
end_pip_deg,max_penetration_deg,no_force_penetration_deg,peak_force_n,work_mj,verdict" \
  finger --stop 18,999 --method standard
rows=$(report finger)
# finger RENDERER STOP K end_mcp end_pip [work]: within 0.15 deg, 4 % and the digits printed
finger() {
  line=$(echo "$rows" | grep "^$1,$2,50,50,$3,")
  csv="$(echo "$line" | cut -d, -f1-7)"
  near "$1,$2,50,50,$3" "$4" 0.15
  csv="$(echo "$line" | cut -d, -f1-6,8)"
  near "$1,$2,50,50,$3" "$5" 0.15
  [ $# -eq 6 ] || return 0
  csv="$(echo "$line" | cut -d, -f1-6,12)"
  near "$1,$2,50,50,$3" "$6" "$(awk "BEGIN { print ${6#-} * 0.04 + 0.5 }")"
}
finger standard 18,999 1500 54.8 60.4 51
finger null_space 18,999 1500 47.7 45.5 -14
finger subspace_linear 18,999 1500 47.4 44.8 -22
finger subspace_exact 18,999 1500 50.8 51.7 -8
finger standard 18,999 6000 42.1 76.0 169
finger null_space 18,999 6000 42.0 34.9 -34
finger subspace_linear 18,999 6000 38.5 29.2 -47
finger subspace_linear 999,25 1500 46.6 43.3
finger subspace_exact 18,25 1500 44.2 38.7
echo "$rows" | grep -q "^subspace_exact,18,999,50,50,6000,.*,deeper and gives energy$" ||
  fail "finger: (6) on an MCP stop at 6000 N/m pulls the finger into the wall" \
    "(tests/report/STUDY.md#chosen-presses-finger_sign_change)"
header "method,proxy,fingers_declared,fingers_in_contact,tick_ns,idle_share_pct" scaling --ticks 16

# Ten kinds of hard frames; KDL on the arm alone. Where x is an image (6) of the finger, in closed
# form, finds it.
rows=$(report work-precision --frames 6 --blocks 1 2>/dev/null)
kinds=$(echo "$rows" | awk -F, 'NR > 1 && !seen[$1, $2]++' | wc -l)
[ "$kinds" = 10 ] || fail "work-precision: $kinds kinds of frames, expected 10"
echo "$rows" | grep -q '^finger,.*,kdl_lma,' && fail "work-precision: KDL has no closed loops"
[ "$(echo "$rows" | grep -c '^arm,.*,kdl_lma,')" = 25 ] || fail "work-precision: 25 rows of KDL"
for kind in random near_singular; do
  csv=$(echo "$rows" | cut -d, -f1-3,13)
  near "finger,$kind,eq6" 100 0
done
# tests/report/STUDY.md#presses: 32 of the 640; per contact none ends deeper than without force,
# none exceeds the tank.
summary=$(mktemp)
rows=$("$haptic_report" --linkage finger_sign_change press --presses 32 --method per_contact \
  --summary "$summary")
[ "$(echo "$rows" | wc -l)" = 33 ] || fail "press: must be a row per press"
awk -F, '
  NR == 1 { for (i = 1; i <= NF; i++) at[$i] = i; next }
  $at["client"] == "all" {
    seen = $at["presses"]
    bad = $at["deeper"] + $at["deeper_at_peak"] + $at["over_tank"]
    if ($at["off_pct"] > 5) bad++
  }
  END { if (seen != 32 || bad) { print "FAILED: press: " seen " presses, " bad " bad"; exit 1 } }
' "$summary" || failed=1
rm "$summary"
refused press --presses 0

# The same presses through an emulated board: every method, at the actuator and at the finger.
rows=$(report finger --board --stop 18,999)
[ "$(echo "$rows" | wc -l)" = 5 ] || fail "finger --board: must be a row per method"
echo "$rows" | grep -q "peak_cell_n,end_cell_n,peak_mcp_torque_nmm,peak_pip_torque_nmm$" ||
  fail "finger --board: must end with cell and torques"
# Each of the four comes to rest with the force in the cell that it commands, within what the
# drive's friction leaves to its loop, and with torques of that force's sign at both joints: the rod
# turns them the same way.
report finger --board --joints --stop 18,999 | awk -F, '
  NR == 1 { for (i = 1; i <= NF; i++) at[$i] = i; next }
  {
    methods = methods $1 " "
    commanded = $at["end_force_n"]; cell = $at["end_cell_n"]
    mcp = $at["end_mcp_torque_nmm"]; pip = $at["end_pip_torque_nmm"]
    off = cell - commanded
    if (off > 0.3 || off < -0.3) {
      print "FAILED: finger --board " $1 ": cell " cell " N, commanded " commanded; bad = 1 }
    if (!(cell * mcp > 0 && cell * pip > 0)) {
      print "FAILED: finger --board " $1 ": torques " mcp ", " pip; bad = 1 }
  }
  END {
    if (methods != "standard null_space subspace_linear subspace_exact ") {
      print "FAILED: finger --board: " methods; bad = 1 }
    exit bad
  }' || failed=1

[ "$failed" -eq 0 ] && echo "haptic-report: as tests/report/STUDY.md prints it"
exit "$failed"
