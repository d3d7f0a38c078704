// The smooth surface over facets: against a sphere, its own differences, flat bodies and edges that are kept.
#include <Eigen/Geometry>
#include <map>
#include <random>

#include "geometry/meshing/phantom.hpp"
#include "solver/jet/surface_map.hpp"
#include "tests/support/test.hpp"

namespace {

struct Triangles {
  std::vector<Vec3> nodes;
  std::vector<SmoothFacet> facets;
  SmoothSurface smooth() const { return {nodes, facets}; }
};

void join(Triangles& t) {
  std::map<std::array<std::uint32_t, 2>, std::int32_t> beside;
  for (std::size_t f = 0; f < t.facets.size(); ++f)
    for (std::size_t i = 0; i < 3; ++i)
      beside[{t.facets[f].corners[i], t.facets[f].corners[(i + 1) % 3]}] = static_cast<std::int32_t>(f);
  for (SmoothFacet& facet : t.facets)
    for (std::size_t i = 0; i < 3; ++i) {
      const auto at = beside.find({facet.corners[(i + 1) % 3], facet.corners[i]});
      facet.beside[i] = at == beside.end() ? -1 : at->second;
    }
}

// An octahedron whose facets are split `times` times, on a sphere of radius 1; nodes moved at random over the sphere by
// `jitter` of an edge.
Triangles sphere(int times, double jitter) {
  Triangles t{{{1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}}, {}};
  for (std::uint32_t i = 0; i < 4; ++i) {
    t.facets.push_back({.corners = {i, (i + 1) % 4, 4}});
    t.facets.push_back({.corners = {(i + 1) % 4, i, 5}});
  }
  for (int k = 0; k < times; ++k) {
    std::map<std::array<std::uint32_t, 2>, std::uint32_t> middles;
    const auto middle = [&](std::uint32_t a, std::uint32_t b) {
      const auto [at, fresh] =
          middles.try_emplace({std::min(a, b), std::max(a, b)}, static_cast<std::uint32_t>(t.nodes.size()));
      if (fresh) t.nodes.push_back((t.nodes[a] + t.nodes[b]).normalized());
      return at->second;
    };
    std::vector<SmoothFacet> finer;
    for (const SmoothFacet& facet : t.facets) {
      const auto [a, b, c] = facet.corners;
      const std::uint32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
      for (const std::array<std::uint32_t, 3>& corners :
           {std::array{a, ab, ca}, std::array{ab, b, bc}, std::array{ca, bc, c}, std::array{ab, bc, ca}})
        finer.push_back({.corners = corners});
    }
    t.facets = finer;
  }
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> share(-1, 1);
  const double edge = 1.5 / std::pow(2, times);
  for (Vec3& node : t.nodes)
    node = (node + jitter * edge * Vec3(share(random), share(random), share(random))).normalized();
  join(t);
  return t;
}

Vec3 random_share(std::mt19937_64& random) {
  std::uniform_real_distribution<double> share(0, 1);
  const double root = std::sqrt(share(random)), t = share(random);
  return {1 - root, root * (1 - t), root * t};
}

// The farthest from the sphere at random places.
double farthest(const Triangles& t) {
  const SmoothSurface smooth = t.smooth();
  std::mt19937_64 random(4);
  double far = 0;
  for (std::size_t f = 0; f < t.facets.size(); ++f)
    for (int i = 0; i < 10; ++i)
      far = std::max(far,
                     std::abs(smooth.at(static_cast<std::int32_t>(f), random_share(random)).at.norm() - 1));
  return far;
}

}  // namespace

TEST_CASE(
    "The smooth surface of a sphere's facets comes nearer to the sphere with the third power of their size",
    "[smooth]") {
  // Facets alone: with the second. Irregular ones too.
  for (const double jitter : {0.0, 0.15}) {
    const double coarse = farthest(sphere(2, jitter)), fine = farthest(sphere(3, jitter)),
                 finest = farthest(sphere(4, jitter));
    INFO(coarse << " " << fine << " " << finest);
    CHECK(coarse < 0.02);
    CHECK(std::log2(coarse / finest) / 2 > 2.5);
    CHECK(fine < coarse);
  }
}

TEST_CASE("The smooth surface has one tangent plane at each edge and node, and goes through the nodes",
          "[smooth]") {
  const Triangles t = sphere(2, 0.25);
  const SmoothSurface smooth = t.smooth();
  CHECK(smooth.faceted_nodes() == 0);
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> any(0, 1);
  for (std::size_t f = 0; f < t.facets.size(); ++f)
    for (std::size_t i = 0; i < 3; ++i) {
      const SmoothFacet& facet = t.facets[f];
      if (smooth.keeps(static_cast<std::int32_t>(f), i)) continue;
      const std::int32_t beside = facet.beside[i];
      for (const double along : {0.0, 1e-6, any(random), any(random), 1.0}) {
        Vec3 here = Vec3::Zero(), there = Vec3::Zero();
        here[static_cast<int>(i)] = 1 - along, here[static_cast<int>((i + 1) % 3)] = along;
        for (int k = 0; k < 3; ++k) {
          const std::uint32_t node =
              t.facets[static_cast<std::size_t>(beside)].corners[static_cast<std::size_t>(k)];
          if (node == facet.corners[i]) there[k] = 1 - along;
          if (node == facet.corners[(i + 1) % 3]) there[k] = along;
        }
        const SmoothSpot a = smooth.at(static_cast<std::int32_t>(f), here), b = smooth.at(beside, there);
        CHECK((a.at - b.at).norm() < 1e-14);
        CHECK((a.normal - b.normal).norm() < 1e-9);
        if (along == 0) CHECK(a.at == t.nodes[facet.corners[i]]);
      }
    }
}

