# Torque of one newton at the actuator at each joint, and the condition of J, for both linkages.
# csv: haptic-report linkage --map.
load "style.gp"

names = "finger_same_sign finger_sign_change"
mine(i, v) = strcol("linkage") eq word(names, i) ? v : NaN

do for [kind in "svg png"] {
  eval begin(kind, 1300, 860)
  set multiplot layout 2,3 margins screen 0.045, screen 0.94, screen 0.07, \
    screen 0.93 spacing screen 0.12, screen 0.13
  set xrange [-20:90]
  set yrange [-10:110]
  unset key
  do for [i = 1:2] {
    set object 1 rectangle from 0,0 to 80,90 front fillstyle empty border lc rgb dark lw 1.4
    set xlabel "MCP / deg"
    set ylabel "PIP / deg" offset 1.5,0
    set palette defined (-20 "#7a0f1e", -5 "#d8505f", -0.001 "#f3b7be", 0.001 "#d7e6f5", \
      5 "#8fb9de", 20 "#1f6fb4")
    set cbrange [-20:20]
    set cblabel "w at the MCP / (mm/rad)"
    set title word(names, i) noenhanced
    plot csv using "mcp_deg":(mine(i, column("pip_deg"))):"w_mcp_mm_per_rad" \
      with points pt 5 ps 0.5 palette
    set cblabel "w at the PIP / (mm/rad)"
    plot csv using "mcp_deg":(mine(i, column("pip_deg"))):"w_pip_mm_per_rad" \
      with points pt 5 ps 0.5 palette
    set palette defined (1 "#1f6fb4", 5 "#9bc79a", 12 "#e8a13a", 30 "#7a0f1e")
    set cbrange [1:30]
    set cblabel "condition of J, l in 20 mm"
    plot csv using "mcp_deg":(mine(i, column("pip_deg"))):"condition" \
      with points pt 5 ps 0.5 palette
  }
  unset object 1
  unset multiplot
  unset output
}
