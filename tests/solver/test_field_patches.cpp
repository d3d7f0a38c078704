// The field for a moving hand: near the exact field, continuous over edges, exact derivatives; and the grid that says
// where a tip is.
#include <Eigen/Geometry>
#include <numbers>

#include "geometry/meshing/phantom.hpp"
#include "solver/body/pad.hpp"
#include "solver/jet/deep_states.hpp"
#include "solver/jet/field_patches.hpp"
#include "solver/jet/surface_grid.hpp"
#include "tests/support/test.hpp"

namespace {

std::shared_ptr<const Body> small_liver() {
  auto body = std::make_shared<Body>();
  body->mesh = phantom("liver", 600);
  body->material = {Law::neo_hookean, 5000, 0.4};
  body->clamp = body->mesh.groups.at("clamp");
  body->pad = Pad{};
  return body;
}

const FieldPatches& patches() {
  static const FieldPatches made(std::make_shared<const SiteField>(
      std::make_shared<const RestSites>(small_liver(), 2), SiteFieldOptions{.spacing = 0.02, .threads = 2}));
  return made;
}

SiteTerms at(const SurfacePlace& place, const Vec3& x) {
  SiteModel model;
  patches().fill(place, false, model);
  return model.at(x);
}

}  // namespace

TEST_CASE("Facets' polynomials are near the exact field, and exact at its places", "[patches]") {
  const SurfaceMap& map = patches().field().rest().map();
  std::mt19937_64 random(3);
  std::vector<double> errors;
  for (int i = 0; i < 60; ++i) {
    const SurfacePlace place = map.random(random);
    const SiteModel exact = patches().field().at(place, false);
    const Vec3 x = -0.008 * exact.rest().normal + 0.003 * exact.rest().normal.unitOrthogonal();
    errors.push_back((at(place, x).force - exact.at(x).force).norm() / exact.at(x).force.norm());
    const auto [a, b, c] = map.corners(place.facet);
    const SurfacePlace corner{place.facet, a};
    CHECK((at(corner, x).force - patches().field().at(corner, false).at(x).force).norm() < 1e-9);
  }
  std::ranges::sort(errors);
  CHECK(errors[30] < 0.01);  // facets of 600 elements are larger than the pad
  CHECK(errors.back() < 0.1);
}

TEST_CASE("E over the facets is a potential: force and dE/ds by differences, with states too", "[patches]") {
  const SurfaceMap& map = patches().field().rest().map();
  std::mt19937_64 random(5);
  constexpr double h = 1e-6;
  for (int i = 0; i < 10; ++i) {
    const SurfacePlace place = map.random(random);
    if (map.barycentric(place).minCoeff() < 0.01) continue;
    const Vec3 n = map.spot(place).normal, t = n.unitOrthogonal(), x = -0.006 * n + 0.002 * t;
    const SiteTerms here = at(place, x);
    for (int k = 0; k < 3; ++k) {
      const Vec3 step = h * Vec3::Unit(k);
      CHECK(-(at(place, x + step).energy - at(place, x - step).energy) / (2 * h) ==
            Approx(here.force[k]).margin(1e-6 * here.force.norm()));
    }
    for (const Vec3& way : {t, Vec3(n.cross(t))}) {
      const double rise =
          at(map.walk(place, h * way).end, x).energy - at(map.walk(place, -h * way).end, x).energy;
      CHECK(rise / (2 * h) == Approx(here.by_site.dot(way)).margin(1e-6 * here.force.norm()));
    }
  }
}

