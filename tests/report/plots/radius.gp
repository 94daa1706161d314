# The passivity radius over the workspace. csv: haptic-report radius --all --map.
load "style.gp"

do for [kind in "svg png"] {
  eval begin(kind, 1300, 560)
  set multiplot layout 1,2 margins screen 0.05, screen 0.985, screen 0.12, \
    screen 0.9 spacing screen 0.12, screen 0
  set title "radius of the linearised method, Eq. (8), by pose"
  set xlabel "MCP / deg"
  set ylabel "PIP / deg" offset 1.5,0
  set palette defined (0 "#7a0f1e", 8 "#c8283c", 16 "#e8a13a", 24 "#9bc79a", 40 "#1f6fb4")
  set cbrange [0:40]
  set colorbox
  set cblabel "radius / deg"
  plot csv using (of("subspace_linear", \
    column("q_o1_mcp_deg"))):"q_o2_pip_deg":"radius_deg" with points pt 5 ps 0.35 palette
  unset colorbox
  set title "share of poses with a smaller radius"
  set xlabel "radius / deg"
  unset ylabel
  set xrange [0:60]
  set yrange [0:1]
  set key bottom right Left reverse
  plot for [i in "1 3 2"] csv using (of(word(methods, i + 0), \
    column("radius_deg"))):(1) smooth cnormal \
    with lines lc rgb hue(i + 0) lw 2.5 dashtype dashed(i == 2) title word(titles, i + 0)
  set xrange [*:*]
  set yrange [*:*]
  unset key
  unset multiplot
  unset output
}
