# Force over time at 0 and 100 ms, one on the other. csv: haptic-report rtt --trace.
load "style.gp"

objects = "soft_wall finger_worn_reach_and_grasp"
object_names = "'soft wall' 'soft finger'"
from = "1.2 2"; to = "4.2 6.5"            # s
lowest = "-9 -2"; highest = "12.5 14.5"  # N
peers = "contacts derived_planes held"
peer_names = "'contacts' 'rigid planes of the client library' 'held proxy'"
peer_hues = "#1f6fb4 #8e5bb5 #d9660a"
at(o, i, ms, v) = strcol("object") eq word(objects, o) && strcol("peer") eq word(peers, i) \
  && column("round_trip_ms") == ms ? v : NaN

do for [kind in "svg png"] {
  eval begin(kind, 1500, 850)
  set multiplot layout 2,3 rowsfirst title \
    "The same touch: grey, the simulation is here; colour, it is 100 ms away" \
    margins screen 0.055, screen 0.985, screen 0.085, screen 0.9 spacing screen 0.035, screen 0.12
  do for [o = 1:2] {
    set xrange [word(from, o) + 0:word(to, o) + 0]
    set yrange [word(lowest, o) + 0:word(highest, o) + 0]
    set xlabel (o == 2 ? "time / s" : "")
    do for [i = 1:3] {
      set title word(object_names, o).", ".word(peer_names, i)
      set ylabel (i == 1 ? "force that pushes the finger out / N" : "") offset 0.5,0
      plot csv using "t_s":(at(o, i, 0, -column("felt_n"))) with lines lc rgb "#b8bcc4" lw 6, \
        csv using "t_s":(at(o, i, 100, -column("felt_n"))) with lines lc rgb word(peer_hues, i) \
        lw 1.6
    }
  }
  unset multiplot
  unset output
}
