# Speed against error, in what a person notices: error of the felt torque by the client's delay,
# rate and kind of proxy, with published thresholds; what a tick costs; vibration in motion.
# csv: felt_grid.csv (kind of proxy, delay, error by rate); ticks: felt_two.csv; feel: feel.csv.
load "style.gp"

kinds = "held derived_planes planes contacts"
kind_names = "'held proxy' 'planes that the library derives in contact' " \
  . "'planes, sent before contact' 'contacts, with their curvature'"
kind_hues = "#d9660a #8e5bb5 #1f6fb4 #2a9d5c"
least = 0.3  # %, for what is less
shown(v) = v > least ? v : least
rows_of(i) = sprintf("< awk -F, 'NR == 1 || $1 == \"%s\"' '%s'", word(kinds, i), csv)
tick_of(i, v) = strcol("proxy") eq word(kinds, i) && strcol("method") eq "per_contact" \
  && column("rate_hz") == 60 ? v : NaN
clients = "held_late planes_late"
feel_hues = "#d9660a #1f6fb4"
weighted_of(i, v) = strcol("noise") eq "scene" && strcol("method") eq "per_contact" \
  && strcol("drive") eq "ideal" && strcol("group") eq "motion_".word(clients, i) ? v : NaN

do for [format in "svg png"] {
  eval begin(format, 1300, 540)
  set multiplot
  set lmargin at screen 0.065; set rmargin at screen 0.57
  set bmargin at screen 0.12; set tmargin at screen 0.80
  set title "Which proxy to send: how far is the felt torque off, and would a person notice?" \
    offset 0,3.3
  set logscale y
  set yrange [least:100]
  set xrange [-2:102]
  set format y "%g"
  set ytics (0.3, 1, 3, 10, 30, 100)
  set xlabel "delay from the device to the sample's arrival / ms" offset 0,0.4
  set ylabel "rms error of the felt torque, every tick / %" offset 0.5,0
  set key at screen 0.065, screen 0.905 top left reverse Left maxrows 2 width 2
  set object 1 rectangle from graph 0, first least to graph 1, first 3.6 fillcolor rgb "#eef6ee" \
    fillstyle solid noborder behind
  set label 1 "line: 60 Hz, band: 30 Hz to 1 kHz" at graph 0.02, first 0.36 left \
    textcolor rgb dark
  set label 2 "noticed from here on\n(predicted, no people took part):" at graph 1.015, first 55 \
    left textcolor rgb dark
  set label 3 "stiffness, 22 %, if the way varies\n(Tan et al. 1995)" at graph 1.015, first 22 \
    left textcolor rgb dark
  set label 4 "stiffness, 8 % (Tan et al. 1995)" at graph 1.015, first 9.4 left \
    textcolor rgb dark
  set label 5 "force, 7 %, pinched (Pang et al. 1991)" at graph 1.015, first 6.3 left \
    textcolor rgb dark
  set label 6 "force, 3.6 %, moved by the arm\n(Giacomin, Mackenzie 2001)" \
    at graph 1.015, first 3.6 left textcolor rgb dark
  set label 7 "not noticed" at graph 1.015, first 1.1 left textcolor rgb "#2a7a4c"
  plot for [i = 1:4] rows_of(i) using "delay_ms":(shown(column("1000"))):(shown(column("30"))) \
      with filledcurves lc rgb word(kind_hues, i) fillstyle transparent solid 0.13, \
    for [level in "3.6 7 8 22"] (level + 0.0) with lines lc rgb dark dashtype 2 lw 1, \
    for [i = 1:4] rows_of(i) using "delay_ms":(shown(column("60"))) with linespoints \
      lc rgb word(kind_hues, i) lw 2.5 pt 7 ps 0.7 title word(kind_names, i)
  unset object 1
  do for [i = 1:7] { unset label i }
  unset logscale y
  unset key
  set style fill solid 0.8
  set boxwidth 0.6
  unset xlabel
  set lmargin at screen 0.795; set rmargin at screen 0.99
  set bmargin at screen 0.6; set tmargin at screen 0.91
  set title "CPU per tick / us" offset 0,0
  unset ylabel
  set xrange [0.4:4.6]
  set yrange [0:*]
  set ytics auto
  set xtics ("held" 1, "derived" 2, "planes" 3, "contacts" 4) font ",11"
  plot for [i = 1:4] ticks using (i):(tick_of(i, column("tick_ns") / 1000)) with boxes \
    lc rgb word(kind_hues, i)
  set bmargin at screen 0.12; set tmargin at screen 0.4
  set title "vibration in motion / threshold\n(Bolanowski et al. 1988)"
  set xlabel "60 Hz, 20 ms late, 95 % of motions" offset 0,0.4
  set xrange [0.4:2.6]
  set yrange [0:*]
  set xtics ("held" 1, "planes" 2) font ""
  set arrow 1 from graph 0, first 1 to graph 1, first 1 nohead dashtype 2 lc rgb dark front
  plot for [i = 1:2] feel using (i):(weighted_of(i, column("weighted_95"))) with boxes \
    lc rgb word(feel_hues, i)
  unset arrow 1
  unset multiplot
  set xtics auto
  unset output
}