TEST_CASE("Where a site crosses an edge, neither E nor its derivatives jump", "[patches]") {
  const SurfaceMap& map = patches().field().rest().map();
  int crossed = 0, kept = 0;
  double turned = 0;
  for (std::int32_t f = 0; f < static_cast<std::int32_t>(map.facets().size()); ++f) {
    const SurfaceMap::Facet& facet = map.facets()[static_cast<std::size_t>(f)];
    const std::int32_t beside = facet.beside[0];
    if (beside < 0 || facet.clamped || map.facets()[static_cast<std::size_t>(beside)].clamped) continue;
    const SurfaceMap::Facet& other = map.facets()[static_cast<std::size_t>(beside)];
    Vec3 share = Vec3::Zero();
    for (int i = 0; i < 3; ++i) {
      if (other.corners[static_cast<std::size_t>(i)] == facet.corners[0]) share[i] = 0.3;
      if (other.corners[static_cast<std::size_t>(i)] == facet.corners[1]) share[i] = 0.7;
    }
    const SurfacePlace from = map.place(f, {0.3, 0.7, 0}), to = map.place(beside, share);
    const Vec3 x = -0.007 * facet.normal;
    const SiteTerms here = at(from, x), there = at(to, x);
    CHECK((from.at - to.at).norm() < 1e-15);
    CHECK((here.force - there.force).norm() < 1e-9 * here.force.norm());
    CHECK(here.energy == Approx(there.energy).epsilon(1e-9));
    ++crossed;
    if (map.smooth().keeps(f, 0)) {
      ++kept;
      continue;
    }
    const Vec3 n = map.spot(from).normal, t = n.unitOrthogonal();
    turned = std::max(turned, std::acos(std::min(1.0, facet.normal.dot(other.normal))));
    for (const Vec3& way : {t, Vec3(n.cross(t))})
      CHECK(std::abs((here.by_site - there.by_site).dot(way)) < 1e-8 * here.force.norm());
  }
  CHECK(crossed > 50);
  CHECK(kept > 0);
  CHECK(turned > 0.4);
}

TEST_CASE("Kept values give the same facets, without a solve", "[patches]") {
  const auto field = std::make_shared<const SiteField>(std::make_shared<const RestSites>(small_liver(), 2),
                                                       SiteFieldOptions{.spacing = 0.02, .threads = 2});
  const FieldPatches again(field, patches().values());
  std::mt19937_64 random(9);
  const SurfacePlace place = field->rest().map().random(random);
  SiteModel model;
  again.fill(place, false, model);
  CHECK(model.at(Vec3(0.001, 0.002, -0.003)).force == at(place, Vec3(0.001, 0.002, -0.003)).force);
}

TEST_CASE("The grid says as the solid angle does whether a point is inside, and finds crossings",
          "[patches]") {
  const SurfaceMap map(*small_liver());
  const SurfaceGrid grid(map);
  // The solid angle of finer facets than the grid's, which is near that of the smooth surface.
  constexpr int parts = 10;
  std::vector<std::array<Vec3, 3>> fine;
  Vec3 low = Vec3::Constant(1e9), high = -low;
  for (std::int32_t f = 0; f < static_cast<std::int32_t>(map.facets().size()); ++f) {
    const auto at = [&](int i, int j) { return map.place(f, Vec3(parts - i - j, i, j) / parts).at; };
    for (int i = 0; i < parts; ++i)
      for (int j = 0; i + j < parts; ++j) {
        fine.push_back({at(i, j), at(i + 1, j), at(i, j + 1)});
        if (i + j + 1 < parts) fine.push_back({at(i + 1, j + 1), at(i, j + 1), at(i + 1, j)});
      }
    for (const Vec3& corner : map.corners(f)) low = low.cwiseMin(corner), high = high.cwiseMax(corner);
  }
  const auto turns = [&](const Vec3& point) {
    double angle = 0;
    for (const auto& [p, q, r] : fine) {
      const Vec3 a = p - point, b = q - point, c = r - point;
      const double la = a.norm(), lb = b.norm(), lc = c.norm();
      angle +=
          2 * std::atan2(a.dot(b.cross(c)), la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
    }
    return angle / (4 * std::numbers::pi);
  };
  std::mt19937_64 random(2);
  std::uniform_real_distribution<double> share(-0.1, 1.1);
  int inside = 0, near = 0;
  for (int i = 0; i < 400; ++i) {
    const Vec3 point = low + Vec3(share(random), share(random), share(random)).cwiseProduct(high - low);
    inside += grid.inside(point);
    if ((map.nearest(point).at - point).norm() < 1e-4) {
      ++near;
      continue;
    }
    REQUIRE(grid.inside(point) == (turns(point) > 0.5));
  }
  CHECK(inside > 40);
  CHECK(near < 10);
  for (int i = 0; i < 300; ++i) {
    const SurfacePlace place = map.random(random);
    const Vec3 n = map.spot(place).normal;
    CHECK(grid.inside(place.at - 1e-7 * n));
    CHECK_FALSE(grid.inside(place.at + 1e-7 * n));
    const auto at = grid.crossing(place.at + 1e-4 * n, place.at - 1e-4 * n);
    REQUIRE(at);
    CHECK((at->at - place.at).norm() < 1e-9);
    CHECK_FALSE(grid.crossing(place.at - 1e-4 * n, place.at + 1e-4 * n));  // outwards
  }
}
