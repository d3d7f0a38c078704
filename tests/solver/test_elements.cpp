// The discretisation alone, with every node free: exact fields and a manufactured solution.
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SparseCholesky>

#include "block_body.hpp"
#include "solver/body/law.hpp"
#include "solver/system/discretisation.hpp"
#include "tests/support/test.hpp"

namespace {

struct FreeBody {
  Body body;
  Discretisation d;
  std::vector<Vec3> nodes;  // mesh nodes and mid-edge nodes

  FreeBody(Law law, double poisson, int n, Element element, const Vec3& size = Vec3(1, 1, 1)) {
    body.mesh = block_mesh(n, n, n, size);
    body.material = {law, 5000, poisson};
    body.element = element;
    d = discretise(body);
    nodes = body.mesh.nodes;
    for (const auto& [a, b] : d.edges)
      nodes.push_back(0.5 * (body.mesh.nodes[static_cast<std::size_t>(a)] +
                             body.mesh.nodes[static_cast<std::size_t>(b)]));
  }
  std::vector<double> field(const std::function<Vec3(const Vec3&)>& u) const {
    std::vector<double> by_node, local(static_cast<std::size_t>(d.local_size()));
    for (const Vec3& x : nodes)
      for (int i = 0; i < 3; ++i) by_node.push_back(u(x)[i]);
    d.to_local(by_node, local.data());
    return local;
  }
  std::vector<double> gradient(const std::vector<double>& u, double* energy = nullptr) const {
    std::vector<double> r(u.size(), 0.0);
    const FieldSummary summary = d.elements.gradient(u.data(), r.data());
    if (energy) *energy = summary.energy;
    return r;
  }
};

bool on_side(const Vec3& x, int axis) {
  return x[axis] < 1e-9 || x[axis] > 1 - 1e-9;
}

}  // namespace

TEST_CASE("patch test: a homogeneous deformation leaves the inner nodes in equilibrium, energy and all") {
  Mat3 f;
  f << 1.1, 0.2, -0.05, 0.03, 0.9, 0.1, -0.1, 0.07, 1.2;
  for (const Law law : all_laws())
    for (const Element element : {Element::linear, Element::quadratic}) {
      const FreeBody b(law, 0.4, 3, element);
      double energy = 0;
      const auto r =
          b.gradient(b.field([&](const Vec3& x) { return Vec3((f - Mat3::Identity()) * x); }), &energy);
      const double psi = evaluate_law(law, b.d.elements.materials.front().constants, f).energy;
      CHECK(energy == Approx(psi).epsilon(1e-12));
      double inner = 0, all = 0;
      for (std::size_t node = 0; node < b.nodes.size(); ++node) {
        const double* at = &r[3 * static_cast<std::size_t>(b.d.local[node])];
        const double force = Vec3(at[0], at[1], at[2]).norm();
        all = std::max(all, force);
        if (!on_side(b.nodes[node], 0) && !on_side(b.nodes[node], 1) && !on_side(b.nodes[node], 2))
          inner = std::max(inner, force);
      }
      CHECK(all > 0);
      CHECK(inner < 1e-12 * all);
    }
}

TEST_CASE(
    "uniaxial stress: the lateral stretch of the law leaves the sides free of force, and the ends carry P "
    "A") {
  for (const Law law : all_laws())
    for (const double stretch : {0.8, 1.3}) {
      const FreeBody b(law, 0.4, 2, Element::linear);
      const auto stress_at = [&](double lateral) {
        return evaluate_law(law, b.d.elements.materials.front().constants,
                            Vec3(stretch, lateral, lateral).asDiagonal().toDenseMatrix())
            .stress;
      };
      double low = 0.5, high = 1.6;  // P_yy grows with the lateral stretch here
      REQUIRE(stress_at(low)(1, 1) < 0);
      REQUIRE(stress_at(high)(1, 1) > 0);
      for (int i = 0; i < 200; ++i)
        (stress_at(0.5 * (low + high))(1, 1) > 0 ? high : low) = 0.5 * (low + high);
      const auto r = b.gradient(b.field(
          [&](const Vec3& x) { return Vec3((stretch - 1) * x[0], (low - 1) * x[1], (low - 1) * x[2]); }));
      const double axial = stress_at(low)(0, 0);
      double pulled = 0, side = 0;
      for (std::size_t node = 0; node < b.nodes.size(); ++node) {
        const double* at = &r[3 * static_cast<std::size_t>(b.d.local[node])];
        if (b.nodes[node][0] > 1 - 1e-9) pulled += at[0];
        side = std::max({side, std::abs(at[1]), std::abs(at[2])});
        if (!on_side(b.nodes[node], 0)) side = std::max(side, std::abs(at[0]));
      }
      CHECK(pulled == Approx(axial).epsilon(1e-11));
      CHECK(side < 1e-11 * std::abs(axial));
    }
}

