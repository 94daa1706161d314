# Error and time of a small least-squares solve. csv: haptic-report linear-algebra.
load "style.gp"

solvers = "normal_equations own_qr eigen_householder_qr eigen_col_piv_qr eigen_cod eigen_jacobi_svd lapack_dgelsy lapack_dgelsd"
names = "'normal equations' 'own QR' 'Eigen HouseholderQR' 'Eigen ColPivQR' 'Eigen COD' 'Eigen JacobiSVD' 'LAPACK dgelsy' 'LAPACK dgelsd'"
colours = "#c8283c #1f6fb4 #2a9d5c #7fbf7b #d9660a #e8a13a #8e5bb5 #8a8f98"
colour(i) = word(colours, i)
wide(i) = i == 2 ? 3.5 : 1.6  # ours above the others
solver_is(i) = strcol("method") eq word(solvers, i)
shape(m, n, v) = column("rows") == m && column("cols") == n ? v : NaN

do for [kind in "svg png"] {
  eval begin(kind, 1400, 600)
  set multiplot layout 1,2 margins screen 0.06, screen 0.985, screen 0.13, screen 0.92 spacing screen 0.07, screen 0
  set logscale xy
  set format x "10^{%T}"
  set format y "10^{%T}"
  set title "6x6: largest relative error of 40 solves"
  set xlabel "condition number of J"
  set yrange [1e-17:1e4]
  set key top left Left reverse
  plot for [i = 1:8] csv using (shape(6, 6, column("cond"))):(solver_is(i) ? column("max_relative_error") : NaN) \
    with linespoints lc rgb colour(i) lw wide(i) pt 7 ps 0.4 title word(names, i), \
    x * 2.2e-16 with lines lc rgb dark dashtype 3 title "ε cond(J)"
  unset logscale x
  unset key
  set title "time per solve at cond 10 / ns"
  unset xlabel
  set xrange [0.4:4.6]
  set yrange [5:3e5]
  set format y "%g"
  set format x "%s"
  set xtics ("2x2" 1, "6x2" 2, "6x6" 3, "27x10" 4) scale 0
  at(m, n, k) = column("rows") == m && column("cols") == n && column("cond") == 10 ? k : NaN
  place(i) = (i - 4.5) * 0.1
  size_of(i) = solver_is(i) ? (column("rows") == 2 ? 1 : column("rows") == 27 ? 4 : column("cols") == 2 ? 2 : 3) + place(i) : NaN
  set boxwidth 0.09
  plot for [i = 1:8] csv using (column("cond") == 10 ? size_of(i) : NaN):"ns" with boxes lc rgb colour(i)
  set xtics auto scale 0.5
  unset logscale
  set xrange [*:*]
  set yrange [*:*]
  set format "%g"
  unset multiplot
  unset output
}
