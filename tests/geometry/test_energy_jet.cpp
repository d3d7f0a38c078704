#include "geometry/states/energy_jet.hpp"
#include "tests/support/test.hpp"

namespace {

EnergyJet some_jet(int order) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(-1, 1);
  EnergyJet jet{.order = order};
  for (std::size_t i = 0; i < jet_terms_of_order(order); ++i) jet.coefficients[i] = uniform(random);
  return jet;
}

}  // namespace

TEST_CASE("the coefficients' names follow degree, then the powers of x and y") {
  const auto& names = jet_names();
  CHECK(names[0] == "e300");
  CHECK(names[1] == "e210");
  CHECK(names[2] == "e201");
  CHECK(names[9] == "e003");
  CHECK(names[10] == "e400");
  CHECK(names[24] == "e004");
  CHECK(names[25] == "e500");
  CHECK(names[45] == "e005");
  CHECK(std::set<std::string>(names.begin(), names.end()).size() == jet_size);
  for (int degree = 3; degree <= 5; ++degree)
    for (int a = 0; a <= degree; ++a)
      for (int b = 0; a + b <= degree; ++b) {
        const int c = degree - a - b;
        CHECK(names[jet_index(a, b, c)] == "e" + std::to_string(a) + std::to_string(b) + std::to_string(c));
      }
  CHECK(jet_terms_of_order(1) == 0);
  CHECK(jet_terms_of_order(2) == 10);
  CHECK(jet_terms_of_order(3) == 25);
  CHECK(jet_terms_of_order(4) == 46);
}

TEST_CASE("a jet's energy is its polynomial, up to the degree that is asked for and that it has") {
  const Vec3 d(0.7, -0.4, 1.1);
  for (int order = 1; order <= most_jet_order; ++order) {
    const EnergyJet jet = some_jet(order);
    for (int degree = 2; degree <= 5; ++degree) {
      double expected = 0;
      for (int a = 0; a <= 5; ++a)
        for (int b = 0; a + b <= 5; ++b)
          for (int c = 0; a + b + c <= 5; ++c)
            if (a + b + c >= 3 && a + b + c <= std::min(degree, order + 1))
              expected += jet.coefficients[jet_index(a, b, c)] * std::pow(d[0], a) * std::pow(d[1], b) *
                          std::pow(d[2], c);
      CHECK(jet_terms(jet, d, degree).energy == Approx(expected).margin(1e-15));
    }
  }
}

TEST_CASE("a jet's gradient and Hessian are its energy's, by central differences") {
  const EnergyJet jet = some_jet(4);
  const double h = 1e-5;
  for (const Vec3& d : {Vec3(0.7, -0.4, 1.1), Vec3(0, 0.3, 0), Vec3(0, 0, 0)}) {
    const JetTerms at = jet_terms(jet, d);
    Vec3 gradient;
    Mat3 hessian;
    for (int i = 0; i < 3; ++i) {
      const JetTerms up = jet_terms(jet, d + h * Vec3::Unit(i)), down = jet_terms(jet, d - h * Vec3::Unit(i));
      gradient[i] = (up.energy - down.energy) / (2 * h);
      hessian.col(i) = (up.gradient - down.gradient) / (2 * h);
    }
    CHECK((at.gradient - gradient).norm() < 1e-9);
    CHECK((at.hessian - hessian).norm() < 1e-8);
    CHECK(at.hessian == at.hessian.transpose());
  }
}
