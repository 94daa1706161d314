# The ten runs of the study feel that are worst, tick by tick. csv: haptic-report feel --trace of
# each, one after the other; runs: "kind:index" of each.
load "style.gp"

kind(run) = word(runs, run)[1:strstrt(word(runs, run), ":") - 1]
number(run) = word(runs, run)[strstrt(word(runs, run), ":") + 1:*]
on(run, v) = strcol("kind") eq kind(run) && column("index") == number(run) + 0 ? v : NaN

do for [format in "svg png"] {
  eval begin(format, 1700, 620)
  set multiplot layout 2,5 title heading offset 0,-0.3 \
    margins screen 0.04, screen 0.99, screen 0.1, screen 0.88 spacing screen 0.025, screen 0.12
  set key center center reverse Left
  do for [run = 1:words(runs)] {
    set title kind(run)." ".number(run)
    set ylabel ((run - 1) % 5 == 0 ? "force / N" : "") offset 1,0
    set xlabel (run > 5 ? "time / s" : "") offset 0,0.6
    plot csv using "t_s":(on(run, column("ideal_n"))) with lines lc rgb "#8a8f98" lw 3 \
           title (run == 1 ? "no noise, planes in every tick" : ""), \
         csv using "t_s":(on(run, column("untanked_n"))) with lines lc rgb blue lw 1.5 \
           title (run == 1 ? "without the tank" : ""), \
         csv using "t_s":(on(run, column("force_n"))) with lines lc rgb alarm lw 1 \
           title (run == 1 ? "felt" : "")
  }
  unset multiplot
  unset output
}
