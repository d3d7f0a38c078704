// The pad's springs: integrals over the surface, and what a solved body makes of them.
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include "pad_body.hpp"
#include "solver/body/pad.hpp"
#include "solver/system/discretisation.hpp"
#include "tests/support/test.hpp"

namespace {

using Springs = std::array<std::array<double, 6>, 6>;

std::array<double, 6> shapes_of(const Vec3& l, int nodes) {
  if (nodes == 3) return {l[0], l[1], l[2]};
  std::array<double, 6> n{};
  for (int i = 0; i < 3; ++i) {
    n[static_cast<std::size_t>(i)] = l[i] * (2 * l[i] - 1);
    n[static_cast<std::size_t>(3 + i)] = 4 * l[i] * l[(i + 1) % 3];
  }
  return n;
}

// int 3 k_p / (pi r^2) (1 - |y - s|^2 / r^2)^2 N_i N_j dA over the facet within the ball: the facet is split into
// n^2 triangles, each with the rule of its three mid-edges. Its error falls as n^-3, for the integrand's second
// derivative jumps at the rim.
Springs split_facet(const TetMesh& mesh, const Pad& pad, const Triangle& facet, int nodes, int n) {
  const Vec3 a = mesh.nodes[facet[0]], b = mesh.nodes[facet[1]], c = mesh.nodes[facet[2]];
  const double area = 0.5 * (b - a).cross(c - a).norm(), r2 = pad.radius * pad.radius;
  Springs sum{};
  const auto at = [&](double i, double j) {
    const Vec3 l(1 - (i + j) / n, i / n, j / n);
    const double fall = 1 - (l[0] * a + l[1] * b + l[2] * c - pad.site).squaredNorm() / r2;
    if (fall <= 0) return;
    const double density = 3 * pad.stiffness / (std::numbers::pi * r2) * fall * fall * area / (3.0 * n * n);
    const std::array<double, 6> shape = shapes_of(l, nodes);
    for (std::size_t p = 0; p < 6; ++p)
      for (std::size_t q = 0; q < 6; ++q) sum[p][q] += density * shape[p] * shape[q];
  };
  for (int i = 0; i < n; ++i)
    for (int j = 0; i + j < n; ++j) {
      at(i + 0.5, j), at(i, j + 0.5), at(i + 0.5, j + 0.5);
      if (i + j < n - 1) at(i + 0.5, j + 1), at(i + 1, j + 0.5), at(i + 0.5, j + 0.5);
    }
  return sum;
}

double sum_of(const Springs& springs) {
  double sum = 0;
  for (const auto& row : springs)
    for (const double value : row) sum += value;
  return sum;
}

double turned_away(double cosine) {
  const double tau = std::clamp(2 * cosine, 0.0, 1.0);
  return 3 * tau * tau - 2 * tau * tau * tau;
}

// The largest difference of an entry from the split facets' [N/m].
double entry_error(const TetMesh& mesh, const Pad& pad, int nodes) {
  const PadSurface surface = pad_surface(mesh, pad, nodes);
  REQUIRE_FALSE(surface.other_part);
  std::vector<std::pair<Triangle, Springs>> split;
  Vec3 mean = Vec3::Zero();
  const auto normal_of = [&](const Triangle& t) {
    return Vec3(
        (mesh.nodes[t[1]] - mesh.nodes[t[0]]).cross(mesh.nodes[t[2]] - mesh.nodes[t[0]]).normalized());
  };
  for (const Triangle& t : boundary_triangles(mesh)) {
    const Springs springs = split_facet(mesh, pad, t, nodes, 150);
    if (sum_of(springs) == 0) continue;
    split.emplace_back(t, springs);
    mean += sum_of(springs) * normal_of(t);
  }
  CHECK((surface.normal - mean.normalized()).norm() < 1e-6);
  double worst = 0, all = 0;
  for (const auto& [corners, springs] : split) {
    const double share = turned_away(normal_of(corners).dot(mean.normalized()));
    const auto found = std::ranges::find(surface.facets, corners, &PadFacet::corners);
    for (std::size_t i = 0; i < 6; ++i)
      for (std::size_t j = 0; j < 6; ++j) {
        const double own = found == surface.facets.end() ? 0 : found->springs[i][j];
        worst = std::max(worst, std::abs(own - share * springs[i][j]));
      }
    all += share * sum_of(springs);
  }
  CHECK(std::abs(surface.stiffness - all) < 1e-6 * pad.stiffness);
  return worst;
}

Eigen::MatrixXd matrix_of(const Discretisation& d) {
  std::map<std::int32_t, Eigen::Index> row;
  for (const PadSprings::Pair& p : d.elements.pad.pairs)
    for (const std::int32_t node : {p.a, p.b}) row.try_emplace(node, static_cast<Eigen::Index>(row.size()));
  const auto size = static_cast<Eigen::Index>(row.size());
  Eigen::MatrixXd m = Eigen::MatrixXd::Zero(size, size);
  for (const PadSprings::Pair& p : d.elements.pad.pairs) {
    m(row[p.a], row[p.b]) += p.stiffness;
    if (p.a != p.b) m(row[p.b], row[p.a]) += p.stiffness;
  }
  return m;
}

}  // namespace

