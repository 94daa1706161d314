# Energy per cycle with a client in the loop. csv: haptic-report closed-loop; trace: the same
# --trace of the hand's cycle at an MCP stop, proxy held and sent every tick.
load "style.gp"

stops = "18/999 999/25 18/25"; stop_names = \
  "'MCP stopped at 18°' 'PIP stopped at 25°' 'both stopped'"
motions = "cycle hand"; motion_names = "'the device is led' 'the hand aims, the finger follows'"
withs = "nothing guard guard_tank"
all_methods = methods." q_metric"
all_hues = hues." #d9660a"
stop_is(s) = sprintf("%g/%g", column("stop_mcp_deg"), column("stop_pip_deg")) eq word(stops, s)
sent(m) = m == 5 ? strcol("proxy") eq "q_metric" && column("rate_hz") == 1000 \
  : strcol("proxy") eq "held" && column("rate_hz") == 1000
at(m, s, motion, direction, v) = strcol("method") eq word(all_methods, m) && sent(m) && stop_is(s) \
  && strcol("motion") eq motion && strcol("direction") eq direction ? v : NaN
place(m) = (strcol("with") eq word(withs, 1) ? 1 : strcol("with") eq word(withs, 2) ? 2 : \
  3) + (m - 3) * 0.15

do for [kind in "svg png"] {
  eval begin(kind, 1500, 1150)
  set multiplot layout 3,3 rowsfirst title \
    "Energy per cycle with a client in the loop (every tick, no delay)" \
    margins screen 0.06, screen 0.985, screen 0.1, screen 0.92 spacing screen 0.045, screen 0.08
  eval foot(0.06)
  set label 20 "━━ conservative in the metric of Q (rejected)" at screen 0.06, \
    screen 0.008 textcolor rgb word(all_hues, 5)
  set label 21 "● one way round   ○ the other" at screen 0.5, screen 0.008 textcolor rgb dark
  do for [motion = 1:2] {
    do for [s = 1:3] {
      set title word(stop_names, s).", ".word(motion_names, motion)
      set xrange [0.5:3.5]
      set xtics ("nothing" 1, "guard" 2, "guard, tank" 3)
      set yrange [*:*]
      set ylabel (s == 1 ? "net energy to the user per cycle / mJ" : "") offset 0.5,0
      set xlabel ""
      set xzeroaxis lc rgb dark lw 1
      plot for [m = 1:5] csv using (at(m, s, word(motions, motion), "forward", place(m))):"net_mj" \
             with points pt 7 ps 1.0 lc rgb word(all_hues, m), \
           for [m = 1:5] csv using (at(m, s, word(motions, motion), "reversed", \
             place(m))):"net_mj" \
             with points pt 6 ps 1.0 lw 1.5 lc rgb word(all_hues, m)
      if (motion == 1 && s == 1) { eval foot_off; unset label 20; unset label 21 }
    }
  }
  set xtics auto
  do for [w in "nothing guard guard_tank"] {
    set title "MCP stop, the hand's cycle the other way, with ".(w eq "guard_tank" ? \
      "guard and tank" : w)
    set xrange [0:4]
    set yrange [*:*]
    set xlabel "time / s" offset 0,0.6
    set ylabel (w eq "nothing" ? "net energy to the user / mJ" : "") offset 0.5,0
    plot for [i = 1:4] trace every 10 using "t_s":(strcol("with") eq w ? of(word(methods, i), \
      column("net_mj")) : NaN) \
      with lines lc rgb hue(i) lw 2
  }
  unset multiplot
  unset output
}
