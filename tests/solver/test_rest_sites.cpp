// Stiffness and jet at rest of any site from one factor, and their derivatives by the site.
#include <Eigen/Geometry>

#include "pad_body.hpp"
#include "solver/jet/rest_jet.hpp"
#include "solver/jet/rest_sites.hpp"
#include "tests/support/test.hpp"

namespace {

// The largest difference of two jets, each degree relative to its largest coefficient.
double difference(const EnergyJet& a, const EnergyJet& b) {
  double worst = 0;
  for (int order = 2; order <= most_jet_order; ++order) {
    double off = 0, size = 0;
    for (std::size_t i = jet_terms_of_order(order - 1); i < jet_terms_of_order(order); ++i) {
      off = std::max(off, std::abs(a.coefficients[i] - b.coefficients[i]));
      size = std::max(size, std::abs(b.coefficients[i]));
    }
    worst = std::max(worst, off / size);
  }
  return worst;
}

}  // namespace

TEST_CASE("A site's stiffness and jet are those of the body with a pad there") {
  for (const Element element : {Element::linear, Element::quadratic})
    for (const Law law : {Law::neo_hookean, Law::mooney_rivlin}) {
      const auto body = padded_phantom("liver", 600, phantom_tip("liver"), law, element);
      const RestSites sites(body, 2);
      SiteJets jets(sites);
      std::mt19937_64 random(3);
      for (int i = 0; i < 3; ++i) {
        const SurfacePlace place = sites.map().random(random);
        Body at_place = *body;
        at_place.pad->site = place.at;
        const RestJet own = rest_jet(at_place, {.key = "body"}), ours = jets.at(place);
        CHECK((ours.stiffness - own.stiffness).norm() < 1e-10 * own.stiffness.norm());
        CHECK((sites.at(place, false).stiffness - own.stiffness).norm() < 1e-10 * own.stiffness.norm());
        CHECK(difference(ours.jet, own.jet) < 1e-8);
        CHECK(ours.jet.limit == Approx(own.jet.limit).epsilon(1e-6));
        const PadSurface under = pad_surface(body->mesh, *at_place.pad);
        CHECK((sites.at(place, false).normal - under.normal).norm() < 1e-9);
        if (element == Element::linear)  // of quadratic elements the share counts the middles of edges too
          CHECK(sites.at(place, false).clamped_share == Approx(clamped_share(at_place, under)).margin(1e-9));
      }
    }
}

TEST_CASE(
    "The derivatives of stiffness and normal by the site are those of differences, and continuous over "
    "edges") {
  const auto body = padded_phantom("liver", 600, phantom_tip("liver"));
  const RestSites sites(body, 1);
  std::mt19937_64 random(5);
  for (int i = 0; i < 10; ++i) {
    const SurfacePlace place = sites.map().random(random);
    const SiteRest rest = sites.at(place, true);
    const auto [a, b, c] = sites.map().corners(place.facet);
    const Vec3 way = (b - a).normalized();
    const double h = 1e-6;
    SurfacePlace up = place, down = place;
    up.at += h * way, down.at -= h * way;
    const SiteRest above = sites.at(up, false), below = sites.at(down, false);
    const Mat3 by =
        way[0] * rest.stiffness_by[0] + way[1] * rest.stiffness_by[1] + way[2] * rest.stiffness_by[2];
    const Mat3 differences = (above.stiffness - below.stiffness) / (2 * h);
    CHECK((by - differences).norm() < 1e-5 * (1 + differences.norm()));
    CHECK((rest.normal_by * way - (above.normal - below.normal) / (2 * h)).norm() < 1e-5);
    // The same point seen from the neighbouring facet.
    const SurfacePlace edge{place.facet, 0.5 * (a + b)}, beside{sites.map().facet(place).beside[0], edge.at};
    CHECK((sites.at(edge, false).stiffness - sites.at(beside, false).stiffness).norm() <
          1e-9 * rest.stiffness.norm());
  }
}

TEST_CASE("The stiffness of the body under the pad is in series with the springs") {
  const auto body = padded_block(Law::linear);
  const RestSites sites(body, 1);
  const SiteRest rest = sites.at(sites.map().nearest(body->pad->site), false);
  CHECK(rest.springs == Approx(body->pad->stiffness).epsilon(1e-9));
  const Mat3 series = (rest.body_stiffness().inverse() + Mat3::Identity() / rest.springs).inverse();
  CHECK((series - rest.stiffness).norm() < 1e-9 * rest.stiffness.norm());
}

TEST_CASE("Sites need a pad") {
  CHECK_THROWS_AS(RestSites(gripped_phantom("ball", 300), 1), InputError);
}
