# The demo's figure: what the finger did, what the projection answered, what it felt like.
#
#   gnuplot -e "data='DECIMATED.csv'; contact='PHASES'; output='figure'; method='subspace_linear';
#               heading='...'" figure.gp
#
# Writes output.svg and output.png. Columns: server/owner/telemetry/recorder.hpp.

if (!exists("font")) font = "DejaVu Sans"
deg = 180.0 / pi
mm = 1000.0

# One hue per quantity; the proxy is the dark, dashed companion of what it belongs to.
blue = "#1f6fb4"; dark_blue = "#0b3558"
orange = "#d9660a"; dark_orange = "#7a3600"
grey = "#8a8f98"; green = "#2a9d5c"; purple = "#8e5bb5"; red = "#c8283c"
shade = "#eef1d8"

set datafile separator ","
set datafile missing "nan"

# Where a column is empty there is no proxy: a gap, not a line through it.
touching(v) = strcol("mode") eq "HELD" || \
  (strcol("mode") eq "PLANES" && strlen(strcol("active_planes")) > 0) ? v : NaN

names = "standard null_space subspace_linear subspace_exact"
titles = "'standard, Eq. (1)' 'null-space, Eq. (3)-(4)' ". \
         "'subspace linear, Eq. (8)' 'subspace exact, Eq. (6)'"
hues = grey." ".purple." ".blue." ".green
index_in_use = 0
do for [i = 1:4] { if (word(names, i) eq method) { index_in_use = i } }
in_use = index_in_use ? word(titles, index_in_use) : "rule per contact"

do for [kind in "svg png"] {
  if (kind eq "svg") {
    set terminal svg size 1280,960 font font.",14" background "white" enhanced
  } else {
    set terminal pngcairo size 1920,1440 font font.",17" background "white" enhanced linewidth 1.5
  }
  set output output.".".kind

  stats data using "time_s" name "time" nooutput
  set multiplot layout 3,1 margins screen 0.07, screen 0.755, screen 0.065, screen 0.93 \
    spacing screen 0.0, screen 0.035
  set label 1 heading at screen 0.07, screen 0.966 left font font.(kind eq "svg" ? ",19" : ",23")

  set xrange [time_min:time_max]
  set y2range [0:1]
  unset y2tics
  set border 3 linecolor rgb "#404040" front
  set grid xtics ytics linecolor rgb "#d4d8dd" linewidth 0.6 linetype 1 back
  set tics nomirror out scale 0.5
  set ylabel offset 0.5,0
  set key at screen 0.765, graph 1.0 left top Left reverse samplen 2 spacing 1.3 noautotitle
  set style fill solid 1.0 noborder
  set offsets graph 0, graph 0, graph 0.04, graph 0.04  # a line at a limit is not on the frame
  set format x ""

  set ylabel "joint angle / deg"
  plot contact using 1:(0):1:2:(0):(1) axes x1y2 \
         with boxxyerror fillcolor rgb shade title "in contact", \
       data using "time_s":(column("x_probe_q_o1_mcp_rad") * deg) \
         with lines linecolor rgb blue linewidth 1.8 title "MCP, finger (x_{probe})", \
       data using "time_s":(touching(column("x_q_o1_mcp_rad") * deg)) \
         with lines linecolor rgb dark_blue linewidth 2.4 dashtype (6,3) title "MCP, proxy (x)", \
       data using "time_s":(column("x_probe_q_o2_pip_rad") * deg) \
         with lines linecolor rgb orange linewidth 1.8 title "PIP, finger (x_{probe})", \
       data using "time_s":(touching(column("x_q_o2_pip_rad") * deg)) \
         with lines linecolor rgb dark_orange linewidth 2.4 dashtype (6,3) title "PIP, proxy (x)"

  unset label 1
  set ylabel "slider / mm"
  plot contact using 1:(0):1:2:(0):(1) axes x1y2 with boxxyerror fillcolor rgb shade, \
       data using "time_s":(column("l_x") * mm) \
         with lines linecolor rgb blue linewidth 1.8 title "slider (q_a = l_x)", \
       data using "time_s":(touching(column("q_star_l_x_m") * mm)) \
         with lines linecolor rgb dark_blue linewidth 2.4 dashtype (6,3) \
         title "subspace proxy (q_a^*)"

  set format x "%g"
  set xlabel "time / s" offset 0,0.4
  set ylabel "motor force / N  (> 0 flexes)"
  plot contact using 1:(0):1:2:(0):(1) axes x1y2 with boxxyerror fillcolor rgb shade, \
       0 with lines linecolor rgb "#404040" linewidth 0.6, \
       for [i = 1:4] data using (i == index_in_use ? NaN : column("time_s")) \
         :(column("tau_".word(names, i)."_l_x_n")) \
         with lines linecolor rgb word(hues, i) linewidth 1.4 \
         title (i == index_in_use ? "" : word(titles, i)), \
       data using "time_s":"tau_a_l_x_n" \
         with lines linecolor rgb red linewidth 2.2 title in_use.": τ_a"
  unset multiplot
  unset output
  unset xlabel
}