TEST_CASE("On a flat surface the springs of a pad sum to its stiffness over a disc") {
  const TetMesh mesh = block_mesh(7, 6, 2, Vec3(0.1, 0.09, 0.03));
  for (const int nodes : {3, 6})
    for (const Vec3& site : {Vec3(0.05, 0.045, 0.03), Vec3(0.0512, 0.0407, 0.03), Vec3(1.0 / 70, 0.03, 0)}) {
      const Pad pad{.site = site, .radius = 0.014, .stiffness = 1000};
      const PadSurface surface = pad_surface(mesh, pad, nodes);
      CHECK(surface.stiffness == Approx(1000).epsilon(1e-9));
      CHECK(surface.area == Approx(std::numbers::pi * 0.014 * 0.014).epsilon(1e-9));
      CHECK((surface.normal - (site.z() > 0 ? 1 : -1) * Vec3::UnitZ()).norm() < 1e-12);
      CHECK_FALSE(surface.other_part);
    }
}

TEST_CASE("Each entry of the springs is the integral over the facet within the ball") {
  const TetMesh block = block_mesh(5, 2, 2, Vec3(0.1, 0.04, 0.04)), liver = phantom("liver", 600),
                ball = phantom("ball", 400);
  for (const int nodes : {3, 6}) {
    const auto error = [&](const TetMesh& mesh, const Vec3& place, double radius) {
      return entry_error(mesh, {.site = nearest_site(mesh, place), .radius = radius, .stiffness = 1000},
                         nodes);
    };
    CHECK(error(block, Vec3(0.047, 0.018, 0.04), 0.013) < 1e-3);  // 1e-6 of 1000 N/m
    CHECK(error(block, Vec3(0.053, 0.04, 0.04), 0.015) < 1e-3);   // at an edge
    CHECK(error(block, Vec3(0.1, 0.037, 0.038), 0.015) < 1e-3);   // beside a corner
    CHECK(error(liver, phantom_tip("liver"), 0.02) < 1e-3);
    CHECK(error(ball, phantom_tip("ball") + Vec3(0.003, 0.002, 0), 0.02) < 1e-3);
  }
}

TEST_CASE("At an edge of 90 degrees the springs sum to a little more than on a flat surface") {
  const TetMesh mesh = block_mesh(4, 4, 4, Vec3(0.1, 0.1, 0.1));
  const auto share = [&](double from_edge) {
    return pad_surface(mesh, {.site = Vec3(0.05, 0.1 - from_edge, 0.1), .radius = 0.02, .stiffness = 1})
        .stiffness;
  };
  CHECK(share(0.02) == Approx(1).epsilon(1e-9));
  CHECK(share(0) == Approx(1).epsilon(1e-9));  // two half discs, each at 45 degrees to the mean normal
  CHECK(share(0.005) > 1);
  CHECK(share(0.005) < 1.2);
}

TEST_CASE(
    "The matrix of the pad is symmetric and positive, and a common shift of body and tip costs nothing") {
  for (const Element element : {Element::linear, Element::quadratic}) {
    for (const auto& body : {padded_block(Law::neo_hookean, element),
                             padded_phantom("liver", 600, phantom_tip("liver"), Law::neo_hookean, element)}) {
      for (const PadFacet& facet :
           pad_surface(body->mesh, *body->pad, element == Element::linear ? 3 : 6).facets)
        for (std::size_t i = 0; i < 6; ++i)
          for (std::size_t j = 0; j < i; ++j) CHECK(facet.springs[i][j] == Approx(facet.springs[j][i]));
      const Eigen::MatrixXd m = matrix_of(discretise(*body));
      const Eigen::VectorXd eigenvalues = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(m).eigenvalues();
      CHECK(eigenvalues.minCoeff() > -1e-12 * body->pad->stiffness);
      CHECK(m.rowwise().sum().cwiseAbs().maxCoeff() < 1e-12 * body->pad->stiffness);
    }
  }
}

