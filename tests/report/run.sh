#!/usr/bin/env bash
# Makes the report: figures of the study as CSV, plots (SVG, PNG) and an index.md that explains
# them.
#
#   tests/report/run.sh [--output DIR] [--build DIR] [part...]
#   tests/report/run.sh bits [--help]   is no figure: bits/run.sh
#
#   part           linkage fig4 recordings scan radius claims finger press
#                  closed_loop rate feel felt rtt scaling work_precision; default: all
#   --output DIR   default: report/ beside the README (ignored by git)
#   --build DIR    uses haptic-report of this build folder; neither installs nor builds
#
# `recordings` draws Fig. 4 for the recorded motions of ../shared/data, where that is present.
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
root=$(cd "$here/../.." && pwd)

if [[ ${1-} == bits ]]; then exec "$here/bits/run.sh" "${@:2}"; fi

output=$root/report
programs=
parts=()
while (($#)); do
  case "$1" in
    --output) output=${2:?--output needs a folder}; shift 2 ;;
    --build) programs=$(realpath -e -- "${2:?--build needs a folder}"); shift 2 ;;
    -h | --help) sed -n '2,${/^#/!q;s/^# \{0,1\}//p}' "$0"; exit 0 ;;
    -*) echo "run.sh: unknown argument '$1' (see --help)" >&2; exit 2 ;;
    *) parts+=("$1"); shift ;;
  esac
