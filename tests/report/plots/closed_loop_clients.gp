# The same behind a network: the hand's cycle, the worse direction by client. csv: haptic-report
# closed-loop.
load "style.gp"

stops = "18/999 999/25 18/25"; stop_names = \
  "'MCP stopped at 18°' 'PIP stopped at 25°' 'both stopped'"
clients = \
  "held/1000/0 held/60/0 held/60/20 held/200/20 held/30/50 " \
  . "planes/60/20 derived_planes/60/20"
stop_is(s) = sprintf("%g/%g", column("stop_mcp_deg"), column("stop_pip_deg")) eq word(stops, s)
client = 'sprintf("%s/%g/%g", strcol("proxy"), column("rate_hz"), column("delay_ms"))'
place(i) = (p = NaN, sum [c = 1:7] (@client eq word(clients, c) ? (p = c, 0) : 0), \
  p + (i - 2.5) * 0.15)
at(i, s, w, v) = strcol("motion") eq "hand" && stop_is(s) && strcol("with") eq w \
  && strcol("method") eq word(methods, i) ? v : NaN

do for [kind in "svg png"] {
  eval begin(kind, 1500, 1250)
  set multiplot layout 4,3 rowsfirst title "The hand's cycle behind a network, both directions" \
    margins screen 0.06, screen 0.985, screen 0.135, screen 0.93 spacing screen 0.045, screen 0.045
  eval foot(0.06)
  set xrange [0.5:7.5]
  set xtics ("" 1, "" 2, "" 3, "" 4, "" 5, "" 6, "" 7)
  set xzeroaxis lc rgb dark lw 1
  do for [row = 1:4] {
    w = row % 2 == 1 ? "nothing" : "guard_tank"
    figure = row <= 2 ? "most_net_mj" : "mean_force_n"
    do for [s = 1:3] {
      set title (row == 1 ? word(stop_names, s) : "")
      if (row == 2) { set yrange [-0.5:1] } else { set yrange [0:*] }
      set ylabel (s > 1 ? "" : (row <= 2 ? "most net energy / mJ" : "mean force / N"). \
        (w eq "nothing" ? ", nothing" : ", guard and tank")) offset 0.5,0
      if (row == 4) {
        set xtics ("held, 1 kHz" 1, "held 60 Hz" 2, "+ 20 ms" 3, "200 Hz, 20 ms" 4, \
          "30 Hz, 50 ms" 5, \
          "planes 60, 20" 6, "derived 60, 20" 7) rotate by 35 right
      }
      plot for [i = 1:4] csv using (at(i, s, w, place(i))):(column(figure)) \
        with points pt 7 ps 0.9 lc rgb hue(i)
      eval foot_off
    }
  }
  unset multiplot
  unset output
}
