# Tick cost of a hand. csv: haptic-report scaling.
load "style.gp"

row_of(i, \
  all) = strcol("proxy") eq "held" && column("fingers_in_contact") == (all ? \
    column("fingers_declared") : 0) \
  ? of(word(methods, i), column("tick_ns")) : NaN

do for [kind in "svg png"] {
  eval begin(kind, 900, 520)
  set title "median tick / ns: all fingers in contact (full), none (open)"
  set xlabel "fingers declared"
  set xrange [0.5:5.5]
  set yrange [0:*]
  set xtics 1
  set key top left Left reverse
  plot for [i = 3:4] csv using "fingers_declared":(row_of(i, \
    1)) with points pt 7 ps 1.3 lc rgb hue(i) title word(titles, i), \
       for [i = 3:4] csv using "fingers_declared":(row_of(i, \
         0)) with points pt 6 ps 2.2 lw 2 lc rgb hue(i)
  unset output
}
