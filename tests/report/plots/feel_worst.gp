# The ten runs of the study feel that are worst, tick by tick. csv: haptic-report feel --trace of
# each, one after the other; runs: "kind:index" of each.
load "style.gp"

kind(run) = word(runs, run)[1:strstrt(word(runs, run), ":") - 1]
number(run) = word(runs, run)[strstrt(word(runs, run), ":") + 1:*]
on(run, v) = strcol("kind") eq kind(run) && column("index") == number(run) + 0 ? v : NaN

do for [format in "svg png"] {
  eval begin(format, 1700, 620)
  set multiplot layout 2,5 title heading \
    margins screen 0.04, screen 0.99, screen 0.1, screen 0.87 spacing screen 0.025, screen 0.12
  set label 1 "━━ no noise, planes in every tick" at screen 0.28, screen 0.94 \
    textcolor rgb "#8a8f98"
  set label 2 "━━ without the tank" at screen 0.5, screen 0.94 textcolor rgb blue
  set label 3 "━━ felt" at screen 0.66, screen 0.94 textcolor rgb alarm
  do for [run = 1:words(runs)] {
    set title kind(run)." ".number(run)
    set ylabel ((run - 1) % 5 == 0 ? "force / N" : "") offset 1,0
    set xlabel (run > 5 ? "time / s" : "") offset 0,0.6
    plot csv using "t_s":(on(run, column("ideal_n"))) with lines lc rgb "#8a8f98" lw 3, \
         csv using "t_s":(on(run, column("untanked_n"))) with lines lc rgb blue lw 1.5, \
         csv using "t_s":(on(run, column("force_n"))) with lines lc rgb alarm lw 1
    do for [i = 1:3] { unset label i }
  }
  unset multiplot
  unset output
}
