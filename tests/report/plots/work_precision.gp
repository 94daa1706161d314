# Error of q* against time per solve, one panel per map. csv: haptic-report work-precision.
load "style.gp"

maps = "finger hand tracked_hand chain"
panels = "'finger' 'hand, five fingers' 'hand on a tracked palm' 'chain of six joints'"
kinds = "eq8 _cold _warm lm_warm closed_form ceres cminpack"
names = "'Eq. (8)' 'Gauss-Newton 1-4, from q' 'Gauss-Newton 1-4, from the last q*' 'Levenberg-Marquardt' 'closed form' 'Ceres TinySolver' 'cminpack lmder'"
colours = "#1f6fb4 #8a8f98 #2a9d5c #8e5bb5 #101010 #d9660a #e8a13a"
colour(i) = word(colours, i)
# gn1_cold .. gn4_cold and gn1_warm .. are curves of Gauss-Newton; the other warm ones are points.
is_gn(m) = strlen(m) == 8 && m[1:2] eq "gn"
kind_is(i, m) = i == 1 ? m[1:3] eq "eq8" : i == 2 || i == 3 ? is_gn(m) && m[4:8] eq word(kinds, i) : \
  strstrt(m, word(kinds, i)) == 1
here(p, hz) = strcol("map") eq word(maps, p) && strcol("setting") eq hz
# An error of exactly 0 still wants a place on the log scale.
error(p, i, hz) = here(p, hz) && kind_is(i, strcol("method")) ? column("error_max") + 1e-18 : NaN

do for [kind in "svg png"] {
  eval begin(kind, 1300, 1000)
  set multiplot layout 2,2 margins screen 0.07, screen 0.98, screen 0.14, screen 0.95 spacing screen 0.08, screen 0.1
  set logscale xy
  set xrange [10:*]
  set format x "10^{%T}"
  set format y "10^{%T}"
  set xlabel "time per solve / ns"
  do for [i = 1:7] {
    set label 20 + i "● ".word(names, i) at screen 0.06 + 0.235 * ((i - 1) % 4), screen 0.055 - 0.03 * ((i - 1) / 4) textcolor rgb colour(i)
  }
  set label 28 "full: frames at 1 kHz; open, dashed: 60 Hz" at screen 0.06 + 0.235 * 3, screen 0.025
  unset key
  do for [p = 1:4] {
    set title word(panels, p).(p < 4 ? ": largest error of l_x / m" : ": largest error of an angle / rad")
    plot for [i = 2:3] csv using "ns":(error(p, i, "1000 Hz")) with linespoints lc rgb colour(i) lw 2 pt 7 ps 0.9, \
      for [i = 2:3] csv using "ns":(error(p, i, "60 Hz")) with linespoints lc rgb colour(i) lw 1.2 dashtype 2 pt 6 ps 0.9, \
      for [i in "1 4 5 6 7"] csv using "ns":(error(p, i + 0, "1000 Hz")) with points lc rgb colour(i + 0) pt 7 ps 1.3, \
      for [i in "1 4 5 6 7"] csv using "ns":(error(p, i + 0, "60 Hz")) with points lc rgb colour(i + 0) pt 6 ps 1.6 lw 2
    do for [i = 1:8] { unset label 20 + i }
  }
  unset logscale
  set autoscale x
  set format "%g"
  unset multiplot
  unset output
}
