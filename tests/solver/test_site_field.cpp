// The energy of sites E(s, x): a potential with exact derivatives, without jumps in s, exact for linear bodies.
#include <Eigen/Geometry>

#include "pad_body.hpp"
#include "solver/jet/site_field.hpp"
#include "tests/support/test.hpp"

namespace {

std::shared_ptr<const RestSites> sites_of(const std::shared_ptr<Body>& body) {
  return std::make_shared<const RestSites>(body, 2);
}

std::shared_ptr<Body> small_liver(Law law = Law::neo_hookean) {
  return padded_phantom("liver", 600, phantom_tip("liver"), law);
}

// A displacement of this depth, a third as far sideways.
Vec3 pressed(const SiteModel& model, double depth) {
  const Vec3& n = model.rest().normal;
  return depth * (-n + (n.unitOrthogonal() + 0.5 * n.cross(n.unitOrthogonal())) / 3);
}

double error_of(const Vec3& force, const Vec3& right) {
  return (force - right).norm() / right.norm();
}

// Errors against a jet made at each of 60 random places, 10 mm deep.
std::vector<double> errors_between(const SiteField& field) {
  SiteJets jets(field.rest());
  std::mt19937_64 random(11);
  std::vector<double> errors;
  for (int i = 0; i < 200; ++i) {
    const SurfacePlace place = field.rest().map().random(random);
    const SiteModel model = field.at(place, false);
    const Vec3 x = pressed(model, 0.01);
    const RestJet jet = jets.at(place);
    errors.push_back(error_of(model.at(x).force, -(jet.stiffness * x + jet_terms(jet.jet, x).gradient)));
  }
  std::ranges::sort(errors);
  return errors;
}

}  // namespace

TEST_CASE("A linear body is exact everywhere from its stiffness at rest") {
  const auto body = small_liver(Law::linear);
  const SiteField field(sites_of(body), {.spacing = 0.03});
  std::mt19937_64 random(2);
  for (int i = 0; i < 8; ++i) {
    const SurfacePlace place = field.rest().map().random(random);
    const SiteModel model = field.at(place, false);
    const Vec3 x = pressed(model, 0.02);
    Body there = *body;
    there.pad->site = place.at;
    const State state = Solver(there).reference(x, 0.006).state;
    CHECK(error_of(model.at(x).force, state.force) < 1e-6);
    CHECK(std::abs(model.at(x).energy - state.energy) < 1e-6 * state.energy);
  }
}

TEST_CASE("Force, stiffness and the derivative by the site are those of the energy") {
  const SiteField field(sites_of(small_liver()), {.spacing = 0.02});
  std::mt19937_64 random(4);
  for (int i = 0; i < 12; ++i) {
    const SurfacePlace place = field.rest().map().random(random);
    const SiteModel model = field.at(place, true);
    CHECK(model.neighbours() > 0);
    const Vec3 x = pressed(model, 0.012);
    const SiteTerms at = model.at(x);
    const double h = 1e-6;
    for (int k = 0; k < 3; ++k) {
      const SiteTerms up = model.at(x + h * Vec3::Unit(k)), down = model.at(x - h * Vec3::Unit(k));
      CHECK(std::abs(at.force[k] + (up.energy - down.energy) / (2 * h)) < 1e-6 * at.force.norm());
      CHECK((at.stiffness.col(k) + (up.force - down.force) / (2 * h)).norm() < 1e-6 * at.stiffness.norm());
    }
    CHECK((at.stiffness - at.stiffness.transpose()).norm() < 1e-12 * at.stiffness.norm());
    const auto [a, b, c] = field.rest().map().corners(place.facet);
    for (const Vec3& side : {Vec3(b - a), Vec3(c - a)}) {
      const Vec3 way = side.normalized();
      SurfacePlace up = place, down = place;
      up.at += h * way, down.at -= h * way;
      const double slope = (field.at(up, false).at(x).energy - field.at(down, false).at(x).energy) / (2 * h);
      CHECK(std::abs(at.by_site.dot(way) - slope) < 1e-5 * at.force.norm());
    }
  }
}

