# Error of touch behind a network over the round trip, a panel per object. csv: haptic-report rtt.
load "style.gp"

peers = "contacts estimated derived_planes held held_force tdpa"
peer_names = "'contacts' 'estimated from proxies' 'rigid planes of proxies' 'held proxy' " \
  . "'held force (not offered)' 'the same with TDPA (not offered)'"
peer_hues = "#1f6fb4 #2a9d5c #8e5bb5 #d9660a #8a8f98 #c8283c"
# One object of each kind; the tables have them all. What was not made is left out.
shown = "rigid_wall soft_wall soft_wall_2hz stiffening disc_70mm_s moving_soft two_fingers " \
  ."pushed_right_0.2kg pushed_disturbed_0.2kg pushed_wrong_double_2kg sliding_wrong_double_2kg " \
  ."pushed_own_steps_0.2kg two_fingers_2kg finger_worn_reach_and_grasp " \
  ."finger_worn_dfki_pillow_grasps_100hz"
names = "'rigid wall' 'soft wall' 'soft wall, 2 Hz' 'wall that stiffens' 'disc, stroked' " \
  ."'wall that moves by itself' 'block between two fingers' 'object that is pushed' " \
  ."'pushed, and disturbed' 'pushed, mass told double' 'sliding, mass told double' " \
  ."'pushed, client in coarse steps' 'two fingers on 2 kg' 'soft finger, grasp of the demo' " \
  ."'soft finger, recorded grasps'"
made = " ".system("awk -F, 'NR > 1 && !seen[$1]++ { printf(\"%s \", $1) }' '".csv."'")
objects = ""; titles = ""
do for [o = 1:words(shown)] {
  if (strstrt(made, " ".word(shown, o)." ") > 0) {
    objects = objects." ".word(shown, o)
    titles = titles." '".word(names, o)."'"
  }
}
least = 0.001  # %, for what is less
at(o, i, v) = strcol("object") eq word(objects, o) && strcol("peer") eq word(peers, i) \
  && column("rate_hz") == 60 && column("loss_pct") == 0 ? (v > least ? v : least) : NaN
columns = 5
rows = (words(objects) + columns - 1) / columns
do for [kind in "svg png"] {
  eval begin(kind, 1650, 140 + 330 * rows)
  set multiplot layout rows,columns rowsfirst title "How far is what a finger feels from " \
    ."the same object without delay? (rms in contact, 60 samples/s)" \
    margins screen 0.05, screen 0.985, screen 0.3 / rows, screen 1 - 0.2 / rows \
    spacing screen 0.025, screen 0.2 / rows
  do for [i = 1:words(peers)] {
    set label 30 + i "━━ ".word(peer_names, i) \
      at screen 0.05 + (i - 1) * 0.155, screen 0.06 / rows \
      textcolor rgb word(peer_hues, i)
  }
  set logscale y
  set yrange [least * 0.7:400]
  set xrange [-6:206]
  set xtics 50
  do for [o = 1:words(objects)] {
    set title word(titles, o)
    set xlabel (o + columns > words(objects) ? "round trip / ms" : "") offset 0,0.5
    set ylabel ((o - 1) % columns == 0 ? "error / % of peak" : "") offset 0.5,0
    set format y ((o - 1) % columns == 0 ? "%g" : "")
    plot 1 with lines lc rgb dark dashtype 2 lw 1, \
      for [i = words(peers):1:-1] csv using "round_trip_ms":(at(o, i, column("error_pct"))) \
      with linespoints lc rgb word(peer_hues, i) lw (i == 1 ? 3 : 1.5) pt 7 ps 0.6
    do for [i = 31:39] { unset label i }
  }
  unset multiplot
  unset output
}