TEST_CASE("With a pad the energy's gradient is minus the force, and the stiffness is the force's") {
  for (const Law law : all_laws())
    for (const Element element : {Element::linear, Element::quadratic}) {
      INFO(name(law) << " " << name(element));
      Solver solver(padded_block(law, element));
      check_derivatives(solver, Vec3(0.006, 0.004, -0.009), 1e-6, {.tolerance = 1e-12});
    }
}

TEST_CASE("A pad is in series with the body, and with stiff springs nearly rigid") {
  const auto body = padded_block(Law::neo_hookean);
  const auto stiffness = [&](double springs) {
    body->pad->stiffness = springs;
    return Solver(body).reference(Vec3::Zero(), 0.006).state.stiffness;
  };
  const double total = pad_surface(body->mesh, *body->pad).stiffness / body->pad->stiffness;
  Mat3 last = Mat3::Zero();
  for (const double springs : {0.01, 1.0, 100.0, 1e4, 1e6}) {
    const Mat3 k = stiffness(springs);
    const Eigen::SelfAdjointEigenSolver<Mat3> grown(k - last), left(springs * total * Mat3::Identity() - k);
    CHECK(grown.eigenvalues().minCoeff() > 0);
    CHECK(left.eigenvalues().minCoeff() > 0);  // softer than its springs alone
    last = k;
  }
  const Mat3 soft = stiffness(1e-4);
  CHECK((soft - 1e-4 * total * Mat3::Identity()).norm() < 1e-5 * soft.norm());
}

TEST_CASE("Pads that cannot be solved are refused, and doubtful ones are named") {
  const auto good = padded_block(Law::neo_hookean);
  CHECK(check(*good, "scene.toml").empty());
  const auto refusal = [&](const std::function<void(Body&)>& spoil) {
    Body body = *good;
    spoil(body);
    return error_of([&] { check(body, "scene.toml"); });
  };

  CHECK_THAT(refusal([](Body& b) { b.contact = {7}; }),
             Contains("scene.toml: contact: both nodes and a pad"));
  CHECK_THAT(refusal([](Body& b) { b.pad->site += Vec3(0, 0, 0.021); }),
             Contains("contact: no surface under the pad at (0.07, 0.021, 0.061)"));
  CHECK_THAT(refusal([](Body& b) { b.pad->site -= Vec3(0, 0, 0.02); }), Contains("no surface under the pad"));
  CHECK_THAT(refusal([](Body& b) {
               b.clamp.clear();
               for (std::size_t i = 0; i < b.mesh.nodes.size(); ++i)
                 if (b.mesh.nodes[i].z() > 0.039) b.clamp.push_back(static_cast<NodeIndex>(i));
             }),
             Contains("all nodes under the pad are clamped"));
  for (const double wrong : {0.0, -1.0, std::nan(""), HUGE_VAL}) {
    CHECK_THAT(refusal([&](Body& b) { b.pad->radius = wrong; }), Contains("expected both above 0"));
    CHECK_THAT(refusal([&](Body& b) { b.pad->stiffness = wrong; }), Contains("expected both above 0"));
  }
  Body thin = *good;  // the ball reaches the lower side of a plate, far from its rim
  thin.mesh = block_mesh(5, 5, 1, Vec3(0.2, 0.2, 0.02));
  thin.clamp = {0, 1, 6};
  thin.pad = Pad{.site = Vec3(0.1, 0.1, 0.02), .radius = 0.025, .stiffness = 800};
  CHECK_THAT(check(thin, "scene.toml").front(), Contains("another part of the surface"));
  thin.pad->radius = 0.019;
  CHECK(check(thin, "scene.toml").empty());
  Body corner = *good;
  corner.pad->radius = 0.5;  // wider than the body
  CHECK_THAT(check(corner, "scene.toml").front(), Contains("less than 0.3 of its 800 N/m"));
}
