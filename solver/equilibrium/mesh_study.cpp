#include "solver/equilibrium/mesh_study.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>

#include "geometry/common/dense.hpp"
#include "solver/equilibrium/solver.hpp"
#include "solver/system/discretisation.hpp"
#include "solver/system/factorisation.hpp"

namespace forefeel {
namespace {

using Rates = std::array<double, 2>;  // linear, quadratic

std::size_t kind(const MeshStudyRow& row) {
  return row.element == Element::linear ? 0 : 1;
}

double size_of(const MeshStudyRow& row) {
  return std::cbrt(1 / static_cast<double>(row.elements));
}

struct Fit {
  double force = unknown;
  double residual = std::numeric_limits<double>::infinity();  // sum of squares, weighted
};

// f0 and the constants of the kinds that occur, at given rates. Sizes are relative to the coarsest, so that
// the columns are of one magnitude.
Fit fit(const std::vector<MeshStudyRow>& rows, const Rates& rates, const std::array<double, 2>& steps) {
  const bool both = steps[0] > 0 && steps[1] > 0;
  double coarsest = 0;
  for (const MeshStudyRow& row : rows) coarsest = std::max(coarsest, size_of(row));
  Eigen::MatrixXd left(rows.size(), both ? 3 : 2);
  Eigen::VectorXd right(rows.size());
  left.setZero();
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const auto at = static_cast<Eigen::Index>(i);
    const double h = size_of(rows[i]) / coarsest, weight = 1 / (h * steps[kind(rows[i])]);
    left(at, 0) = weight;
    left(at, both ? 1 + static_cast<Eigen::Index>(kind(rows[i])) : 1) =
        weight * std::pow(h, rates[kind(rows[i])]);
    right[at] = weight * rows[i].force;
  }
  const Eigen::VectorXd found = least_squares(left, right);
  return {.force = found[0], .residual = (left * found - right).squaredNorm()};
}

// By how much the two finest meshes of a kind differ [N]: how far it is from its limit. 0 with a single mesh.
double last_step(const std::vector<MeshStudyRow>& rows, std::size_t of) {
  std::vector<MeshStudyRow> same;
  std::ranges::copy_if(rows, std::back_inserter(same), [of](const auto& row) { return kind(row) == of; });
  std::ranges::sort(same, {}, &MeshStudyRow::elements);
  if (same.size() < 2) return 0;
  const double last = same.back().force;
  return std::max(std::abs(last - same[same.size() - 2].force), 1e-9 * std::abs(last));
}

std::vector<MeshStudyRow> without(const std::vector<MeshStudyRow>& rows, std::size_t left_out) {
  std::vector<MeshStudyRow> others = rows;
  others.erase(others.begin() + static_cast<std::ptrdiff_t>(left_out));
  return others;
}

std::vector<MeshStudyRow> only(const std::vector<MeshStudyRow>& rows, std::size_t of) {
  std::vector<MeshStudyRow> same;
  std::ranges::copy_if(rows, std::back_inserter(same), [of](const auto& row) { return kind(row) == of; });
  return same;
}

double uncertainty_of(const std::vector<MeshStudyRow>& rows, const Rates& rates, double force) {
  double largest = 0;
  const auto compare_with = [&](const std::vector<MeshStudyRow>& others, const Rates& at) {
    const std::array steps{last_step(others, 0), last_step(others, 1)};
    largest = std::max(largest, std::abs(fit(others, at, steps).force - force));
  };
  for (const std::size_t k : {0u, 1u}) {
    const std::size_t count = only(rows, k).size();
    if (count == 0) continue;
    if (count < rows.size()) compare_with(only(rows, k), rates);
    for (const double factor : {0.75, 1.25}) {
      Rates other = rates;
      other[k] *= factor;
      compare_with(rows, other);
    }
    for (std::size_t i = 0; i < rows.size() && count > 2; ++i)
      if (kind(rows[i]) == k) compare_with(without(rows, i), rates);
  }
  return largest / std::abs(force);
}

std::vector<double> tried_rates(std::size_t kind, std::size_t meshes) {
  if (meshes < 3) return {kind == 0 ? 1.2 : 1.5};
  std::vector<double> rates;
  for (double p = 0.8; p <= (kind == 0 ? 2.2 : 4.2); p += 0.05) rates.push_back(p);
  return rates;
}

}  // namespace

MeshStudyRow study_row(const std::shared_ptr<const Body>& body, const Vec3& x) {
  SolverBasis basis(body);
  const std::shared_ptr<const Discretisation> d = basis.discretisation();
  MeshStudyRow row{.elements = body->mesh.tets.size(),
                   .element = body->element,
                   .nodes = d->nodes,
                   .work = cost_of_factor(*d).flops};
  const State rest = Solver(basis).reference(Vec3::Zero(), 1).state;
  row.seconds = rest.solve.seconds;
  if (rest.usable()) row.force = (rest.stiffness * x).norm();
  return row;
}

MeshLimit extrapolated(std::span<const MeshStudyRow> rows) {
  std::array<std::size_t, 2> counts{};
  for (const MeshStudyRow& row : rows)
    if (std::isfinite(row.force) && !row.remeshed) ++counts[kind(row)];
  for (std::size_t& count : counts) count = count > 1 ? count : 0;
  std::vector<MeshStudyRow> used;
  for (const MeshStudyRow& row : rows)
    if (std::isfinite(row.force) && !row.remeshed && counts[kind(row)] > 0) used.push_back(row);
  MeshLimit limit;
  if (used.empty()) return limit;
  const std::array steps{last_step(used, 0), last_step(used, 1)};
  Fit best;
  Rates at{};
  for (const double p : tried_rates(0, counts[0]))
    for (const double q : tried_rates(1, counts[1])) {
      const Fit found = fit(used, {p, q}, steps);
      if (!(found.residual < best.residual)) continue;
      best = found;
      at = {p, q};
      limit.rate[0] = counts[0] > 2 ? p : unknown;
      limit.rate[1] = counts[1] > 2 ? q : unknown;
    }
  limit.force = best.force;
  double nearest = std::numeric_limits<double>::infinity();
  for (const MeshStudyRow& row : used) nearest = std::min(nearest, std::abs(row.force - limit.force));
  limit.beyond = nearest / std::abs(limit.force);
  limit.uncertainty = uncertainty_of(used, at, limit.force);
  return limit;
}

void compare(std::vector<MeshStudyRow>& rows, const MeshLimit& limit) {
  for (MeshStudyRow& row : rows) row.error = std::abs(row.force - limit.force) / std::abs(limit.force);
}

namespace {

bool stays_below(std::span<const MeshStudyRow> rows, std::size_t i, double error) {
  return std::ranges::none_of(rows, [&](const MeshStudyRow& finer) {
    return kind(finer) == kind(rows[i]) && finer.elements > rows[i].elements && finer.error > error;
  });
}

}  // namespace

std::optional<std::size_t> cheapest(std::span<const MeshStudyRow> rows, double error) {
  std::optional<std::size_t> best;
  for (std::size_t i = 0; i < rows.size(); ++i)
    if (rows[i].error <= error && (!best || rows[i].work < rows[*best].work) && stays_below(rows, i, error))
      best = i;
  return best;
}

}  // namespace forefeel
