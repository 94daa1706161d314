# How low the carriage's pivot may lie against the sign of w. csv: haptic-report linkage --trade.
load "style.gp"

found(v) = strcol("linkage") eq "search" ? v : NaN
mine(name, v) = strcol("linkage") eq name ? v : NaN
x = "column('lowest_pivot_mm')"

do for [kind in "svg png"] {
  eval begin(kind, 1300, 470)
  set multiplot layout 1,3 margins screen 0.05, screen 0.985, screen 0.14, \
    screen 0.91 spacing screen 0.07, screen 0
  set xlabel "lowest place of the pivot over the MCP axis / mm"
  set key bottom left Left reverse
  set title "share of the workspace / %"
  set yrange [0:102]
  plot csv using (found(@x)):"both_positive_pct" with linespoints pt 7 ps 0.6 lw 2 \
      lc rgb blue title "w_1, w_2 > 0", \
    csv using (found(@x)):"both_5mm_pct" with linespoints pt 7 ps 0.6 lw 2 \
      lc rgb orange title "w_1, w_2 ≥ 5 mm/rad", \
    csv using (mine("finger_same_sign", @x)):"both_positive_pct" with points pt 4 ps 1.6 lw 2 \
      lc rgb dark title "finger\\_same\\_sign", \
    csv using (mine("finger_sign_change", @x)):"both_positive_pct" with points pt 8 ps 1.6 lw 2 \
      lc rgb alarm title "finger\\_sign\\_change"
  set title "least w / (mm/rad)"
  set yrange [*:*]
  set key bottom left
  plot csv using (found(@x)):"least_w_mcp_mm_per_rad" with linespoints pt 7 ps 0.6 lw 2 \
      lc rgb blue title "at the MCP", \
    csv using (found(@x)):"least_w_pip_mm_per_rad" with linespoints pt 7 ps 0.6 lw 2 \
      lc rgb orange title "at the PIP", \
    csv using (mine("finger_same_sign", @x)):"least_w_mcp_mm_per_rad" with points pt 4 ps 1.6 \
      lw 2 lc rgb dark, \
    csv using (mine("finger_sign_change", @x)):"least_w_mcp_mm_per_rad" with points pt 8 ps 1.6 \
      lw 2 lc rgb alarm
  set title "condition of J, and the stroke in mm"
  set yrange [0:*]
  set key top right
  plot csv using (found(@x)):"condition_median" with linespoints pt 7 ps 0.6 lw 2 \
      lc rgb blue title "condition, median", \
    csv using (found(@x)):"condition_largest" with linespoints pt 7 ps 0.6 lw 2 dt 2 \
      lc rgb blue title "condition, largest", \
    csv using (found(@x)):"stroke_mm" with linespoints pt 7 ps 0.6 lw 2 \
      lc rgb orange title "stroke"
  unset multiplot
  unset output
}