TEST_CASE("The force has no jump where the site crosses facets, edges and changes of neighbours") {
  const SiteField field(sites_of(small_liver()), {.spacing = 0.02});
  const SurfaceMap& map = field.rest().map();
  std::mt19937_64 random(6);
  const auto force_after = [&](const SurfacePlace& from, const Vec3& step, const Vec3& x) {
    return field.at(map.walk(from, step).end, false).at(x).force;
  };
  for (int i = 0; i < 25;
       ++i) {  // over an edge: extrapolated from both sides to the edge, from 0.5 and 1.5 um
    const SurfacePlace place = map.random(random);
    const auto [a, b, c] = map.corners(place.facet);
    const SurfaceMap::Facet& facet = map.facet(place);
    if (facet.beside[0] < 0 || map.facets()[static_cast<std::size_t>(facet.beside[0])].clamped) continue;
    const Vec3 inward = facet.normal.cross(b - a).normalized();
    const Vec3 edge(0.6, 0.4, 0),
        into(map.flat_slopes(place.facet)[0].dot(inward), map.flat_slopes(place.facet)[1].dot(inward),
             map.flat_slopes(place.facet)[2].dot(inward));
    const SurfacePlace near = map.place(place.facet, edge + 0.5e-6 * into);
    const Vec3 x = pressed(field.at(near, false), 0.01), ahead = (map.spot(near).by * inward).normalized();
    const Vec3 here = 1.5 * force_after(near, Vec3::Zero(), x) - 0.5 * force_after(near, 1e-6 * ahead, x);
    const Vec3 there = 1.5 * force_after(near, -1e-6 * ahead, x) - 0.5 * force_after(near, -2e-6 * ahead, x);
    CHECK((here - there).norm() < 1e-6 * here.norm());
  }
  for (int line = 0; line < 40; ++line) {  // on a facet, 1 um before and after places 0.2 mm apart
    const SurfacePlace place = map.random(random);
    const auto [a, b, c] = map.corners(place.facet);
    const Vec3 way = 1e-6 * (c - place.at).normalized(), x = pressed(field.at(place, false), 0.01);
    for (int i = 0; i < 8; ++i) {
      SurfacePlace at{place.facet, place.at}, before = at, after = at;
      at.at += 200 * i * way, before.at = at.at - way, after.at = at.at + way;
      if (map.barycentric(after).minCoeff() < 0) break;
      const Vec3 f = field.at(at, false).at(x).force;
      const Vec3 bend = field.at(before, false).at(x).force - 2 * f + field.at(after, false).at(x).force;
      CHECK(bend.norm() < 1e-6 * f.norm());
    }
  }
}

TEST_CASE(
    "Between the sites the field is near a jet made at the place, and the nearer the denser the sites") {
  const auto rest = sites_of(small_liver());
  const SiteField coarse(rest, {.spacing = 0.024}), fine(rest, {.spacing = 0.012});
  CHECK(fine.size() > 2 * coarse.size());
  const std::vector<double> of_coarse = errors_between(coarse), of_fine = errors_between(fine);
  CHECK(of_fine[100] < 0.5 * of_coarse[100]);
  CHECK(of_fine[186] < 0.5 * of_coarse[186]);

  CHECK(of_fine[180] < 0.01);
}

TEST_CASE("A field is the same by any number of threads, reports its progress and stops when asked") {
  const auto rest = sites_of(small_liver());
  std::vector<double> told;
  const SiteField one(rest, {.spacing = 0.03}),
      three(rest, {.spacing = 0.03, .threads = 3}, [&](double share) { told.push_back(share); });
  CHECK(one.size() == three.size());
  CHECK(told.size() == three.size() + 1);  // before the first site as well
  CHECK(told.front() == 0);
  CHECK(told.back() == 1);
  const SurfacePlace place = rest->map().nearest(phantom_tip("liver"));
  const SiteModel a = one.at(place, false), b = three.at(place, false);
  CHECK((a.at(pressed(a, 0.01)).force - b.at(pressed(a, 0.01)).force).norm() == 0);
  std::stop_source stop;
  stop.request_stop();
  CHECK(SiteField(rest, {.spacing = 0.03}, {}, stop.get_token()).size() == 0);
}
