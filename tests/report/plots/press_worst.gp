# Ten presses, tick by tick. csv: haptic-report press --trace of each, one after the other;
# presses: their numbers.
load "style.gp"

on(p, v) = column("press") == p + 0 && column("t_s") > -0.1 ? v : NaN

do for [kind in "svg png"] {
  eval begin(kind, 1700, 900)
  set multiplot layout 4,5 title heading offset 0,-0.3 \
    margins screen 0.04, screen 0.99, screen 0.07, screen 0.93 spacing screen 0.025, screen 0.055
  do for [half = 0:1] {
    set key top left
    do for [k = 1:5] {
      n = word(presses, 5 * half + k)
      set title "press ".n
      set ylabel (k == 1 ? "depth / deg" : "") offset 1,0
      plot csv using (on(n, column("t_s"))):"depth_1_deg" with lines lc rgb blue lw 2 \
             title (k == 1 ? "first wall" : ""), \
           csv using (on(n, column("t_s"))):"depth_2_deg" with lines lc rgb orange lw 2 \
             title (k == 1 ? "second wall" : "")
    }
    unset title
    do for [k = 1:5] {
      n = word(presses, 5 * half + k)
      set ylabel (k == 1 ? "force / N" : "") offset 1,0
      set xlabel (half == 1 ? "time / s" : "") offset 0,0.6
      plot csv using (on(n, column("t_s"))):"optimum_n" with lines lc rgb "#8a8f98" lw 2 \
             title (k == 1 ? "best possible" : ""), \
           csv using (on(n, column("t_s"))):"force_n" with lines lc rgb alarm lw 1.5 \
             title (k == 1 ? "rendered" : "")
    }
  }
  unset multiplot
  unset output
}
