# The presses of core/METHOD.md#forces-at-the-finger. csv: haptic-report finger --trace, with or
# without --guard.
load "style.gp"

stops_mcp = "18 18 999 18"; stops_pip = "999 999 25 25"; stiffness = "1500 6000 1500 1500"
names = "'MCP stopped at 18°, 1500 N/m' 'MCP stopped at 18°, 6000 N/m' " \
  . "'PIP stopped at 25°, 1500 N/m' 'both stopped, 1500 N/m'"
row_is(r) = column("stop_mcp_deg") == word(stops_mcp, \
  r) + 0 && column("stop_pip_deg") == word(stops_pip, r) + 0 \
  && column("stiffness_n_per_m") == word(stiffness, r) + 0
at(r, i, v) = row_is(r) ? of(word(methods, i), v) : NaN

do for [kind in "svg png"] {
  eval begin(kind, 1600, 1120)
  set multiplot layout 3,4 columnsfirst title heading offset 0,-0.3 \
    margins screen 0.055, screen 0.99, screen 0.085, screen 0.91 spacing screen 0.035, screen 0.075
  eval foot(0.2)
  do for [r = 1:4] {
    set title word(names, r)
    set xrange [0:80]
    set yrange [0:90]
    set xlabel "MCP / deg" offset 0,0.6
    set ylabel (r == 1 ? "PIP / deg" : "") offset 0.5,0
    unset key
    set arrow 1 from word(stops_mcp, r), graph 0 to word(stops_mcp, r), \
      graph 1 nohead lc rgb alarm lw 1.5 dashtype 2
    set arrow 2 from graph 0, first (word(stops_pip, r) + 0) to graph 1, first (word(stops_pip, \
      r) + 0) nohead lc rgb alarm lw 1.5 dashtype 2
    set label 1 "" at 50, 50 point pt 2 ps 1.5 lw 2 lc rgb dark
    plot for [i = 1:4] csv every 5 using (at(r, i, \
      column("mcp_deg"))):"pip_deg" with lines lc rgb hue(i) lw 2
    eval foot_off
    unset arrow 1; unset arrow 2; unset label 1
    unset title
    set xrange [0:2]
    set yrange [-20:45]
    set xlabel "time / s" offset 0,0.6
    set ylabel (r == 1 ? "force at the actuator / N" : "") offset 0.5,0
    plot for [i = 1:4] csv every 5 using "t_s":(at(r, i, \
      column("force_n"))) with lines lc rgb hue(i) lw 2
    set yrange [-320:320]
    set ylabel (r == 1 ? "torque at MCP (full), PIP (dotted) / N mm" : "") offset 0.5,0
    plot for [i = 1:4] csv every 5 using "t_s":(at(r, i, \
      column("mcp_torque_nmm"))) with lines lc rgb hue(i) lw 2, \
         for [i = 1:4] csv every 5 using "t_s":(at(r, i, \
           column("pip_torque_nmm"))) with lines lc rgb hue(i) lw 2 dashtype 3
  }
  unset multiplot
  unset output
}
