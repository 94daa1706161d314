# Random presses, tests/report/STUDY.md#presses. csv: haptic-report press; heading: the linkage.
load "style.gp"

press_methods = methods." per_contact"
press_titles = titles." 'per contact'"
press_hues = hues." #d9660a"
share(end1, end2, without1, without2) = 100.0 * (1.0 - (above(end1) + above(end2)) \
  / (above(without1) + above(without2)))
above(v) = v > 0.0 ? v : 0.0
# A cumulative curve needs the rows of its method alone: a row left out would end it.
of_method(i) = sprintf("< awk -F, 'NR == 1 || $2 == \"%s\"' '%s'", word(press_methods, i), csv)

do for [kind in "svg png"] {
  eval begin(kind, 1500, 460)
  set multiplot layout 1,3 title heading offset 0,-0.3 \
    margins screen 0.055, screen 0.99, screen 0.14, screen 0.88 spacing screen 0.045, screen 0.1
  set yrange [0:1]
  set ylabel "share of presses"
  set key bottom right
  set xrange [-10:60]
  set xlabel "depth that the force takes away / %"
  plot for [i = 1:5] of_method(i) using (share(column("end_1_deg"), column("end_2_deg"), \
    column("without_1_deg"), column("without_2_deg"))):(1.0) smooth cnormal \
    with lines lc rgb word(press_hues, i) lw 2 title word(press_titles, i)
  set ylabel ""
  set xrange [-6:2]
  set xlabel "deeper than without force, at the end / deg"
  unset key
  plot for [i = 1:5] of_method(i) using (column("deeper_deg")):(1.0) smooth cnormal \
    with lines lc rgb word(press_hues, i) lw 2
  set xrange [0:100]
  set xlabel "contact throttled by the tank / % of ticks"
  plot for [i = 1:5] of_method(i) using (100.0 * column("throttled_ticks") \
    / column("contact_ticks")):(1.0) smooth cnormal with lines lc rgb word(press_hues, i) lw 2
  unset multiplot
  unset output
}
