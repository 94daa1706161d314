# Error of q* against time per solve on hard frames. csv: haptic-report work-precision. A method is
# in the legend if the file has rows of it.
load "style.gp"

names = "eq8 eq6 iteration damped_least_squares kdl_lma"
long_names = "'Eq. (8)' 'Eq. (6) as rendered' 'its iteration, 1 to 100 steps' " \
  . "'damped least squares, 1 to 100 steps' 'LMA of KDL, 1 to 100 steps'"
colours = "#1f6fb4 #2a9d5c #101010 #8a8f98 #d9660a"
maps = "finger arm"
kinds = "random near_singular at_the_box unreachable at_ties"
kind_names = "'random' 'near singular' 'at the box' 'unreachable' 'at ties'"
rows_of(m, k, i) = system(sprintf("awk -F, '\"%s\" ~ $1 && \"%s\" ~ $2 && $3 == \"%s\"' " \
  . "'%s' | wc -l", m, k, word(names, i), csv)) + 0
at(m, k, i, v) = strcol("map") eq word(maps, m) && strcol("frames") eq word(kinds, k) \
  && strcol("method") eq word(names, i) ? v : NaN
# A method's rows one after the other: lines break at rows that are left out.
file_of(m, k, i) = sprintf("< awk -F, 'NR == 1 || ($1 == \"%s\" && $2 == \"%s\" && " \
  . "$3 == \"%s\")' '%s'", word(maps, m), word(kinds, k), word(names, i), csv)
least = 1e-17  # for an error of exactly 0

do for [kind in "svg png"] {
  eval begin(kind, 1700, 820)
  set multiplot layout 2,5 rowsfirst title \
    "Residual above the least against time per solve; every solve is cold; " \
      . "full: 95th percentile of the frames, open: median" \
    margins screen 0.055, screen 0.985, screen 0.15, screen 0.91 spacing screen 0.022, screen 0.09
  place = 0
  do for [i = 1:words(names)] {
    if (rows_of(maps, kinds, i) > 0) {
      set label 30 + i "●━ ".word(long_names, i) at screen 0.04 + place * 0.19, screen 0.035 \
        textcolor rgb word(colours, i)
      place = place + 1
    }
  }
  set logscale xy
  set format x "10^{%T}"
  set format y "10^{%T}"
  set xrange [30:3e6]
  set yrange [least * 0.3:10]
  do for [m = 1:2] {
    do for [k = 1:5] {
      set title (m == 1 ? word(kind_names, k) : "")
      set xlabel (m == 2 ? "time per solve / ns" : "")
      set ylabel (k > 1 ? "" : m == 1 ? "finger / rad" : "arm / m")
      here = ""
      do for [i = 1:words(names)] {
        if (rows_of(word(maps, m), word(kinds, k), i) > 0) { here = here." ".i }
      }
      if (here ne "") {
        plot for [j in here] file_of(m, k, int(j)) using "ns": \
          (at(m, k, int(j), column("excess_median") + least)) with linespoints \
          lc rgb word(colours, int(j)) lw 1 dashtype 2 pt 6 ps 1.1, \
          for [j in here] file_of(m, k, int(j)) using "ns": \
          (at(m, k, int(j), column("excess_p95") + least)) with linespoints \
          lc rgb word(colours, int(j)) lw 1.6 pt 7 ps 0.8
      } else {
        set label 50 "no such frames" at graph 0.5, 0.5 center
        plot NaN
        unset label 50
      }
      do for [i = 31:35] { unset label i }
    }
  }
  unset logscale
  unset multiplot
  unset output
}
