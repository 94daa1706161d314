# The demo's summary, from the recording of every tick (server/owner/telemetry/recorder.hpp).
#
#   awk -f summary.awk [-v stretches=FILE] RECORDING
#
# Prints the summary; writes the contact phases ("begin end", s) to `stretches` for the figure.
#
# Contact: the proxy is held, or a plane or contact holds it, and the gain is above zero. Free
# motion: force is switched on (ENGAGED) and nothing is in the way: mode FREE, or no plane holds the
# proxy. |tau_a| is the whole command, damping included. When the finger lets go, the slew limit and
# the damping's 200 ms ramp take the last of the command away; those 200 ms are reported by
# themselves, and the bound of 2 % is asked of free motion after them.
#
# With several motors, as of a hand, |tau_a| is the largest of them, and each must have felt
# contact: more than the bound of free motion.
#
# Exit status: 0 as promised; 3 no contact, or none of a motor; 4 the bound does not hold; 5 no free
# motion; 6 no data; 7 a fault.

function sort(a, n,    gap, i, j, v) {  # Shell sort: mawk has none of its own
  for (gap = int(n / 2); gap > 0; gap = int(gap / 2))
    for (i = gap + 1; i <= n; i++) {
      v = a[i]
      for (j = i; j > gap && a[j - gap] > v; j -= gap) a[j] = a[j - gap]
      a[j] = v
    }
}
function quantile(a, n, p,    i) {
  if (n == 0) return 0
  i = int(p * n + 0.999999)
  return a[i < 1 ? 1 : i]
}
function touching(mode, planes) { return mode == "HELD" || (mode == "PLANES" && planes != "") }
function abs(v) { return v < 0 ? -v : v }
function close_contact(t) {
  if (contact_since == "") return
  if (stretches != "") printf "%.4f %.4f\n", contact_since, t > stretches
  contact_since = ""
}

BEGIN { FS = ","; ramp_s = 0.2; bound = 0.02 }

NR == 1 {
  for (i = 1; i <= NF; i++) column[$i] = i
  for (i = 1; i <= NF; i++) if ($i ~ /^tau_a_/) {
    motor[++motors] = i
    name[motors] = $i
    sub(/^tau_a_/, "", name[motors]); sub(/\..*/, "", name[motors])
    off_column[motors] = column["error_bound" substr($i, 6)]
  }
  split("time_s seq state proxy_age_us mode active_planes gain lateness_us skipped", needed, " ")
  for (i in needed) if (!(needed[i] in column)) {
    print "summary: the recording has no column " needed[i]
    broken = 1
  }
  if (!motors) { print "summary: the recording has no column tau_a_..."; broken = 1 }
  if (broken) exit 6
  next
}

{
  t = $column["time_s"] + 0
  mode = $column["mode"]
  touches = touching(mode, $column["active_planes"])
  engaged = $column["state"] == "ENGAGED"
  force = 0
  for (i = 1; i <= motors; i++) if (abs($motor[i]) > force) force = abs($motor[i])
  gain = $column["gain"] + 0
  if (rows++) dt = t - last_t; else { begin = t; dt = 0 }
  lost_records += rows > 1 ? $column["seq"] - last_tick - 1 : 0
  skipped += $column["skipped"]
  late[++n_late] = $column["lateness_us"] + 0
  if (mode != "NONE") age[++n_age] = $column["proxy_age_us"] * 1e-3
  if (touches && gain > 0) {
    if (contact_since == "") { contact_since = t; contacts++ }
    contact_s += dt
    contact_ticks++
    for (i = 1; i <= motors; i++) {
      if (off_column[i] && $off_column[i] != "") off[++n_off] = $off_column[i] + 0
      if (abs($motor[i]) > most[i]) most[i] = abs($motor[i])
    }
    if (force > peak) { peak = force; peak_at = t }
    at_once = split($column["active_planes"], held, "|")
    if (at_once > most_at_once) most_at_once = at_once
  } else {
    close_contact(t)
  }
  free_now = engaged && mode != "NONE" && !touches
  if (free_now) {
    if (!last_free) free_since = last_touches ? t : t - ramp_s
    free_s += dt
    if (force > free_any) free_any = force
    if (t - free_since >= ramp_s) free[++n_free] = force
    else if (force > letting_go) letting_go = force
  }
  if ($column["faults"] != "") faults[$column["faults"]]++
  last_free = free_now
  last_t = t; last_tick = $column["seq"]; last_touches = touches
}

END {
  if (broken) exit 6
  if (!rows) { print "summary: the recording is empty"; exit 6 }
  close_contact(last_t)
  sort(late, n_late); sort(age, n_age); sort(free, n_free)
  printf "  recorded          %.1f s, %d ticks, %d skipped, %d records dropped\n",
         last_t - begin, rows, skipped, lost_records
  printf "  loop lateness     p50 %.0f us, p99 %.0f us, max %.0f us\n",
         quantile(late, n_late, 0.5), quantile(late, n_late, 0.99), late[n_late]
  printf "  proxy age         p50 %.1f ms, p99 %.1f ms\n",
         quantile(age, n_age, 0.5), quantile(age, n_age, 0.99)
  printf "  in contact        %.1f s in %d contacts\n", contact_s, contacts
  printf "  in free motion    %.1f s\n", free_s
  for (f in faults) { printf "  FAULT             %s, %d ticks\n", f, faults[f]; faulted = 1 }
  if (!contacts || peak == 0) { print "  no contact: nothing was felt"; exit 3 }
  printf "  contact           peak |tau_a| %.2f N at %.2f s\n", peak, peak_at
  if (motors > 1) {
    printf "  contacts at once  %d\n", most_at_once
    for (i = 1; i <= motors; i++) {
      printf "  %-17s peak |tau_a| %.2f N\n", name[i], most[i]
      if (most[i] <= bound * peak) unfelt = unfelt " " name[i]
    }
  }
  sort(off, n_off)
  if (n_off)
    printf "  error bound       known in %.1f %% of contact, median %.4f N, max %.3f N\n",
           100 * n_off / contact_ticks / motors, quantile(off, n_off, 0.5), off[n_off]
  if (unfelt != "") { print "  no contact was felt by" unfelt; exit 3 }
  if (!n_free) { print "  no free motion longer than the ramps: nothing to compare with"; exit 5 }
  worst = free[n_free]
  printf "  letting go        max |tau_a| %.3f N in the 200 ms after contact " \
         "(%.1f %% of the peak)\n", letting_go, 100 * letting_go / peak
  printf "  free motion       |tau_a| p99 %.3f N, max %.3f N = %.2f %% of the contact's peak: %s\n",
         quantile(free, n_free, 0.99), worst, 100 * worst / peak,
         worst <= bound * peak ? "within 2 %" : "MORE THAN 2 %"
  exit worst > bound * peak ? 4 : faulted ? 7 : 0
}
