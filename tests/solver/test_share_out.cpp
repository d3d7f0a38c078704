// One solve of a large body, shared by threads: its factor against Eigen's, and the same bits whoever does the parts.
#include <Eigen/SparseCholesky>
#include <atomic>
#include <thread>

#include "block_body.hpp"
#include "solver/equilibrium/lane_solver.hpp"
#include "solver/equilibrium/newton.hpp"
#include "solver/system/share_out.hpp"

namespace {

struct Backwards : Crew {  // the last part first
  std::size_t most = 0;
  void share(std::size_t count, const std::function<void(std::size_t)>& part) override {
    most = std::max(most, count);
    for (std::size_t i = count; i-- > 0;) part(i);
  }
};

struct ThreeThreads : Crew {
  void share(std::size_t count, const std::function<void(std::size_t)>& part) override {
    std::atomic<std::size_t> next = 0;
    const auto run = [&] {
      for (std::size_t i = next++; i < count; i = next++) part(i);
    };
    std::thread second(run), third(run);
    run();
    second.join();
    third.join();
  }
};

std::shared_ptr<Body> cube() {
  auto body = std::make_shared<Body>();
  body->mesh = block_mesh(11, 11, 11, Vec3(0.1, 0.1, 0.1));
  body->material = {Law::neo_hookean, 5000, 0.4};
  for (std::size_t i = 0; i < body->mesh.nodes.size(); ++i) {
    const Vec3& x = body->mesh.nodes[i];
    if (x[2] < 1e-9) body->clamp.push_back(static_cast<NodeIndex>(i));
    if ((x - Vec3(0.05, 0.05, 0.1)).norm() < 0.015) body->contact.push_back(static_cast<NodeIndex>(i));
  }
  return body;
}

using Sparse = Eigen::SparseMatrix<double>;

// H over the free nodes and the contact.
Sparse matrix_of(const Discretisation& d, const std::vector<double>& blocks) {
  std::vector<Eigen::Triplet<double>> entries;
  for (std::size_t i = 0; i <= static_cast<std::size_t>(d.free_nodes); ++i)
    for (std::int64_t s = d.pattern.row_start[i]; s < d.pattern.row_start[i + 1]; ++s)
      for (int a = 0; a < 3; ++a)
        for (int c = 0; c < 3; ++c) {
          const int p = 3 * static_cast<int>(i) + a,
                    q = 3 * static_cast<int>(d.pattern.column[static_cast<std::size_t>(s)]) + c;
          const double value = blocks[static_cast<std::size_t>(9 * s + 3 * a + c)];
          entries.emplace_back(p, q, value);
          if (p / 3 != q / 3) entries.emplace_back(q, p, value);
        }
  const int size = 3 * static_cast<int>(d.free_nodes + 1);
  Sparse h(size, size);
  h.setFromTriplets(entries.begin(), entries.end());
  return h;
}

// A displacement of the free nodes, zero at the clamp.
std::vector<double> bent(const Discretisation& d) {
  std::vector<double> u(static_cast<std::size_t>(d.local_size()));
  for (std::size_t i = 0; i + 3 < u.size(); ++i) u[i] = 4e-4 * std::sin(0.37 * static_cast<double>(i));
  return u;
}

}  // namespace

