# The figure of the demo with a hand: the force of each finger's motor, and how many contacts hold.
#
#   gnuplot -e "data='DECIMATED.csv'; contact='PHASES'; output='figure'; method='subspace_exact';
#               heading='...'" hand.gp
#
# Writes output.svg and output.png. Columns: server/owner/telemetry/recorder.hpp.

if (!exists("font")) font = "DejaVu Sans"
fingers = "thumb index middle ring little"
hues = "#c8283c #1f6fb4 #2a9d5c #d9660a #8e5bb5"
shade = "#eef1d8"; grey = "#404040"
set datafile separator ","

# The held contacts are listed as "0|3|4".
held(list) = strlen(list) == 0 ? 0 : words(list)
split(list) = (o = "", sum [i = 1:strlen(list)] (o = o.(list[i:i] eq "|" ? " " : list[i:i]), 0), o)

do for [kind in "svg png"] {
  if (kind eq "svg") {
    set terminal svg size 1280,820 font font.",14" background "white" enhanced
  } else {
    set terminal pngcairo size 1920,1230 font font.",17" background "white" enhanced linewidth 1.5
  }
  set output output.".".kind
  stats data using "time_s" name "time" nooutput
  set multiplot layout 6,1 margins screen 0.07, screen 0.985, screen 0.075, screen 0.92 \
    spacing screen 0.0, screen 0.018
  set label 1 heading.", force of each motor (> 0 flexes)" at screen 0.07, screen 0.965 left \
    font font.(kind eq "svg" ? ",19" : ",23")
  set xrange [time_min:time_max]
  set y2range [0:1]
  unset y2tics
  set border 3 linecolor rgb grey front
  set grid xtics ytics linecolor rgb "#d4d8dd" linewidth 0.6 linetype 1 back
  set tics nomirror out scale 0.5
  set ytics autofreq
  set style fill solid 1.0 noborder
  set offsets graph 0, graph 0, graph 0.06, graph 0.06
  set format x ""
  unset key
  set yrange [*:*]
  least = 0; most = 0
  do for [i = 1:5] {
    stats data using "tau_a_".word(fingers, i).".l_x_n" name "tau" nooutput
    if (tau_min < least) { least = tau_min }
    if (tau_max > most) { most = tau_max }
  }
  set yrange [1.1 * least:1.1 * most + 0.1]
  do for [i = 1:5] {
    set ylabel word(fingers, i)." / N" offset 0.5,0
    plot contact using 1:(0):1:2:(0):(1) axes x1y2 with boxxyerror fillcolor rgb shade, \
         0 with lines linecolor rgb grey linewidth 0.6, \
         data using "time_s":(column("tau_a_".word(fingers, i).".l_x_n")) \
           with lines linecolor rgb word(hues, i) linewidth 2
    unset label 1
  }
  set format x "%g"
  set xlabel "time / s" offset 0,0.4
  set ylabel "contacts" offset 0.5,0
  set yrange [0:*]
  plot contact using 1:(0):1:2:(0):(1) axes x1y2 with boxxyerror fillcolor rgb shade, \
       data using "time_s":(held(split(strcol("active_planes")))) \
         with steps linecolor rgb grey linewidth 2
  unset multiplot
  unset output
  unset xlabel
}
