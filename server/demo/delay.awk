# Effect of a delay on the force of the demo: two recordings of the same motion of the hand.
#
#   awk -v ms=MS -v curves=FILE -f delay.awk UNDELAYED DELAYED
#
# Prints a line for the summary, and writes "time,force,force with the delay" to `curves` for the
# figure. Compared where both have all their force and either is in contact. The hand gives way, so
# the two fingers do not move quite alike; tests/relay/network_touch_test.cpp judges by the motion
# that was felt instead.

function column_of(name,    i) {
  for (i = 1; i <= NF; i++) if ($i == name) return i
  print "delay: the recording has no column " name
  broken = 1
  exit 6
}
function tick(t) { return int(t * 1000 + 0.5) }

BEGIN { FS = "," }
FNR == 1 {
  file++
  time = column_of("time_s"); gain = column_of("gain"); force = column_of("tau_a_l_x_n")
  elastic = column_of("tau_elastic_l_x_n"); limiters = column_of("limiters")
  next
}
file == 1 {
  at = tick($time)
  known[at] = 1; all[at] = $gain == 1; spring[at] = $elastic; felt[at] = $force
  next
}
{
  at = tick($time)
  if (!(at in known)) next
  # To the last tick with all of the force: what follows is two ends, not a delay.
  waiting = waiting sprintf("%.3f,%.4f,%.4f\n", $time, felt[at], $force)
  if (all[at] && $gain == 1) {
    if (curves != "") printf "%s", waiting > curves
    waiting = ""
  }
  if (!all[at] || $gain != 1 || (spring[at] == 0 && $elastic == 0)) next
  n++
  off = $elastic - spring[at]
  if (off < 0) off = -off
  squares += off * off
  if (off > most) most = off
  if (spring[at] > peak) peak = spring[at]
  if (-spring[at] > peak) peak = -spring[at]
  held += index($limiters, "ENERGY_TANK") > 0
}
END {
  if (broken) exit 6
  if (!n) { print "  no contact with a delay: nothing was felt"; exit 3 }
  printf "  %-17s force differs by %.2f N rms, %.2f N at most, of %.1f N; " \
         "held back in %.1f %% of contact\n", ms " ms round trip", sqrt(squares / n), most,
         peak, 100 * held / n
}
