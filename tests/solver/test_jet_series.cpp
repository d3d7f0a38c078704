// The series of the energy along a path, of each law, against Boost.Math's automatic differentiation.
#include <Eigen/LU>
#include <boost/math/differentiation/autodiff.hpp>
#include <boost/math/special_functions/factorials.hpp>

#include "block_body.hpp"
#include "solver/jet/jet_maker.hpp"
#include "solver/system/discretisation.hpp"
#include "tests/support/test.hpp"

namespace {

using boost::math::differentiation::make_ftuple;
using boost::math::differentiation::make_fvar;

// psi(F) as the laws' papers write it, up to a constant.
template <class T>
T density(const Material& material, const std::array<T, 9>& f) {
  using std::log;
  const double mu = material.young / (2 * (1 + material.poisson));
  const double lambda =
      material.young * material.poisson / ((1 + material.poisson) * (1 - 2 * material.poisson));
  const auto c = [&](int i, int k) {
    T sum = f[static_cast<std::size_t>(i)] * f[static_cast<std::size_t>(k)];
    for (int r = 1; r < 3; ++r)
      sum += f[static_cast<std::size_t>(3 * r + i)] * f[static_cast<std::size_t>(3 * r + k)];
    return sum;
  };
  const T i1 = c(0, 0) + c(1, 1) + c(2, 2);
  T cc = c(0, 0) * c(0, 0);  // tr C^2
  for (int i = 0; i < 3; ++i)
    for (int k = i == 0 ? 1 : 0; k < 3; ++k) cc += c(i, k) * c(k, i);
  const T j = f[0] * (f[4] * f[8] - f[5] * f[7]) - f[1] * (f[3] * f[8] - f[5] * f[6]) +
              f[2] * (f[3] * f[7] - f[4] * f[6]);
  switch (material.law) {
    case Law::linear: {
      const T trace = f[0] + f[4] + f[8] - 3.0;
      const T xx = f[0] - 1.0, yy = f[4] - 1.0, zz = f[8] - 1.0, xy = 0.5 * (f[1] + f[3]),
              xz = 0.5 * (f[2] + f[6]), yz = 0.5 * (f[5] + f[7]);
      return 0.5 * lambda * trace * trace +
             mu * (xx * xx + yy * yy + zz * zz + 2.0 * (xy * xy + xz * xz + yz * yz));
    }
    case Law::st_venant_kirchhoff:
      return 0.125 * lambda * (i1 - 3.0) * (i1 - 3.0) + 0.25 * mu * (cc - 2.0 * i1 + 3.0);
    case Law::neo_hookean:
      return 0.5 * mu * (i1 - 3.0) - mu * log(j) + 0.5 * lambda * log(j) * log(j);
    case Law::mooney_rivlin:
      return 0.35 * mu * (i1 - 3.0 - 2.0 * log(j)) +
             0.15 * mu * (0.5 * (i1 * i1 - cc) - 3.0 - 4.0 * (j - 1.0)) + 0.5 * lambda * log(j) * log(j);
    case Law::stable_neo_hookean: {
      const double m = 4 * mu / 3, l = lambda + 5 * mu / 6, a = 1 + m / l - m / (4 * l);
      return 0.5 * m * (i1 - 3.0) + 0.5 * l * (j - a) * (j - a) - 0.5 * m * log(i1 + 1.0);
    }
  }
  return i1;
}

Mat3 random_matrix(std::mt19937& random, double size) {
  std::uniform_real_distribution<double> uniform(-size, size);
  Mat3 m;
  for (int i = 0; i < 9; ++i) m(i / 3, i % 3) = uniform(random);
  return m;
}

// Every node of a block is free, and all fields are affine in the place X, so that F is the same everywhere.
struct AffineBlock {
  Discretisation d;
  std::vector<Vec3> places;
  double volume = 0.02 * 0.01 * 0.03;

