# The 168 trajectories. csv: haptic-report scan --list; shares: haptic-report scan.
load "style.gp"

do for [kind in "svg png"] {
  eval begin(kind, 1300, 520)
  set multiplot layout 1,2 margins screen 0.06, screen 0.985, screen 0.14, \
    screen 0.9 spacing screen 0.07, screen 0
  set title "trajectories with any non-passive sample / %"
  set style data boxes
  set boxwidth 0.6
  set xrange [0.4:4.6]
  set yrange [0:100]
  set xtics ("standard" 1, "null-space" 2, "subspace\nlinear (8)" 3, \
    "subspace\nexact (6)" 4) scale 0
  set format x "%s"
  plot for [i = 1:4] shares using (i):(of(word(methods, i), column("share_pct"))) lc rgb hue(i), \
       for [i = 1:4] shares using (i):(of(word(methods, i), \
         column("share_pct"))):(sprintf("%.0f of 168", column("any_nonpassive"))) \
         with labels offset 0,0.7
  set title "share of trajectories whose cycle work is smaller"
  set xtics auto scale 0.5
  set format x "%g"
  set xrange [0:40]
  set yrange [0:1.02]
  set xlabel "|cycle work| / % of the peak spring energy"
  set key bottom right Left reverse
  plot for [i = 1:4] csv using (of(word(methods, i), \
    abs(column("cycle_work_pct")))):(1) smooth cnormal \
    with lines lc rgb hue(i) lw 2.5 title word(titles, i)
  unset xlabel
  unset key
  unset multiplot
  unset output
}
