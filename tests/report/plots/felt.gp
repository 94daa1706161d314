# Felt torque against CPU per tick. csv: haptic-report felt; fronts: its rows that no other row of
# the same client's rate and delay beats in both, with the figure's name in front.
load "style.gp"

palette = "#8a8f98 #8e5bb5 #1f6fb4 #2a9d5c #d9660a #c8283c #101010 #e8a13a"
renderers = system("awk -F, 'NR > 1 && !seen[$1]++ { print $1 }' '".csv."'")
proxies = system("awk -F, 'NR > 1 && !seen[$2]++ { print $2 }' '".csv."'")
symbols = "7 5 9 13 11 15"
symbol(k) = int(word(symbols, k))
rates = "1000 200 60 30"; delays = "0 20 20 100"
figures = "error error_all_ticks over_best"; least = 0.01  # %, for what is exactly 0
here(c) = strcol("of") eq "all" && column("rate_hz") == word(rates, c) + 0 \
  && column("delay_ms") == word(delays, c) + 0
of_both(c, i, k, v) = here(c) && strcol("method") eq word(renderers, i) \
  && strcol("proxy") eq word(proxies, k) ? v : NaN
shown(v) = v > least ? v : least

do for [kind in "svg png"] {
  eval begin(kind, 1500, 1200)
  set multiplot layout 3,4 rowsfirst title \
    "Felt torque against the cost of a tick (rings: no other is both cheaper and nearer)" \
    margins screen 0.055, screen 0.985, screen 0.115, screen 0.94 spacing screen 0.03, screen 0.07
  do for [i = 1:words(renderers)] {
    set label 30 + i "━━ ".word(renderers, i) noenhanced \
      at screen 0.04 + (i - 1) * 0.16, screen 0.045 textcolor rgb word(palette, i)
  }
  do for [k = 1:words(proxies)] {
    set label 40 + k "    ".word(proxies, k) noenhanced \
      at screen 0.04 + (k - 1) * 0.16, screen 0.02 point pt symbol(k) ps 1.3 lc rgb dark
  }
  set logscale y
  set yrange [least * 0.7:1000]
  set xrange [*:*]
  set offsets graph 0.08, graph 0.08, 0, 0
  set xtics 100
  do for [row = 1:3] {
    figure = word(figures, row)
    do for [c = 1:4] {
      set title (row == 1 ? word(rates, c)." Hz, ".word(delays, c)." ms" : "")
      set xlabel (row == 3 ? "CPU per tick / ns" : "")
      set ylabel (c > 1 ? "" : row == 1 ? "rms error / %" \
        : row == 2 ? "the same, limiter ticks too / %" \
        : "rms error over the device's best / %") offset 0.5,0
      plot for [i = 1:words(renderers)] for [k = 1:words(proxies)] csv using \
        "tick_ns":(of_both(c, i, k, shown(column(figure."_pct")))): \
        "tick_lower_ns":"tick_upper_ns":(shown(column(figure."_lower_pct"))): \
        (shown(column(figure."_upper_pct"))) with xyerrorbars lc rgb word(palette, i) lw 1.2 \
        pt symbol(k) ps 1.1, \
        fronts using "tick_ns":(here(c) && strcol("figure") eq figure \
          ? shown(column(figure."_pct")) : NaN) with points pt 6 ps 2.4 lw 1.5 lc rgb dark
      do for [i = 31:46] { unset label i }
    }
  }
  unset multiplot
  unset output
}
