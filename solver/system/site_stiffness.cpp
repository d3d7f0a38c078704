#include "solver/system/site_stiffness.hpp"

#include <algorithm>
#include <unordered_map>
#include <vector>

#include "geometry/common/dense.hpp"
#include "geometry/common/error.hpp"
#include "solver/system/factorisation.hpp"

namespace forefeel {
namespace {

Body freed_of_contact(Body body) {
  body.pad.reset();
  body.contact.clear();
  body.fine.reset();
  return body;
}

// Free local nodes of the surface, mid-edge nodes included, ascending.
std::vector<std::int32_t> surface_nodes(const Body& body, const Discretisation& d) {
  std::vector<std::int32_t> nodes;
  std::vector<bool> touched(body.mesh.nodes.size(), false);
  for (const Triangle& triangle : boundary_triangles(body.mesh))
    for (const NodeIndex node : triangle) touched[node] = true;
  for (std::size_t node = 0; node < touched.size(); ++node)
    if (touched[node]) nodes.push_back(d.local[node]);
  for (std::size_t e = 0; e < d.edges.size(); ++e)  // of all edges between surface nodes; a few lie inside
    if (touched[d.edges[e][0]] && touched[d.edges[e][1]])
      nodes.push_back(d.local[body.mesh.nodes.size() + e]);
  std::erase_if(nodes, [&](std::int32_t node) { return node >= d.free_nodes; });
  std::ranges::sort(nodes);
  return nodes;
}

}  // namespace

struct SiteStiffness::Impl {
  Body body;
  Discretisation d;
  Factorisation factor;
  std::vector<std::int32_t> surface;                              // local nodes
  std::unordered_map<std::int32_t, std::vector<double>> columns;  // local node -> surface nodes x 3 x 3 [m/N]
  std::vector<double> lanes;

  explicit Impl(Body given) : body(std::move(given)), d(discretise(freed_of_contact(body))), factor(d) {
    surface = surface_nodes(body, d);
    lanes.resize(static_cast<std::size_t>(d.local_size()) * lane_count);
    std::vector<double> blocks(9 * static_cast<std::size_t>(d.pattern.size() + 1), 0.0);
    const std::vector<double> rest(static_cast<std::size_t>(d.local_size()), 0.0);
    d.elements.hessian(rest.data(), blocks.data());
    if (!factor.compute(blocks.data())) throw InputError("body", "has no stable equilibrium at rest");
  }

  // Eight columns of C at a time: the nodes' three components one after the other.
  void solve_columns(const std::vector<std::int32_t>& nodes) {
    for (std::size_t first = 0; first < 3 * nodes.size(); first += lane_count) {
      const std::size_t last = std::min(first + lane_count, 3 * nodes.size());
      std::ranges::fill(lanes, 0.0);
      for (std::size_t k = first; k < last; ++k)
        lanes[(3 * static_cast<std::size_t>(nodes[k / 3]) + k % 3) * lane_count + (k - first)] = 1;
      factor.solve_lanes(lanes.data());
      for (std::size_t k = first; k < last; ++k) {
        std::vector<double>& column = columns[nodes[k / 3]];
        column.resize(9 * surface.size());
        for (std::size_t i = 0; i < surface.size(); ++i)
          for (std::size_t c = 0; c < 3; ++c)
            column[9 * i + 3 * c + k % 3] =
                lanes[(3 * static_cast<std::size_t>(surface[i]) + c) * lane_count + (k - first)];
      }
    }
  }

  std::size_t place(std::int32_t node) const {
    return static_cast<std::size_t>(std::ranges::lower_bound(surface, node) - surface.begin());
  }
};

SiteStiffness::SiteStiffness(Body body) {
  if (!body.pad) throw InputError("pad", "missing, expected a body with a pad");
  impl_ = std::make_unique<Impl>(std::move(body));
}
SiteStiffness::~SiteStiffness() = default;
SiteStiffness::SiteStiffness(SiteStiffness&&) noexcept = default;

std::size_t SiteStiffness::known_nodes() const {
  return impl_->columns.size();
}

Mat3 SiteStiffness::at(const Vec3& site) {
  impl_->body.pad->site = site;
  const PadSprings springs = pad_springs(impl_->body, impl_->d);
  const auto tip = static_cast<std::int32_t>(impl_->d.free_nodes);
  std::vector<std::int32_t> nodes, unknown_nodes;
  double total = 0;
  for (const PadSprings::Pair& pair : springs.pairs) {
    if (pair.a == tip) total = pair.stiffness;
    if (pair.b == tip && pair.a != tip) nodes.push_back(pair.a);
  }
  for (const std::int32_t node : nodes)
    if (!impl_->columns.contains(node)) unknown_nodes.push_back(node);
  impl_->solve_columns(unknown_nodes);
  const auto size = static_cast<Eigen::Index>(3 * nodes.size());
  const auto row = [&](std::int32_t node) {
    return static_cast<Eigen::Index>(3 * (std::ranges::lower_bound(nodes, node) - nodes.begin()));
  };
  Eigen::MatrixXd m = Eigen::MatrixXd::Zero(size, size), compliance(size, size),
                  pull = Eigen::MatrixXd::Zero(size, 3);
  for (const PadSprings::Pair& pair : springs.pairs) {
    if (pair.a == tip) continue;
    if (pair.b == tip) {
      pull.block<3, 3>(row(pair.a), 0) = -pair.stiffness * Mat3::Identity();
      continue;
    }
    const Eigen::Index a = row(pair.a), b = row(pair.b);
    m.block<3, 3>(a, b) = m.block<3, 3>(b, a) = pair.stiffness * Mat3::Identity();
  }
  for (const std::int32_t from : nodes) {
    const std::vector<double>& column = impl_->columns.at(from);
    for (const std::int32_t to : nodes)
      compliance.block<3, 3>(row(to), row(from)) =
          Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(column.data() +
                                                                         9 * impl_->place(to));
  }
  const Eigen::MatrixXd system = Eigen::MatrixXd::Identity(size, size) + m * compliance;
  const Mat3 k = total * Mat3::Identity() - pull.transpose() * compliance * solved(system, pull);
  return 0.5 * (k + k.transpose());
}

}  // namespace forefeel
