# An underactuated device against a fully actuated one, by the client's metric. csv: haptic-report
# coupling.
load "style.gp"
set datafile missing "none"  # a nan, where the finger leaves the workspace, is a gap

stops = "mcp pip oblique both"
stop_names = "'MCP stop' 'PIP stop' 'oblique, 0.6 MCP + 0.8 PIP' 'MCP + PIP'"
metrics = "identity eps_1 eps_0.1 eps_0.01 eps_0.001"
poses = "30,30 60,70 10,40"
pose_hues = "#1f6fb4 #d9660a #2a9d5c"
place(m) = m eq "identity" ? 1 : m eq "eps_1" ? 2 : m eq "eps_0.1" ? 3 : m eq "eps_0.01" ? 4 : 5
stiffnesses = "1500 6000"
# One curve's rows alone: else lines would join those of other presses.
only(s, p, k) = "< awk -F, 'NR == 1 || ($3 == \"".word(stops, \
  s)."\" && $1 \",\" $2 == \"".word(poses, p) \
  ."\" && $4 == ".word(stiffnesses, k)." && $5 == 10)' '".csv."'"
foot_of(p) = \
  sprintf("set label %d '━━ pose %s deg' at screen %f, screen 0.035 textcolor rgb '%s'; ", 30 + p, \
  word(poses, p), 0.05 + (p - 1) * 0.13, word(pose_hues, p))

do for [kind in "svg png"] {
  eval begin(kind, 1500, 820)
  set multiplot layout 2,4 rowsfirst title \
    "Meant 10 deg behind the plane: full, 1500 N/m; dashed, 6000 N/m" \
    margins screen 0.055, screen 0.985, screen 0.15, screen 0.9 spacing screen 0.035, screen 0.07
  do for [p = 1:3] { eval foot_of(p) }
  set label 40 \
    "grey: a device that drives both DoFs; above the red line the force pulls the " \
  . "finger in; a gap: out of the workspace" \
    at screen 0.44, screen 0.035 textcolor rgb dark
  set xrange [0.7:5.3]
  set xtics ("W = I" 1, "ε 1" 2, "0.1" 3, "0.01" 4, "0.001" 5)
  do for [row = 1:2] {
    do for [s = 1:4] {
      set title (row == 1 ? word(stop_names, s) : "")
      if (row == 1) { set logscale y; set yrange [0.002:40]; unset arrow }
      if (row == 2) { unset logscale y; set yrange [0:16]; set arrow 1 from 0.7,10 to 5.3,10 \
        nohead lc rgb alarm lw 1.5 }
      set ylabel (s > 1 ? "" : row == 1 ? "force error of the actuator" : "depth at rest / deg") \
        offset 0.5,0
      if (row == 1) {
        plot for [p = 1:3] for [k = 1:2] only(s, p, \
          k) using (place(strcol("metric"))):"force_error" \
          with linespoints lc rgb word(pose_hues, p) lw 2 pt 7 ps 0.5 dashtype dashed(k == 2)
      } else {
        plot for [p = 1:3] for [k = 1:2] only(s, p, \
          k) using (place(strcol("metric"))):"end_full_deg" \
            with lines lc rgb "#b4b8be" lw 1.2 dashtype dashed(k == 2), \
          for [p = 1:3] for [k = 1:2] only(s, p, k) using (place(strcol("metric"))):"end_deg" \
            with linespoints lc rgb word(pose_hues, p) lw 2 pt 7 ps 0.5 dashtype dashed(k == 2)
      }
      do for [i = 31:33] { unset label i }
      unset label 40
    }
  }
  unset arrow
  unset multiplot
  unset output
}
