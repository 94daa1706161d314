# A wall behind a slow or late client. csv: haptic-report rate; cycles: haptic-report rate --cycles.
load "style.gp"

kinds = "held_force held extrapolated planes derived_planes"
kind_hues = "#8a8f98 #1f6fb4 #d9660a #2a9d5c #8e5bb5"
kind_names = \
  "'held force (not offered)' 'held proxy' " \
  . "'extrapolated (not offered)' 'planes' 'planes in contact alone'"
rates = "30 60 200 1000"
at(i, r, w, v) = strcol("proxy") eq word(kinds, i) && column("rate_hz") == word(rates, r) + 0 \
  && strcol("with") eq w ? v : NaN
foot_of(i) = sprintf("set label %d '━━ %s' at screen %f, screen 0.03 textcolor rgb '%s'; ", \
  30 + i, \
  word(kind_names, i), 0.04 + (i - 1) * 0.19, word(kind_hues, i))
# Lines break at rows that are left out: those of the other stiffness are taken out before.
at500 = "< awk -F, 'NR == 1 || $5 == 500' '".cycles."'"

do for [kind in "svg png"] {
  eval begin(kind, 1500, 1350)
  set multiplot layout 4,4 rowsfirst title \
    "A wall behind a slow or late client: full, nothing; dashed, with the tank" \
    margins screen 0.06, screen 0.985, screen 0.09, screen 0.93 spacing screen 0.035, screen 0.055
  do for [i = 1:5] { eval foot_of(i) }
  set xrange [-3:103]
  do for [row = 1:4] {
    do for [r = 1:4] {
      set title (row == 1 ? word(rates, r)." Hz" : "")
      set xlabel (row == 4 ? "delay / ms" : "") offset 0,0.6
      unset logscale y
      set format y "%g"
      if (row <= 2) { set logscale y; set yrange [20:9000] }
      if (row == 3) { set yrange [0:4.5] }
      if (row == 4) { set logscale y; set yrange [1e-2:1e5]; set format y "10^{%L}" }
      set ylabel (r > 1 ? "" : row == 1 ? "K_{max}, steady press / N/m" : row == 2 ? \
        "K_{max}, in and out / N/m" : \
        row == 3 ? "drag at 500 N/m / N" : "net energy at 500 N/m / mJ") offset 0.5,0
      column_of = row == 1 ? "k_max_press_n_per_m" : row == 2 ? "k_max_cycles_n_per_m" : row == 3 \
        ? "drag_n" : "net_mj"
      file = row <= 2 ? csv : at500
      plot for [i = 1:5] for [w in "nothing tank"] file using \
        "delay_ms":(at(i, r, w, column(column_of))) \
        with linespoints lc rgb word(kind_hues, i) lw 2 pt 7 ps 0.5 dashtype dashed(w eq "tank")
      do for [i = 31:35] { unset label i }
    }
  }
  unset multiplot
  unset output
}
