# The demo's force without and with a delay, one on the other.
#
#   gnuplot -e "curves='CURVES.csv'; contact='PHASES'; output='delay'; ms=100" delay.gp
#
# Writes output.svg and output.png. Columns: server/demo/delay.awk.

if (!exists("font")) font = "DejaVu Sans"
blue = "#1f6fb4"; red = "#c8283c"; shade = "#eef1d8"; grey = "#404040"
set datafile separator ","

do for [kind in "svg png"] {
  if (kind eq "svg") {
    set terminal svg size 1280,720 font font.",14" background "white" enhanced
  } else {
    set terminal pngcairo size 1920,1080 font font.",17" background "white" enhanced linewidth 1.5
  }
  set output output.".".kind
  stats curves using 1 name "time" nooutput
  set multiplot
  set lmargin at screen 0.07; set rmargin at screen 0.985
  set xrange [time_min:time_max]
  set y2range [0:1]
  unset y2tics
  set border 3 linecolor rgb grey front
  set grid xtics ytics linecolor rgb "#d4d8dd" linewidth 0.6 linetype 1 back
  set tics nomirror out scale 0.5
  set style fill solid 1.0 noborder
  set offsets graph 0, graph 0, graph 0.04, graph 0.04
  set key top left Left reverse samplen 2 horizontal noautotitle

  set tmargin at screen 0.91; set bmargin at screen 0.36
  heading = "hapticd: the same grasp, the simulation here and %d ms away (round trip)"
  set label 1 sprintf(heading, ms) at screen 0.07, screen 0.955 left \
    font font.(kind eq "svg" ? ",19" : ",23")
  set format x ""
  set ylabel "motor force / N  (> 0 flexes)" offset 0.5,0
  plot contact using 1:(0):1:2:(0):(1) axes x1y2 with boxxyerror fillcolor rgb shade, \
       curves using 1:2 with lines linecolor rgb blue linewidth 4 title "simulation here", \
       curves using 1:3 with lines linecolor rgb red linewidth 1.4 \
         title sprintf("%d ms away", ms)

  unset label 1
  set tmargin at screen 0.32; set bmargin at screen 0.10
  set format x "%g"
  set xlabel "time / s" offset 0,0.4
  set ylabel "difference / N" offset 0.5,0
  set yrange [*<-1:1<*]
  plot contact using 1:(0):1:2:(0):(1) axes x1y2 with boxxyerror fillcolor rgb shade, \
       0 with lines linecolor rgb grey linewidth 0.6, \
       curves using 1:($3-$2) with lines linecolor rgb red linewidth 1.4
  unset multiplot
  unset output
  unset xlabel
  set yrange [*:*]
}
