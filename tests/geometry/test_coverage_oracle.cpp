#include "geometry/coverage/coverage_query.hpp"
#include "tests/support/test.hpp"

TEST_CASE("spread, hull membership and gamma equal SciPy's",
          SLOW("compares with SciPy, which only run.sh all installs")) {
  constexpr double h = 0.006;
  std::mt19937_64 random(17);
  std::uniform_real_distribution<double> uniform(-4 * h, 4 * h);
  PointOctree points;
  DelaunayIndex delaunay;
  if (!has_python_module("scipy.spatial")) return skip("python3-scipy is not installed");
  const TemporaryFolder folder;
  const std::string states = (folder / "states.csv").string();
  const std::string queries = (folder / "queries.csv").string();
  {
    std::ofstream out(states), ask(queries);
    out.precision(17);
    ask.precision(17);
    for (std::uint32_t id = 0; id < 300; ++id) {
      const Vec3 p(uniform(random), uniform(random), uniform(random));
      points.insert(id, p);
      delaunay.insert({id}, p);
      out << p.x() << ',' << p.y() << ',' << p.z() << '\n';
    }
    const CoverageQuery query(points, delaunay);
    for (int i = 0; i < 1500; ++i) {
      const Vec3 q = 1.3 * Vec3(uniform(random), uniform(random), uniform(random));
      const double radius = i % 2 ? 1.45 * h : 8 * h;
      ask << q.x() << ',' << q.y() << ',' << q.z() << ',' << delaunay.spread(q, {}).spread << ','
          << query.largest_empty_cone(q, radius, 0).cos_half << ',' << radius << '\n';
    }
  }
  const std::string command = "/usr/bin/python3 '" +
                              (source_folder() / "tests/geometry/coverage_oracle.py").string() + "' " +
                              states + " " + queries;
  CHECK(std::system(command.c_str()) == 0);
}