TEST_CASE("the factor of a large body, cut into subtrees and fronts, solves what Eigen's does") {
  const auto d = analyse(*cube());
  REQUIRE(cost_of_factor(*d).flops > 1e8);  // what is worth sharing
  std::vector<double> blocks(9 * static_cast<std::size_t>(d->pattern.size() + 1), 0.0);
  const std::vector<double> u = bent(*d);
  d->elements.hessian(u.data(), blocks.data());
  const Sparse h = matrix_of(*d, blocks);
  const int rows = 3 * static_cast<int>(d->free_nodes);
  const Sparse free = h.topLeftCorner(rows, rows);
  const Eigen::SimplicialLDLT<Sparse> oracle(free);
  REQUIRE(oracle.info() == Eigen::Success);
  const Eigen::MatrixXd coupling = h.topRightCorner(rows, 3);
  const Eigen::MatrixXd tangent = -oracle.solve(coupling);
  const Mat3 stiffness = Mat3(h.bottomRightCorner(3, 3)) + coupling.transpose() * tangent;
  Backwards crew;
  for (const Precision precision : {Precision::exact, Precision::single}) {
    const double share = precision == Precision::exact ? 1e-11 : 1e-4;
    const WithCrew with(&crew);
    Factorisation factor(*d, precision);
    REQUIRE(factor.compute(blocks.data()));
    CHECK(crew.most > 8);
    CHECK((factor.stiffness() - stiffness).norm() < share * stiffness.norm());
    std::vector<double> v(3 * u.size());
    factor.tangent(v.data());
    for (std::size_t c = 0; c < 3; ++c) {
      const Eigen::Map<const Eigen::VectorXd> its(v.data() + c * u.size(), rows);
      CHECK((its - tangent.col(static_cast<int>(c))).norm() < share * tangent.norm());
    }
    std::vector<double> b(u), lanes(24 * u.size());
    for (std::size_t i = 0; i < lanes.size(); ++i)
      lanes[i] = u[i / 8 % u.size()] * static_cast<double>(1 + i % 8);
    factor.solve(b.data());
    factor.solve_lanes(lanes.data(), 3, static_cast<std::int64_t>(8 * u.size()));
    const Eigen::VectorXd x = oracle.solve(Eigen::Map<const Eigen::VectorXd>(u.data(), rows));
    CHECK((Eigen::Map<const Eigen::VectorXd>(b.data(), rows) - x).norm() < share * x.norm());
    for (const std::size_t field : {0U, 2U})
      for (const std::size_t lane : {0U, 7U}) {
        Eigen::VectorXd its(rows);
        for (int i = 0; i < rows; ++i)
          its[i] = lanes[8 * (field * u.size() + static_cast<std::size_t>(i)) + lane];
        const double scale = static_cast<double>(1 + lane);
        CHECK((its - scale * x).norm() < share * scale * x.norm());
      }
  }
}

TEST_CASE(
    "a large body's factor is refused where the matrix is not positive definite, whichever part finds it") {
  const auto d = analyse(*cube());
  std::vector<double> blocks(9 * static_cast<std::size_t>(d->pattern.size() + 1), 0.0);
  const std::vector<double> rest(static_cast<std::size_t>(d->local_size()), 0.0);
  d->elements.hessian(rest.data(), blocks.data());
  Factorisation factor(*d);
  REQUIRE(factor.compute(blocks.data()));
  for (const std::int64_t node : {std::int64_t{3}, d->free_nodes / 2, d->free_nodes - 1}) {
    auto wrong = blocks;
    wrong[9 * static_cast<std::size_t>(d->pattern.row_start[static_cast<std::size_t>(node)])] = -1;
    CHECK_FALSE(factor.compute(wrong.data()));
  }
  CHECK(factor.compute(blocks.data()));
}

TEST_CASE("a state of a large body has the same bits whoever does the parts") {
  const auto d = analyse(*cube());
  const auto solve = [&](Crew* crew) {
    const WithCrew with(crew);
    NewtonSolver newton(d, Precision::single);
    LaneSolver lanes(d);
    LocalField field{bent(*d), std::vector<double>(3 * static_cast<std::size_t>(d->local_size()))};
    std::fill(field.u.begin(), field.u.end(), 0.0);
    const Vec3 x(0.002, -0.001, -0.003);
    std::copy_n(x.data(), 3, field.u.end() - 6);
    REQUIRE(newton.solve(field.u, 1e-4, 30, {}).status == SolveStatus::converged);
    newton.factor().tangent(field.tangent.data());
    std::vector<LocalField*> fields{&field};
    std::array<LaneResult, lane_count> results;
    lanes.solve(newton.factor(), fields, 1e-9, results, 10, &newton);
    REQUIRE(results[0].converged);
    CHECK(results[0].stiffness_settled);
    field.u.insert(field.u.end(), results[0].force.begin(), results[0].force.end());
    field.u.insert(field.u.end(), results[0].stiffness.reshaped().begin(),
                   results[0].stiffness.reshaped().end());
    return field.u;
  };
  const std::vector<double> alone = solve(nullptr);
  Backwards backwards;
  ThreeThreads three;
  CHECK(solve(&backwards) == alone);
  CHECK(solve(&three) == alone);
}
