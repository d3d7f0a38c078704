# gnuplot designs.gp: designs.svg from designs.csv, the p95 error of the last n over that of Halton's points.
set terminal svg size 760,420 font "sans,12" background "white"
set output "designs.svg"
set datafile separator comma
set logscale x
set xrange [0.4:4]
set xtics (0.5, 0.7, 1, 1.4, 2, 3)
set xlabel "error of 125 states over that of Halton's points; 95 % over bodies"
set yrange [12.7:0.3]
set key right bottom
set grid x
set arrow from 1, graph 0 to 1, graph 1 nohead lc rgb "black"
samplers = "lattice farthest forefeel learner_nd learner_nd_curvature lola_voronoi cv_voronoi mepe smt_lhs smt_variance integrated_variance"
set ytics () nomirror
do for [i = 1:words(samplers)] { set ytics add (word(samplers, i) i) noenhanced }
row(name) = sum [i = 1:words(samplers)] (word(samplers, i) eq name ? i : 0)
here(model) = sprintf("<awk -F, '$1 == \"p95_percent of 125\" && $3 == \"%s\"' designs.csv", model)
last = 12    # column of the upper end
plot for [k = 1:3] here(word("cubic hermite jets", k)) \
  using (column(last - 2)):(row(stringcolumn(2)) ? row(stringcolumn(2)) + 0.22 * (k - 2) : NaN):\
        (column(last - 1)):(column(last)) \
  with xerrorbars pt 7 ps 0.6 lc k title word("cubic hermite jets", k)