done
((${#parts[@]})) ||
  parts=(linkage fig4 recordings scan radius claims finger press closed_loop rate feel
    felt rtt scaling work_precision)

if [[ -z $programs ]]; then
  sh "$root/docker/install-deps.sh" build test report
  (cd "$root" && cmake --preset release --log-level=WARNING >/dev/null &&
    cmake --build --preset release --parallel "$(nproc)" --target haptic-report)
  programs=$root/build/release
fi
report=$(find "$programs" -type f -name haptic-report -perm -u+x -print -quit)
[[ -n $report ]] ||
  { echo "run.sh: no program haptic-report in $programs; build it first" >&2; exit 1; }
command -v gnuplot >/dev/null ||
  { echo "run.sh: gnuplot is missing (docker/install-deps.sh report)" >&2; exit 1; }
mkdir -p "$output"
output=$(cd "$output" && pwd)

# The studies of the methods are made on the linkage that is hard for them, unless a part sets
# another one.
linkage=finger_sign_change
csv() {  # csv NAME arguments...: what haptic-report prints, in NAME.csv
  local name=$1
  shift
  echo "haptic-report --linkage $linkage $*" >&2
  "$report" --linkage "$linkage" "$@" >"$output/$name.csv"
}
draw() {  # draw SCRIPT NAME [gnuplot assignments]: NAME.svg and NAME.png
  (cd "$here/plots" && gnuplot -e "output='$output/$2'; ${3:-}" "$1.gp")
}

# pivot CSV NAME ROWS KEY CELL KEYS COLUMNS: of the rows of CSV.csv that fulfil ROWS one line per
# KEY, with the last value that CELL put("column", value) in each of COLUMNS; into NAME.csv.
pivot() {
  awk -F, -v OFS=, -v columns="$6 $7" -v keys="$(wc -w <<<"$6")" "
    function put(column, value) { cell[key, column] = value }
    $3 { key = $4; if (!(key in seen)) { seen[key] = 1; order[++n] = key }; $5 }
    END { count = split(columns, column, \" \"); gsub(\" \", OFS, columns); print columns
          for (i = 1; i <= n; i++) { line = order[i]
            for (c = keys + 1; c <= count; c++) line = line OFS cell[order[i], column[c]]
            print line } }" "$output/$1.csv" >"$output/$2.csv"
}
methods="standard null_space subspace_linear subspace_exact"
recorded_motions() {  # the files, one per line; none is no error
  find "$root/../shared/data" -maxdepth 1 -name '*.csv' 2>/dev/null | sort
}
make_linkage() {
  local file linkage=$linkage  # as it is, until the loop
  csv linkage linkage --trade
  cut -d, -f1,3-12,17,18 "$output/linkage.csv" >"$output/linkage_worth.csv"
  cut -d, -f1,3,13-16,19-26 "$output/linkage.csv" >"$output/linkage_dimensions.csv"
  csv linkage_map linkage --map
  local motions=()
  while read -r file; do motions+=(--motion "$file"); done < <(recorded_motions)
  if ((${#motions[@]})); then
    csv linkage_motions linkage "${motions[@]}"
  else
    echo "run.sh: no recordings in ../shared/data; left out" >&2
    rm -f "$output/linkage_motions.csv"
  fi
  draw linkage linkage "csv='$output/linkage_map.csv'"
  draw linkage_trade linkage_trade "csv='$output/linkage.csv'"
  # The studies of the methods on both linkages.
  for linkage in finger_same_sign finger_sign_change; do
    csv "both_$linkage" scan
    csv "both_fig4_$linkage" fig4
  done
  (cd "$output" && awk -F, -v OFS=, \
    'FNR == 1 { linkage = FILENAME; sub(/^both_(fig4_)?/, "", linkage); sub(/[.]csv$/, "", linkage)
                next }
     FILENAME ~ /fig4/ { value[linkage, $1, $2] = $3; next }
     { key[++n] = linkage OFS $1; of[n] = linkage; method[n] = $1; scan[n] = $3 OFS $5 }
     END { print "linkage", "method", "nonpassive_of_168", "worst_cycle_work_of_168_pct",
             "a_exact_nonpassive_pct", "a_fd_nonpassive_pct", "a_cycle_work_pct"
           for (i = 1; i <= n; i++) print key[i], scan[i],
             value[of[i], method[i], "exact_nonpassive_pct"],
             value[of[i], method[i], "fd_nonpassive_pct"],
             value[of[i], method[i], "cycle_work_pct"] }' \
    both_*.csv >linkage_methods.csv && rm both_*.csv)
}
make_claims() {
  csv claims claims
  cut -d, -f1-8,10-14 "$output/claims.csv" >"$output/claims_table.csv"
  csv claims_felt claims --felt
}
make_fig4() {
  local name amplitude phase
  while read -r name amplitude phase; do
    csv "fig4_$name" fig4 --amplitude "$amplitude" --phase "$phase"
    csv "fig4_${name}_series" fig4 --amplitude "$amplitude" --phase "$phase" --series
    pivot "fig4_$name" "fig4_${name}_table" 'NR > 1' '$2' 'put($1, $3)' metric "$methods"
    draw fig4 "fig4_$name" \
      "csv='$output/fig4_${name}_series.csv';
       heading='Trajectory ${name//_/ }: amplitudes $amplitude°, phase $phase°'"
  done <<<$'A 35,50 15\nB 56,70 25\nB_reversed 56,70 -25'
}
make_recordings() {
  local file name last
  echo "recording,method,fd_nonpassive_pct,cycle_work_pct,cycle_work_reversed_pct" \
    >"$output/recordings.csv"
  [[ -n $(recorded_motions) ]] ||
    { echo "run.sh: no recordings in ../shared/data; left out" >&2; return 0; }
  for file in $(recorded_motions); do
    name=$(basename "$file" .csv)
    csv "motion_$name" fig4 --motion "$file"
    csv "motion_${name}_series" fig4 --motion "$file" --series
    awk -F, -v OFS=, -v name="$name" \
      'NR > 1 { value[$1, $2] = $3; if (!seen[$1]++) order[++n] = $1 }
      END { for (i = 1; i <= n; i++) print name, order[i], value[order[i], "fd_nonpassive_pct"],
              value[order[i], "cycle_work_pct"], value[order[i], "cycle_work_reversed_pct"] }' \
      "$output/motion_$name.csv" >>"$output/recordings.csv"
    last=$(awk -F, 'END { print $2 }' "$output/motion_${name}_series.csv")
    draw fig4 "motion_$name" \
      "csv='$output/motion_${name}_series.csv'; from=0; to=$last; heading='recording ${name//_/ }'"
  done
}
make_scan() {
  csv scan scan
  csv scan_list scan --list
  draw scan scan "csv='$output/scan_list.csv'; shares='$output/scan.csv'"
}
make_radius() {
  csv radius radius --all
  csv radius_map radius --all --map --grid 120
  draw radius radius "csv='$output/radius_map.csv'"
}
make_finger() {
  local name
  local guard heading
  for name in finger finger_guard finger_guard_tank; do
    case $name in
      finger) guard=() heading="no guard" ;;
      finger_guard) guard=(--guard) heading="direction guard" ;;
      *) guard=(--guard --tank) heading="direction guard and energy tank" ;;
    esac
    csv "$name" finger --joints "${guard[@]}"
    csv "${name}_trace" finger --trace "${guard[@]}"
    csv "${name}_grid" finger --grid --joints "${guard[@]}"
    draw finger "$name" "csv='$output/${name}_trace.csv'; heading='Presses, $heading'"
  done
  # The corner of a straight MCP and a bent PIP: the MCP stopped at 0, the hand aims at (5, 80)
  # degrees.
  local with
  : >"$output/finger_corner.csv"
  while read -r with; do
    csv corner finger --stop=0,999 --target 5,80 --joints $with
    awk -v with="${with:-nothing}" \
      'NR > 1 { print with "," $0 } NR == 1 && with == "nothing" { print "with," $0 }' \
      "$output/corner.csv" | sed 's/^--//; s/ --/ and /' >>"$output/finger_corner.csv"
  done <<<$'\n--guard\n--guard --tank'
  rm "$output/corner.csv"
  # How many of the 24 presses ended how.
  (cd "$output" && awk -F, -v OFS=, 'FNR == 1 { 
      with = FILENAME ~ /tank/ ? "guard and tank" : FILENAME ~ /guard/ ? "guard" : "nothing";
        next }
    { n[with OFS $1 OFS $13]++ } END { for (key in n) print key,
      n[key] }' finger_grid.csv finger_guard_grid.csv finger_guard_tank_grid.csv |
    sort | { echo "with,method,verdict,runs"; cat; } >finger_counts.csv)
}

make_press() {
  local linkage worst number
  for linkage in finger_same_sign finger_sign_change; do
    csv "press_$linkage" press \
      --summary "$output/press_${linkage}_summary.csv"
    draw press "press_$linkage" \
      "csv='$output/press_$linkage.csv'; heading='Presses, ${linkage//_/ }'"
    # The ten of the rule per contact that end deepest against the same press without force.
    worst=$(awk -F, '$2 == "per_contact" { print $14, $3 }' "$output/press_$linkage.csv" |
      sort -grk1 | awk 'NR <= 10 { print $2 }' | tr '\n' ' ')
    : >"$output/press_${linkage}_worst.csv"
    for number in $worst; do
      csv press_trace press --method per_contact --press "$number" --trace
      awk -v first="$([[ -s $output/press_${linkage}_worst.csv ]] && echo 0 || echo 1)" \
        'NR > 1 || first' "$output/press_trace.csv" >>"$output/press_${linkage}_worst.csv"
    done
    rm "$output/press_trace.csv"
    draw press_worst "press_${linkage}_worst" \
      "csv='$output/press_${linkage}_worst.csv'; presses='$worst';
       heading='Worst ten, ${linkage//_/ }'"
  done
}

closed_loop_tables() {  # of closed_loop.csv: by method; every tick without delay; free space; late
                        # contacts
  cd "$output"
  awk -F, -v OFS=, 'NR == 1 || $2 == 80 { next }
    { key = $4 OFS $8; if (!(key in rows)) order[++n] = key; rows[key]++; gives[key] += $20 != "ok"
      if ($12 > worst[key] + 0) worst[key] = $12
      if ($1 == "press" && ($5 == "held" || $5 == "planes" || $5 == "q_metric")) {
        presses[key]++; throttled[key] += $19 > 0 }
      force[key] += $15; plain[$4] += $8 == "nothing" ? $15 : 0 }
    END { print "method", "with", "rows", "rows_that_give_energy", "worst_most_net_mj", "presses",
      "presses_throttled", "force_kept_pct"
          for (i = 1; i <= n; i++) { key = order[i]; split(key, part, OFS)
            print key, rows[key], gives[key], worst[key] + 0, presses[key], throttled[key],
              int(100 * force[key] / plain[part[1]] + 0.5) } }' \
    closed_loop.csv >closed_loop_methods.csv
  pivot closed_loop closed_loop_cycles 'NR > 1 && $2 != 80 && $1 != "press" && $6 == 1000' \
    '$1 OFS $2 OFS $3 OFS $4' \
    'with = $8 == "nothing" ? "" : $8 "_"; direction = $9 == "reversed" ? "_reversed" : ""
    put(with "net" direction "_mj", $11); put(with "given" direction "_pct", $14)' \
    "motion stop_mcp_deg stop_pip_deg method" "net_mj net_reversed_mj given_pct given_reversed_pct \
guard_tank_net_mj guard_tank_net_reversed_mj"
  pivot closed_loop closed_loop_free '$2 == 80 && $8 == "nothing" && $4 != "q_metric"' \
    '$5 OFS $6 OFS $7' 'put($4, $15)' "proxy rate_hz delay_ms" "$methods"
  awk -F, -v OFS=, \
    '$1 == "press" && $2 != 80 && $4 != "q_metric" && ($8 == "guard" || $8 == "guard_tank") {
      key = $5 OFS $4; stop = $2 OFS $3 OFS $6 OFS $7
      if ($8 == "guard") { plain[key, stop] = $15; next }
      if (!(key in presses)) { order[++n] = key; least[key] = 100 }
      presses[key]++; touched[key] += $19 > 0; if ($19 > most[key] + 0) most[key] = $19
      kept = plain[key, stop] > 0 ? 100 * $15 / plain[key, stop] : 100
      if (kept < least[key]) least[key] = kept }
    END { print "proxy", "method", "presses", "presses_throttled", "most_throttled_ticks",
      "least_force_kept_pct"
          for (i = 1; i <= n; i++) { key = order[i]
            printf "%s,%d,%d,%d,%.2f\n", key, presses[key], touched[key], most[key],
              least[key] } }' \
    closed_loop.csv >closed_loop_presses.csv
  cd "$OLDPWD"
}
# rate_table COLUMN NAME: K_max as in tests/report/STUDY.md#rate-delay-and-kind-of-proxy, into
# rate_NAME.csv
rate_table() {
  pivot rate "rate_$2" 'NR > 1 && ($3 == 0 || $3 == 20 || $3 == 100)' '$2 OFS $3' \
    "k = 10 ^ (length(int(\$$1)) - 2)
    put(\$1 (\$4 == \"tank\" ? \"_with_tank\" : \"\"), int(\$$1 / k + 0.5) * k)" \
    "rate_hz delay_ms" \
    "held_force held extrapolated planes derived_planes held_with_tank planes_with_tank \
derived_planes_with_tank"
}
make_closed_loop() {
  csv closed_loop closed-loop
  csv closed_loop_trace closed-loop --trace --motion hand --stop 18,999 --rate 1000 --proxy held \
    --direction reversed
  draw closed_loop closed_loop \
    "csv='$output/closed_loop.csv'; trace='$output/closed_loop_trace.csv'"
  draw closed_loop_clients closed_loop_clients "csv='$output/closed_loop.csv'"
  closed_loop_tables
}
make_rate() {
  csv rate rate
  csv rate_cycles rate --cycles
  draw rate rate "csv='$output/rate.csv'; cycles='$output/rate_cycles.csv'"
  rate_table 5 press
  rate_table 6 in_and_out
  awk -F, 'NR == 1 || ($2 == 60 && $3 == 20)' "$output/rate_cycles.csv" \
    >"$output/rate_cycles_60_20.csv"
}

make_felt() {
  local linkage=finger_same_sign file motions=()  # the scenes' linkage
  while read -r file; do motions+=(--motion "$file"); done < <(recorded_motions)
  csv felt felt "${motions[@]}"
  # Per contact: every tick's error by kind of proxy and delay, a column per rate.
  pivot felt felt_grid '$5 == "all" && $1 == "per_contact"' '$2 OFS $4' 'put($3, $18)' \
    "proxy delay_ms" "1000 200 60 30"
  # All renderers on one network, every network of one renderer, and its motions and objects.
  awk -F, 'NR == 1 || ($5 == "all" && $3 == 60 && $4 == 20)' "$output/felt.csv" \
    >"$output/felt_renderers.csv"
  awk -F, 'NR == 1 || ($5 == "all" && $1 == "per_contact")' "$output/felt.csv" \
    >"$output/felt_networks.csv"
  awk -F, 'NR == 1 || ($5 != "all" && $1 == "per_contact" && $3 == 60 && $4 == 20)' \
    "$output/felt.csv" >"$output/felt_of.csv"
  # The vibration by client, if the part feel was made before.
  [[ -s $output/feel.csv ]] || echo "noise,drive,method,group,weighted_95" >"$output/feel.csv"
  draw felt felt "csv='$output/felt_grid.csv'; ticks='$output/felt_renderers.csv';
    feel='$output/feel.csv'"
}

make_feel() {
  local linkage=finger_same_sign rough="--noise 5um_0.05deg" worst run  # the scenes' linkage
  csv feel feel
  csv feel_more feel --method subspace_linear $rough
  tail -n +2 "$output/feel_more.csv" >>"$output/feel.csv"
  csv feel_more feel --drive $rough
  tail -n +2 "$output/feel_more.csv" >>"$output/feel.csv"
  csv feel_more feel --stiffness 3000 $rough
  tail -n +2 "$output/feel_more.csv" >>"$output/feel.csv"
  # The ten that are worst by what a hand notices.
  csv feel_each feel --each $rough
  worst=$(awk -F, 'NR > 1 { print $6, $2 ":" $3 }' "$output/feel_each.csv" |
    sort -grk1 | awk 'NR <= 10 { print $2 }' | tr '\n' ' ')
  for run in $worst; do
    csv feel_more feel --trace "${run%:*}" --index "${run#*:}" $rough
    cat "$output/feel_more.csv"
  done | awk 'NR == 1 || !/^noise/' >"$output/feel_worst.csv"
  rm "$output/feel_more.csv"
  draw feel_worst feel_worst "csv='$output/feel_worst.csv'; runs='$worst';
    heading='Worst ten of 850, sensors with noise of 5 um and 0.05 deg'"
  # The same noise in other studies: their force from 50 to 500 Hz at the actuator.
  csv noise_press press --method per_contact --stiffness 1500 $rough \
    --summary "$output/noise_presses.csv"
  csv noise_felt felt --method per_contact --rate 60 --delay 20 $rough
  csv noise_rtt rtt --object finger_worn_reach_and_grasp --round-trip 100 $rough
  (cd "$output" && awk -F, -v OFS=, 'BEGIN { print "study", "client", "band_mn" } FNR == 1 { next }
    FILENAME ~ /presses/ { print "press", $3, $23 }
    FILENAME ~ /felt/ && $5 == "all" { print "felt", $2, $26 }
    FILENAME ~ /rtt/ { print "rtt", $2, $23 }' noise_presses.csv noise_felt.csv noise_rtt.csv \
    >noise.csv && rm noise_*.csv)
}
make_rtt() {
  local linkage=finger_same_sign file peer trip motions=()  # the scenes' linkage
  while read -r file; do motions+=(--motion "$file"); done < <(recorded_motions)
  csv rtt rtt "${motions[@]}"
  draw rtt_error rtt_error "csv='$output/rtt.csv'"
  for file in soft_wall finger_worn_reach_and_grasp; do
    for peer in contacts derived_planes held; do
      for trip in 0 100; do
        csv rtt_part rtt --trace --object "$file" --peer "$peer" --round-trip "$trip"
        cat "$output/rtt_part.csv"
      done
    done
  done | awk 'NR == 1 || !/^object/' >"$output/rtt_trace.csv"
  rm "$output/rtt_part.csv"
  draw rtt_force rtt_force "csv='$output/rtt_trace.csv'"
  # Contacts at every round trip, peers at one, other rates and loss.
  awk -F, 'NR == 1 || ($2 == "contacts" && $4 == 60 && $5 == 0)' "$output/rtt.csv" \
    >"$output/rtt_contacts.csv"
  awk -F, 'NR == 1 || ($17 != "nan" && $2 == "contacts" && $4 == 60 && $5 == 0)' \
    "$output/rtt.csv" >"$output/rtt_bound.csv"
  awk -F, 'NR == 1 || ($3 == 100 && $4 == 60 && $5 == 0)' "$output/rtt.csv" >"$output/rtt_peers.csv"
  awk -F, 'NR == 1 || ($2 == "contacts" && $3 == 100 && ($4 != 60 || $5 != 0))' \
    "$output/rtt.csv" >"$output/rtt_rates.csv"
}
make_work_precision() {
  local linkage=finger_same_sign
  csv work_precision work-precision
  draw work_precision work_precision "csv='$output/work_precision.csv'"
}
make_scaling() {
  csv scaling scaling
  draw scaling scaling "csv='$output/scaling.csv'"
}

for part in "${parts[@]}"; do
  declare -F "make_$part" >/dev/null ||
    { echo "run.sh: unknown part '$part' (see --help)" >&2; exit 2; }
done
for part in "${parts[@]}"; do "make_$part"; done
awk -v folder="$output" -v parts="${parts[*]}" -f "$here/index.awk" "$here/index.in" \
  >"$output/index.md"
{
  echo
  commit=$(git -C "$root" describe --always --dirty 2>/dev/null || echo unknown)
  echo "Made by tests/report/run.sh at commit $commit" \
    "on $(nproc) core(s), $(awk -F': ' '/model name/ { print $2; exit }' /proc/cpuinfo)."
} >>"$output/index.md"
echo "$output/index.md"