TEST_CASE(
    "rigid motion gives no force: turned and moved, for all laws but the linear one, which knows small turns "
    "only") {
  const Mat3 turn = (Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized())).toRotationMatrix();
  for (const Law law : all_laws()) {
    const FreeBody b(law, 0.45, 2, Element::quadratic);
    const Mat3 motion = law == Law::linear ? Mat3(Mat3::Identity() + 0.5 * (turn - turn.transpose())) : turn;
    double energy = 1;
    const auto r = b.gradient(
        b.field([&](const Vec3& x) { return Vec3((motion - Mat3::Identity()) * x + Vec3(0.3, -2, 5)); }),
        &energy);
    double largest = 0;
    for (const double v : r) largest = std::max(largest, std::abs(v));
    CHECK(largest < 1e-10 * b.d.elements.materials.front().constants.lambda);
    CHECK(std::abs(energy) < 1e-10 * b.d.elements.materials.front().constants.lambda);
  }
}

TEST_CASE("the Hessian is the gradient's derivative, and eight lanes equal one") {
  for (const Law law : all_laws())
    for (const Element element : {Element::linear, Element::quadratic}) {
      // threads share the loops of 4,000 elements and more
      const bool large = law == Law::neo_hookean && element == Element::linear;
      const FreeBody b(law, 0.4, large ? 9 : 1, element);
      CHECK(b.d.elements.is_large() == large);
      const auto u = b.field([](const Vec3& x) {
        return Vec3(0.1 * x[1] * x[1], 0.08 * x[0] * x[2], -0.12 * x[2] * x[0] * x[1]);
      });
      const auto direction =
          b.field([](const Vec3& x) { return Vec3(std::sin(3 * x[0]), x[1] - x[2], std::cos(2 * x[1])); });
      std::vector<double> blocks(9 * static_cast<std::size_t>(b.d.pattern.size() + 1), 0.0),
          product(u.size(), 0.0);
      b.d.elements.hessian(u.data(), blocks.data());
      for (std::int64_t i = 0; i < b.d.free_nodes; ++i)
        for (std::int64_t s = b.d.pattern.row_start[static_cast<std::size_t>(i)];
             s < b.d.pattern.row_start[static_cast<std::size_t>(i) + 1]; ++s)
          for (std::size_t a = 0; a < 3; ++a)
            for (std::size_t c = 0; c < 3; ++c) {
              const auto row = 3 * static_cast<std::size_t>(i) + a;
              const auto column =
                  3 * static_cast<std::size_t>(b.d.pattern.column[static_cast<std::size_t>(s)]) + c;
              const double h = blocks[9 * static_cast<std::size_t>(s) + 3 * a + c];
              product[row] += h * direction[column];
              if (row / 3 != column / 3) product[column] += h * direction[row];
            }
      const double step = 1e-5;
      auto up = u, down = u;
      for (std::size_t i = 0; i < u.size(); ++i) up[i] += step * direction[i], down[i] -= step * direction[i];
      const auto high = b.gradient(up), low = b.gradient(down);
      double largest = 0, wrong = 0;
      for (std::size_t i = 0; i < u.size(); ++i) {
        largest = std::max(largest, std::abs(product[i]));
        wrong = std::max(wrong, std::abs((high[i] - low[i]) / (2 * step) - product[i]));
      }
      CHECK(wrong < 1e-7 * largest);

      std::vector<double> many(8 * u.size()), along(24 * u.size(), 0.0), r(8 * u.size(), 0.0),
          y(24 * u.size(), 0.0), energy(8), least(8);
      for (std::size_t i = 0; i < u.size(); ++i)
        for (std::size_t l = 0; l < 8; ++l) {
          many[8 * i + l] = u[i] * (1 + 0.1 * static_cast<double>(l));
          along[8 * u.size() + 8 * i + l] = direction[i];
        }
      b.d.elements.gradient_lanes(many.data(), r.data(), energy.data(), least.data());
      b.d.elements.product_lanes(static_cast<std::int64_t>(8 * u.size()), many.data(), along.data(),
                                 y.data());
      for (std::size_t l = 0; l < 8; ++l) {
        auto one = u;
        for (double& v : one) v *= 1 + 0.1 * static_cast<double>(l);
        double expected = 0, off = 0, size = 0;
        const auto single = b.gradient(one, &expected);
        for (std::size_t i = 0; i < u.size(); ++i)
          off = std::max(off, std::abs(single[i] - r[8 * i + l])), size = std::max(size, std::abs(single[i]));
        CHECK(off < 1e-12 * size);
        CHECK(energy[l] == Approx(expected).epsilon(1e-12));
      }
      double off = 0;
      for (std::size_t i = 0; i < u.size(); ++i)
        off = std::max(off, std::abs(y[8 * u.size() + 8 * i] - product[i]));
      CHECK(off < 1e-12 * largest);
    }
}

