// Closed parts that cross each other, appended to one file: the body is their union. Ten variants of a seed: turns,
// sizes, distances, order and sense of the triangles; the exact volume of two spheres that cross.
#include <Eigen/Geometry>

#include "geometry/meshing/deviation.hpp"
#include "geometry/meshing/tetrahedralise.hpp"
#include "tests/support/test.hpp"

namespace {

void append(Surface& to, const Surface& more) {
  const auto first = static_cast<NodeIndex>(to.nodes.size());
  to.nodes.insert(to.nodes.end(), more.nodes.begin(), more.nodes.end());
  for (const auto& [a, b, c] : more.triangles) to.triangles.push_back({a + first, b + first, c + first});
}

// A sphere as a subdivided octahedron.
Surface sphere(const Vec3& centre, double radius, int levels) {
  Surface s{
      .nodes = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}},
      .triangles = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}}};
  for (int level = 0; level < levels; ++level) {
    Surface fine{.nodes = s.nodes, .triangles = {}};
    std::map<std::pair<NodeIndex, NodeIndex>, NodeIndex> middle;
    const auto between = [&](NodeIndex a, NodeIndex b) {
      const auto [at, fresh] =
          middle.try_emplace(std::minmax(a, b), static_cast<NodeIndex>(fine.nodes.size()));
      if (fresh) fine.nodes.push_back((s.nodes[a] + s.nodes[b]).normalized());
      return at->second;
    };
    for (const auto& [a, b, c] : s.triangles) {
      const NodeIndex d = between(a, b), e = between(b, c), f = between(c, a);
      for (const Triangle& t : {Triangle{a, d, f}, Triangle{d, b, e}, Triangle{f, e, c}, Triangle{d, e, f}})
        fine.triangles.push_back(t);
    }
    s = std::move(fine);
  }
  for (Vec3& node : s.nodes) node = centre + radius * node;
  return s;
}

// Of the part of a ball beyond a plane at the distance d from its centre.
double cap(double radius, double d) {
  const double h = radius - d;
  return std::numbers::pi * h * h * (3 * radius - h) / 3;
}

}  // namespace

TEST_CASE("spheres that cross become their union, and the word names the crossing") {
  std::mt19937 random(44);
  const auto real = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  for (int variant = 0; variant < 10; ++variant) {
    const double unit = std::pow(10.0, variant % 3 - 1), r = unit * real(0.04, 0.06),
                 s = unit * real(0.03, 0.06);
    const Vec3 way = Vec3(real(-1, 1), real(-1, 1), real(-1, 1)).normalized(), centre = unit * way;
    const double apart = real(0.5, 0.85) * (r + s) + 0.2 * std::abs(r - s);
    Surface surface = sphere(centre, r, 3), other = sphere(centre + apart * way, s, 3);
    if (variant % 2 == 1)  // inside out
      for (Triangle& t : other.triangles) std::swap(t[0], t[1]);
    append(surface, other);
    double walls = 0;  // of a third part, apart from both
    if (variant % 4 == 0) {
      append(surface, sphere(centre + 3 * (r + s) * way, r, 3));
      walls = 1;
    }
    std::shuffle(surface.triangles.begin(), surface.triangles.end(), random);
    const double d = (apart * apart + r * r - s * s) / (2 * apart);
    const double ball = 4 * std::numbers::pi / 3;
    const double exact =
        ball * (r * r * r + s * s * s) - cap(r, d) - cap(s, apart - d) + walls * ball * r * r * r;
    RepairReport report;
    const Surface united = repair_surface(surface, report);
    INFO("variant " << variant << ": " << enclosed_volume(united) << " of " << exact);
    CHECK(report.crossing == 2);
    CHECK(report.united);
    CHECK_FALSE(report.wrapped);
    CHECK(enclosed_volume(united) == Approx(exact).epsilon(0.03));  // of octahedra subdivided thrice
    CHECK(enclosed_volume(united) < exact);
    CHECK(report.volume == enclosed_volume(united));
    if (variant > 1) continue;
    TetrahedraliseReport made;
    const TetMesh mesh = tetrahedralise(surface, {.elements = 2500}, &made);
    CHECK(mesh_quality(mesh).volume == Approx(exact).epsilon(0.06));
    const Deviation deviation = deviation_of(surface, mesh, made.hausdorff, {}, made.repair);
    const auto words = in_words(deviation, made.repair);
    REQUIRE(words.size() == 1);
    CHECK_THAT(words[0], Contains("2 parts of the surface cross each other", "union"));
  }
}

TEST_CASE("flipped facets are turned, and no word is said about the volume") {
  std::mt19937 random(45);
  for (int variant = 0; variant < 10; ++variant) {
    Surface surface = sphere(Vec3::Zero(), 0.05, 2);
    for (Triangle& t : surface.triangles)
      if (random() % 4 == 0)
        std::swap(t[static_cast<std::size_t>(variant % 3)], t[static_cast<std::size_t>((variant + 1) % 3)]);
    std::shuffle(surface.triangles.begin(), surface.triangles.end(), random);
    RepairReport report;
    const Surface right = repair_surface(surface, report);
    CHECK(report.reoriented);
    CHECK(enclosed_volume(right) == Approx(enclosed_volume(sphere(Vec3::Zero(), 0.05, 2))).epsilon(1e-9));
    if (variant > 0) continue;
    TetrahedraliseReport made;
    const TetMesh mesh = tetrahedralise(surface, {.elements = 1500}, &made);
    CHECK(in_words(deviation_of(surface, mesh, made.hausdorff, {}, made.repair), made.repair).empty());
  }
}
