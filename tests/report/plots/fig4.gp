# The paper's Fig. 4: motion, force, theoretical and measured impedance. csv: haptic-report fig4
# --series.
load "style.gp"
if (!exists("from")) { from = 0; to = 4 }

do for [kind in "svg png"] {
  eval begin(kind, 1760, 500)
  set multiplot layout 1,4 title heading offset 0,-0.3 margins screen 0.035, screen 0.992, \
    screen 0.2, screen 0.83 \
    spacing screen 0.045, screen 0
  set xrange [from:to]
  set xlabel "time / s"
  set title "joint angles / deg"
  eval foot(0.28)
  set key top left
  plot csv using "t_s":(of("standard", \
    column("q_o1_mcp_deg"))) with lines lc rgb blue lw 2 title "MCP", \
       csv using "t_s":(of("standard", \
         column("q_o2_pip_deg"))) with lines lc rgb orange lw 2 title "PIP"
  eval foot_off
  unset key
  set title "force τ_a / mm of l_x (Z_q = 1)"
  plot for [i = 1:4] csv using "t_s":(of(word(methods, i), \
    column("tau_mm"))) with lines lc rgb hue(i) lw 2
  set yrange [-2:2]
  set object 1 rectangle from graph 0, first 0 to graph 1, graph 1 fillcolor rgb alarm_shade behind
  set label 1 "not passive" at graph 0.98, graph 0.96 right textcolor rgb alarm
  set title "impedance by Eq. (2), (5), (9)"
  plot for [i = 1:4] csv using "t_s":(of(word(methods, i), \
    column("theory"))) with lines lc rgb hue(i) lw 2 \
    dashtype dashed(i == 3)
  set title "measured: Δτ_a / Δq_a"
  plot for [i = 1:4] csv using "t_s":(of(word(methods, i), \
    column("measured"))) with points pt 7 ps 0.25 lc rgb hue(i)
  unset object 1
  unset label 1
  set yrange [*:*]
  unset multiplot
  unset output
}
