// Shapes of the surface over the time of a run: those that it recorded, or else fitted to the displacements of its
// states.

#include <algorithm>
#include <cmath>
#include <utility>

#include "apps/show/gather_run.hpp"
#include "geometry/common/dense.hpp"
#include "geometry/common/error.hpp"
#include "geometry/mesh/vtu_series.hpp"

namespace forefeel {
namespace {

constexpr std::size_t most_shapes = 240, most_values = 1'500'000;  // of all shapes
constexpr std::size_t neighbours = 12;

struct Known {
  double from = 0;  // [s]
  Vec3 at = Vec3::Zero();
  std::shared_ptr<const std::vector<double>> moved;  // null: rest
};

std::vector<Known> known_shapes(const RunFolder& run, std::size_t mesh_nodes) {
  std::vector<Known> known;
  for (const ShownState& s : run.states)
    if (s.state.displacements && s.state.displacements->size() == 3 * mesh_nodes)
      known.push_back({std::isnan(s.known) ? 0 : s.known, s.state.at, s.state.displacements});
  if (!known.empty()) known.emplace_back();
  std::ranges::stable_sort(known, {}, &Known::from);
  return known;
}

// Weights a with sum a = 1 and, where the places span space, sum a_i x_i = x: those of a linear fit in which a
// place at distance d counts with 1 / d^4. If the fit extrapolates far, the weights are those of the mean.
Eigen::VectorXd weights_at(const Vec3& x, const std::vector<const Known*>& near) {
  const auto n = static_cast<Eigen::Index>(near.size());
  double least = 1e-12;
  for (const Known* k : near) least = std::max(least, 1e-6 * (k->at - x).norm());
  Eigen::VectorXd root(n);
  Eigen::MatrixXd rows(n, 4);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Vec3 from = near[static_cast<std::size_t>(i)]->at - x;
    root[i] = 1 / std::pow(std::max(from.norm(), least), 2);
    rows.row(i) << 1, from.transpose() / least * 1e-6;
  }
  root /= root.maxCoeff();
  const Eigen::MatrixXd weighted = root.asDiagonal() * rows;
  Eigen::VectorXd weights = smallest_least_squares(weighted.transpose(), Eigen::Vector4d(1, 0, 0, 0));
  weights = root.asDiagonal() * weights;
  if (std::abs(weights.sum() - 1) > 1e-6 || weights.cwiseAbs().sum() > 4)
    weights = root.cwiseAbs2() / root.squaredNorm();
  return weights;
}

// How many shapes of a body are shown.
std::size_t shown_of(std::size_t shapes, const ShownBody& body) {
  return std::min(
      {most_shapes, most_values / (3 * body.nodes.size() + 1) + 2, std::max<std::size_t>(shapes, 2)});
}

ShownShape recorded_shape(const std::filesystem::path& file, double t, const ShownBody& body) {
  const MovedNodes read = read_moved_nodes(file);
  ShownShape shape{.t = t, .moved = std::vector<Vec3>(body.nodes.size(), Vec3::Zero())};
  std::size_t found = 0;
  for (std::size_t i = 0; i < read.node.size(); ++i) {  // both rise
    const auto place = std::ranges::lower_bound(body.node, read.node[i]);
    if (place == body.node.end() || *place != read.node[i]) continue;
    shape.moved[static_cast<std::size_t>(place - body.node.begin())] = read.moved[i];
    ++found;
  }
  if (found < body.nodes.size())
    throw InputError({.file = file.string()},
                     "lacks nodes of the body's surface, expected shapes of this body");
  return shape;
}

// What scheduling/record/shape_files.hpp wrote; empty if the run has no shapes.
std::vector<ShownShape> recorded_shapes(const RunFolder& run, const ShownBody& body) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(run.folder / "shape.pvd", error)) return {};
  const std::vector<SeriesFile> series = read_pvd(run.folder / "shape.pvd");
  std::vector<ShownShape> shapes;
  const std::size_t count = series.empty() ? 0 : shown_of(series.size(), body);
  std::size_t last = series.size();
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t which = k * (series.size() - 1) / (count - 1);
    if (which == last) continue;
    last = which;
    shapes.push_back(recorded_shape(run.folder / series[which].file, series[which].t, body));
  }
  return shapes;
}

}  // namespace

std::vector<ShownShape> shapes_of_run(const RunFolder& run, const ShownBody& body) {
  if (std::vector<ShownShape> recorded = recorded_shapes(run, body); !recorded.empty()) return recorded;
  const std::vector<Known> known = known_shapes(run, body.mesh.nodes.size());
  if (known.empty() || run.run.path.empty()) return {};
  const std::size_t count = shown_of(run.run.path.size(), body);
  std::vector<ShownShape> shapes;
  for (std::size_t k = 0; k < count; ++k) {
    const ShownFrame& frame = run.run.path[k * (run.run.path.size() - 1) / (count - 1)];
    std::vector<const Known*> near;
    for (const Known& one : known)
      if (one.from <= frame.t) near.push_back(&one);
    const std::size_t few = std::min(neighbours, near.size());
    std::ranges::partial_sort(near, near.begin() + static_cast<std::ptrdiff_t>(few), {},
                              [&](const Known* one) { return (one->at - frame.at).squaredNorm(); });
    near.resize(few);
    const Eigen::VectorXd weights = weights_at(frame.at, near);
    ShownShape shape{.t = frame.t, .moved = std::vector<Vec3>(body.nodes.size(), Vec3::Zero())};
    for (std::size_t i = 0; i < near.size(); ++i) {
      if (!near[i]->moved) continue;
      for (std::size_t v = 0; v < body.node.size(); ++v)
        shape.moved[v] += weights[static_cast<Eigen::Index>(i)] *
                          Eigen::Map<const Vec3>(near[i]->moved->data() + 3 * body.node[v]);
    }
    shapes.push_back(std::move(shape));
  }
  return shapes;
}

}  // namespace forefeel