  AffineBlock(const Material& material, Element element) {
    Body body;
    body.mesh = block_mesh(2, 1, 1, Vec3(0.02, 0.01, 0.03));
    body.material = material;
    body.element = element;
    d = discretise(body);
    places = body.mesh.nodes;
    for (const auto& [a, b] : d.edges) places.push_back(0.5 * (body.mesh.nodes[a] + body.mesh.nodes[b]));
  }
  std::vector<double> field(const Mat3& gradient) const {
    std::vector<double> by_node, u(static_cast<std::size_t>(d.local_size()));
    for (const Vec3& place : places)
      for (const double component : Vec3(gradient * place)) by_node.push_back(component);
    d.to_local(by_node, u.data());
    return u;
  }
};

struct Path {
  Mat3 f;                 // at the start
  std::array<Mat3, 3> u;  // gradients of the tangent
  std::array<Mat3, 6> v;  // of V
  explicit Path(unsigned seed) {
    std::mt19937 random(seed);
    f = Mat3::Identity() + random_matrix(random, 0.2);
    for (Mat3& m : u) m = random_matrix(random, 0.4);
    for (Mat3& m : v) m = random_matrix(random, 0.3);
  }
};

// f + t first + t^2 second, entry by entry
template <class T>
std::array<T, 9> along(const Mat3& f, const Mat3& first, const Mat3& second, const T& t) {
  std::array<T, 9> out;
  for (int i = 0; i < 9; ++i)
    out[static_cast<std::size_t>(i)] =
        f(i / 3, i % 3) + first(i / 3, i % 3) * t + second(i / 3, i % 3) * t * t;
  return out;
}

// Products of the components of d, in the order of V's fields.
std::array<double, 6> pair_products(const Vec3& d) {
  return {d[0] * d[0], d[0] * d[1], d[0] * d[2], d[1] * d[1], d[1] * d[2], d[2] * d[2]};
}

double of_degree(const EnergyJet& jet, const Vec3& d, int degree) {
  return jet_terms(jet, d, degree).energy - jet_terms(jet, d, degree - 1).energy;
}

void check_path(const Material& material, Element element, const Path& path) {
  const AffineBlock block(material, element);
  const auto size = static_cast<std::size_t>(block.d.local_size());
  const std::vector<double> u = block.field(path.f - Mat3::Identity());
  std::vector<double> tangent, v(size * lane_count, 0.0);
  for (const Mat3& m : path.u) {
    const std::vector<double> field = block.field(m);
    tangent.insert(tangent.end(), field.begin(), field.end());
  }
  for (std::size_t p = 0; p < 6; ++p) {
    const std::vector<double> field = block.field(path.v[p]);
    for (std::size_t i = 0; i < size; ++i) v[i * lane_count + p] = field[i];
  }
  EnergyJet jet{.order = 4};
  block.d.elements.path(block.d.local_size(), u.data(), tangent.data(), v.data(),
                        jet.coefficients.data() + 10, {});
  EnergyJet straight{.order = 3};
  block.d.elements.path(block.d.local_size(), u.data(), tangent.data(), nullptr,
                        straight.coefficients.data() + 10, {});
  CHECK(std::ranges::all_of(straight.coefficients.begin() + 25, straight.coefficients.end(),
                            [](double value) { return value == 0; }));
  for (std::size_t k = 0; k < limit_direction_count; ++k) {
    const Vec3 way(limit_directions().data() + 3 * k);
    Mat3 first = Mat3::Zero(), second = Mat3::Zero();
    for (int i = 0; i < 3; ++i) first += way[i] * path.u[static_cast<std::size_t>(i)];
    for (std::size_t p = 0; p < 6; ++p) second += pair_products(way)[p] * path.v[p];
    const auto psi = density(material, along(path.f, first, second, make_fvar<double, 5>(0.0)));
    const auto unbent = density(material, along(path.f, first, Mat3::Zero(), make_fvar<double, 5>(0.0)));
    double largest = 0;
    for (unsigned n = 2; n <= 5; ++n)
      largest = std::max(largest, std::abs(psi.derivative(n) / boost::math::factorial<double>(n)));
    const double margin = 1e-11 * block.volume * largest, fourth = block.volume * unbent.derivative(4) / 24;
    CHECK(of_degree(jet, way, 4) == Approx(fourth).margin(margin));
    CHECK(of_degree(straight, way, 4) == Approx(fourth).margin(margin));
    CHECK(of_degree(jet, way, 5) == Approx(block.volume * psi.derivative(5) / 120).margin(margin));
  }
}

// The second Taylor coefficient of dW/du along d, in the product with an affine field of gradient `test`.
void check_curvature(const Material& material, Element element, const Path& path) {
  const AffineBlock block(material, element);
  const auto size = static_cast<std::size_t>(block.d.local_size());
  const std::vector<double> u = block.field(path.f - Mat3::Identity());
  std::vector<double> tangent, q(size * lane_count, 0.0);
  for (const Mat3& m : path.u) {
    const std::vector<double> field = block.field(m);
    tangent.insert(tangent.end(), field.begin(), field.end());
  }
  block.d.elements.curvature(block.d.local_size(), u.data(), tangent.data(), q.data(), {});
  for (std::size_t k = 0; k < limit_direction_count; ++k) {
    const Vec3 way(limit_directions().data() + 3 * k);
    Mat3 first = Mat3::Zero();
    for (int i = 0; i < 3; ++i) first += way[i] * path.u[static_cast<std::size_t>(i)];
    for (const Mat3& test : path.v) {
      const std::vector<double> field = block.field(test);
      double found = 0;
      for (std::size_t i = 0; i < size; ++i)
        for (std::size_t p = 0; p < 6; ++p) found += field[i] * q[i * lane_count + p] * pair_products(way)[p];
      const auto variables = make_ftuple<double, 2, 1>(0.0, 0.0);
      const auto& t = std::get<0>(variables);
      const auto& s = std::get<1>(variables);
      using Both = decltype(t * s);
      std::array<Both, 9> f;
      for (int i = 0; i < 9; ++i)
        f[static_cast<std::size_t>(i)] =
            path.f(i / 3, i % 3) + first(i / 3, i % 3) * t + test(i / 3, i % 3) * s;
      const double expected = 0.5 * density(material, f).derivative(2, 1);
      CHECK(found == Approx(block.volume * expected).epsilon(1e-10).margin(1e-10 * block.volume * 5000));
    }
  }
}

}  // namespace

TEST_CASE("each law's energy along a path: coefficients of t^4 and t^5") {
  for (const Law law : all_laws())
    for (const Element element : {Element::linear, Element::quadratic})
      for (unsigned seed = 1; seed <= 4; ++seed) {
        INFO(name(law) << " " << name(element) << " " << seed);
        check_path({law, 5000, 0.4}, element, Path(seed));
      }
}

TEST_CASE("each law's force along a line: the second coefficient") {
  for (const Law law : all_laws())
    for (const Element element : {Element::linear, Element::quadratic})
      for (unsigned seed = 1; seed <= 3; ++seed) {
        INFO(name(law) << " " << name(element) << " " << seed);
        check_curvature({law, 5000, 0.4}, element, Path(seed));
      }
}