namespace {

// Error in L2 of a manufactured solution on the unit cube, held on its whole boundary, by Newton.
double manufactured_error(Element element, int n) {
  const FreeBody b(Law::neo_hookean, 0.3, n, element);
  const auto exact = [](const Vec3& x) {
    return Vec3(0.05 * std::sin(2 * x[0]) * x[1], 0.04 * std::cos(1.5 * x[1]) * x[2] * x[2],
                0.06 * x[0] * std::sin(2 * x[2]));
  };
  const double h = 1e-3;
  const auto stress = [&](const Vec3& x) {
    Mat3 f = Mat3::Identity();
    for (int j = 0; j < 3; ++j)
      f.col(j) += (exact(x + h * Vec3::Unit(j)) - exact(x - h * Vec3::Unit(j))) / (2 * h);
    return evaluate_law(Law::neo_hookean, b.d.elements.materials.front().constants, f).stress;
  };
  const auto load = [&](const Vec3& x) {  // -Div P
    Vec3 sum = Vec3::Zero();
    for (int j = 0; j < 3; ++j)
      sum -= (stress(x + h * Vec3::Unit(j)).col(j) - stress(x - h * Vec3::Unit(j)).col(j)) / (2 * h);
    return sum;
  };
  // Points of a rule exact for degree three (Keast), fine enough for both elements.
  const double weights[5] = {-0.8, 0.45, 0.45, 0.45, 0.45};
  const std::size_t size = static_cast<std::size_t>(b.d.local_size());
  const auto per = static_cast<std::size_t>(b.d.elements.nodes_per_element);
  const auto shapes = [&](const double* l, double* value) {
    const int from[6] = {0, 0, 0, 1, 1, 2}, to[6] = {1, 2, 3, 2, 3, 3};
    for (int a = 0; a < 4; ++a) value[a] = per == 4 ? l[a] : l[a] * (2 * l[a] - 1);
    if (per == 10)
      for (int e = 0; e < 6; ++e) value[4 + e] = 4 * l[from[e]] * l[to[e]];
  };
  const auto each_point = [&](const auto& visit) {
    for (std::size_t t = 0; t < b.body.mesh.tets.size(); ++t)
      for (int q = 0; q < 5; ++q) {
        double l[4], value[10];
        for (int a = 0; a < 4; ++a) l[a] = q == 0 ? 0.25 : a == q - 1 ? 0.5 : 1.0 / 6;
        shapes(l, value);
        Vec3 x = Vec3::Zero();
        for (std::size_t a = 0; a < 4; ++a)
          x += l[a] * b.body.mesh.nodes[static_cast<std::size_t>(b.body.mesh.tets[t][a])];
        const std::int32_t* node = &b.d.elements.node[(t / 8) * per * 8 + t % 8];
        visit(x, weights[q] * tet_volume(b.body.mesh, t), value, node);
      }
  };
  std::vector<double> force(size, 0.0);
  each_point([&](const Vec3& x, double weight, const double* value, const std::int32_t* node) {
    const Vec3 f = load(x);
    for (std::size_t a = 0; a < per; ++a)
      for (int i = 0; i < 3; ++i)
        force[3 * static_cast<std::size_t>(node[8 * a]) + static_cast<std::size_t>(i)] +=
            weight * value[a] * f[i];
  });
  std::vector<int> row(3 * static_cast<std::size_t>(b.d.free_nodes), -1);
  int unknowns = 0;
  for (std::size_t node = 0; node < b.nodes.size(); ++node)
    if (!on_side(b.nodes[node], 0) && !on_side(b.nodes[node], 1) && !on_side(b.nodes[node], 2))
      for (std::size_t i = 0; i < 3; ++i) row[3 * static_cast<std::size_t>(b.d.local[node]) + i] = unknowns++;
  std::vector<double> u = b.field(exact);
  for (std::size_t i = 0; i < row.size(); ++i)
    if (row[i] >= 0) u[i] *= 0.5;  // not the solution
  for (int iteration = 0; iteration < 8; ++iteration) {
    const auto r = b.gradient(u);
    std::vector<double> blocks(9 * static_cast<std::size_t>(b.d.pattern.size() + 1), 0.0);
    b.d.elements.hessian(u.data(), blocks.data());
    std::vector<Eigen::Triplet<double>> entries;
    for (std::int64_t i = 0; i < b.d.free_nodes; ++i)
      for (std::int64_t s = b.d.pattern.row_start[static_cast<std::size_t>(i)];
           s < b.d.pattern.row_start[static_cast<std::size_t>(i) + 1]; ++s)
        for (std::size_t a = 0; a < 3; ++a)
          for (std::size_t c = 0; c < 3; ++c) {
            const int p = row[3 * static_cast<std::size_t>(i) + a];
            const int q =
                row[3 * static_cast<std::size_t>(b.d.pattern.column[static_cast<std::size_t>(s)]) + c];
            if (p < 0 || q < 0 || (p / 3 == q / 3 && c < a)) continue;
            entries.emplace_back(std::max(p, q), std::min(p, q),
                                 blocks[9 * static_cast<std::size_t>(s) + 3 * a + c]);
          }
    Eigen::SparseMatrix<double> matrix(unknowns, unknowns);
    matrix.setFromTriplets(entries.begin(), entries.end());
    Eigen::VectorXd right(unknowns);
    for (std::size_t i = 0; i < row.size(); ++i)
      if (row[i] >= 0) right[row[i]] = force[i] - r[i];
    Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factor(matrix);
    REQUIRE(factor.info() == Eigen::Success);
    const Eigen::VectorXd step = factor.solve(right);
    for (std::size_t i = 0; i < row.size(); ++i)
      if (row[i] >= 0) u[i] += step[row[i]];
    if (step.norm() < 1e-10) break;
  }
  double error = 0;
  each_point([&](const Vec3& x, double weight, const double* value, const std::int32_t* node) {
    Vec3 at = -exact(x);
    for (std::size_t a = 0; a < per; ++a)
      for (int i = 0; i < 3; ++i)
        at[i] += value[a] * u[3 * static_cast<std::size_t>(node[8 * a]) + static_cast<std::size_t>(i)];
    error += std::abs(weight) * at.squaredNorm();
  });
  return std::sqrt(error);
}

}  // namespace

TEST_CASE("a manufactured solution is approached as h^2 by linear and h^3 by quadratic tetrahedra") {
  const double coarse = manufactured_error(Element::linear, 4), fine = manufactured_error(Element::linear, 8);
  CHECK(std::log2(coarse / fine) > 1.8);
  const double coarse2 = manufactured_error(Element::quadratic, 2),
               fine2 = manufactured_error(Element::quadratic, 4);
  INFO(coarse << " " << fine << " " << coarse2 << " " << fine2);
  CHECK(std::log2(coarse2 / fine2) > 2.7);
}