TEST_CASE("The derivative of the smooth surface is that by differences", "[smooth]") {
  const Triangles t = sphere(1, 0.2);
  const SmoothSurface smooth = t.smooth();
  std::mt19937_64 random(6);
  constexpr double h = 1e-6;
  for (std::size_t f = 0; f < t.facets.size(); ++f) {
    const auto number = static_cast<std::int32_t>(f);
    const Vec3 share = random_share(random), way(0.4, -0.7, 0.3);
    Vec3 step = Vec3::Zero();
    for (int i = 0; i < 3; ++i) step += way[i] * t.nodes[t.facets[f].corners[static_cast<std::size_t>(i)]];
    const Vec3 rise =
        (smooth.at(number, share + h * way).at - smooth.at(number, share - h * way).at) / (2 * h);
    const SmoothSpot spot = smooth.at(number, share);
    CHECK((spot.by * step - rise).norm() < 1e-7);
    CHECK(std::abs(spot.normal.dot(spot.by * step)) < 1e-12);
  }
}

TEST_CASE("A box keeps its faces and edges, and a cylinder its rims", "[smooth]") {
  Body slab;
  slab.mesh = phantom("slab", 600);
  const SurfaceMap box(slab);
  for (std::int32_t f = 0; f < static_cast<std::int32_t>(box.facets().size()); ++f)
    CHECK(box.smooth().is_flat(f));
  CHECK(box.smooth().kept_edges() > 0);

  // A cylinder of radius 1: its side becomes smooth, its lids stay flat, and the rim becomes a circle.
  constexpr std::uint32_t around = 16, rows = 5;
  Triangles t;
  for (std::uint32_t row = 0; row < rows; ++row)
    for (std::uint32_t i = 0; i < around; ++i) {
      const double angle = 2 * std::numbers::pi * i / around;
      t.nodes.push_back({std::cos(angle), std::sin(angle), 0.4 * row});
    }
  t.nodes.push_back({0, 0, 0}), t.nodes.push_back({0, 0, 0.4 * (rows - 1)});
  for (std::uint32_t row = 0; row + 1 < rows; ++row)
    for (std::uint32_t i = 0; i < around; ++i) {
      const std::uint32_t a = row * around + i, b = row * around + (i + 1) % around;
      t.facets.push_back({.corners = {a, b, b + around}});
      t.facets.push_back({.corners = {a, b + around, a + around}});
    }
  for (std::uint32_t i = 0; i < around; ++i) {
    t.facets.push_back({.corners = {(i + 1) % around, i, rows * around}});
    t.facets.push_back(
        {.corners = {(rows - 1) * around + i, (rows - 1) * around + (i + 1) % around, rows * around + 1}});
  }
  join(t);
  const SmoothSurface smooth = t.smooth();
  CHECK(smooth.kept_edges() == 2 * around);
  std::mt19937_64 random(7);
  const double chord = 1 - std::cos(std::numbers::pi / around);
  for (std::size_t f = 0; f < t.facets.size(); ++f) {
    const bool side = f < 2 * around * (rows - 1);
    for (int i = 0; i < 10; ++i) {
      const SmoothSpot spot = smooth.at(static_cast<std::int32_t>(f), random_share(random));
      if (side) {
        CHECK(std::abs(spot.at.head<2>().norm() - 1) < 0.1 * chord);
        CHECK(std::abs(spot.normal.z()) < 0.02);
      } else {
        CHECK(std::abs(spot.normal.z()) > 1 - 1e-9);
      }
    }
  }
}

TEST_CASE("A node around which the smooth surface would fold keeps its facets", "[smooth]") {
  Triangles t = sphere(2, 0);
  t.nodes[8] *= 3;  // a spike
  const SmoothSurface smooth = t.smooth();
  std::mt19937_64 random(8);
  for (std::size_t f = 0; f < t.facets.size(); ++f)
    for (int i = 0; i < 10; ++i) {
      const SmoothSpot spot = smooth.at(static_cast<std::int32_t>(f), random_share(random));
      const Vec3 &a = t.nodes[t.facets[f].corners[0]], &b = t.nodes[t.facets[f].corners[1]],
                 &c = t.nodes[t.facets[f].corners[2]];
      const Vec3 normal = (b - a).cross(c - a).normalized();
      CHECK(spot.normal.dot(normal) > 0.3);
      CHECK(std::abs(normal.dot(spot.at - a)) <= smooth.farthest() + 1e-6);
    }
}

TEST_CASE("A walk over a ball ends on it, and back where it began", "[smooth]") {
  Body ball;
  ball.mesh = phantom("ball", 1200);
  const SurfaceMap map(ball);
  std::mt19937_64 random(9);
  for (int i = 0; i < 50; ++i) {
    const SurfacePlace place = map.random(random);
    const Vec3 n = map.spot(place).normal, way = 0.004 * n.unitOrthogonal();
    const SurfaceMap::Walk there = map.walk(place, way), back = map.walk(there.end, -there.step);
    if (!there.whole || !back.whole) continue;
    CHECK(there.step.norm() == Approx(0.004).epsilon(1e-9));
    CHECK((there.end.at - place.at).norm() == Approx(0.004).epsilon(0.02));
    CHECK((back.end.at - place.at).norm() < 2e-4);
    CHECK((map.nearest(place.at + 0.003 * n).at - place.at).norm() < 1e-9);
    CHECK((map.nearest(place.at - 0.003 * n).at - place.at).norm() < 1e-9);
    const Vec3 share = map.barycentric({place.facet, place.at});
    CHECK((share - place.share).norm() < 1e-9);
  }
}
