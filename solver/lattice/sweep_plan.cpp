#include "solver/lattice/sweep_plan.hpp"

#include <algorithm>
#include <cmath>

#include "geometry/state_space/state_space.hpp"
#include "solver/body/law.hpp"

namespace forefeel {
namespace {

bool is_coarse(const LatticeIndex& k) {
  return k[0] % 2 == 0 && k[1] % 2 == 0 && k[2] % 2 == 0;
}

LatticeIndex twice(const LatticeIndex& k) {
  return {2 * k[0], 2 * k[1], 2 * k[2]};
}

// The coarse cell that a fine index lies in, named by its lowest corner.
LatticeIndex cell_of(const LatticeIndex& k) {
  LatticeIndex cell{};
  for (std::size_t axis = 0; axis < 3; ++axis) cell[axis] = static_cast<int>(std::floor(0.5 * k[axis]));
  return cell;
}

// All indices between two corners, both included.
std::vector<LatticeIndex> between(const LatticeIndex& low, const LatticeIndex& high) {
  std::vector<LatticeIndex> all;
  for (int i = low[0]; i <= high[0]; ++i)
    for (int j = low[1]; j <= high[1]; ++j)
      for (int k = low[2]; k <= high[2]; ++k) all.push_back({i, j, k});
  return all;
}

// Coarse corners around a fine index.
std::vector<LatticeIndex> corners_of(const LatticeIndex& k) {
  LatticeIndex low = cell_of(k), high = low;
  for (std::size_t axis = 0; axis < 3; ++axis) high[axis] += k[axis] % 2 != 0 ? 1 : 0;
  return between(low, high);
}

// Fine positions that are solved together, and the coarse cells that hold them.
struct CellGroup {
  std::vector<LatticeIndex> cells, fine;
};

// Joins neighbouring groups while they fill at most half of the lanes each.
void join_small(std::vector<CellGroup>& groups, std::map<LatticeIndex, std::size_t>& group_of) {
  constexpr int passes = 3;
  for (int pass = 0; pass < passes; ++pass)
    for (std::size_t g = 0; g < groups.size(); ++g) {
      if (groups[g].fine.empty() || 2 * groups[g].fine.size() > lane_count) continue;
      std::size_t best = g, most = 0;
      for (const LatticeIndex& cell : groups[g].cells)
        for (std::size_t axis = 0; axis < 3; ++axis)
          for (const int side : {-1, 1}) {
            LatticeIndex next = cell;
            next[axis] += side;
            const auto at = group_of.find(next);
            if (at == group_of.end() || at->second == g) continue;
            const std::size_t size = groups[at->second].fine.size();
            if (size > most && size + groups[g].fine.size() <= lane_count) best = at->second, most = size;
          }
      if (best == g) continue;
      for (const LatticeIndex& cell : groups[g].cells) group_of[cell] = best;
      groups[best].cells.insert(groups[best].cells.end(), groups[g].cells.begin(), groups[g].cells.end());
      groups[best].fine.insert(groups[best].fine.end(), groups[g].fine.begin(), groups[g].fine.end());
      groups[g] = {};
    }
}

// The node opposite to `coarse` across its parent.
LatticeIndex beyond(const LatticeIndex& coarse, const LatticeIndex& parent) {
  LatticeIndex b = parent;
  for (std::size_t axis = 0; axis < 3; ++axis) b[axis] += parent[axis] - coarse[axis];
  return b;
}

}  // namespace

LatticeIndex fine_index(const Vec3& x, double spacing) {
  LatticeIndex k{};
  for (std::size_t i = 0; i < 3; ++i)
    k[i] = static_cast<int>(std::lround(x[static_cast<Eigen::Index>(i)] / spacing));
  return k;
}

Vec3 position_of(const LatticeIndex& k, double spacing) {
  return spacing * Vec3(k[0], k[1], k[2]);
}

int level(const LatticeIndex& k) {
  return std::abs(k[0]) + std::abs(k[1]) + std::abs(k[2]);
}

std::vector<LatticeIndex> towards_rest(const LatticeIndex& k) {
  std::array<std::size_t, 3> axes{0, 1, 2};
  std::stable_sort(axes.begin(), axes.end(),
                   [&](std::size_t a, std::size_t b) { return std::abs(k[a]) > std::abs(k[b]); });
  std::vector<LatticeIndex> parents;
  for (const std::size_t axis : axes) {
    if (k[axis] == 0) continue;
    LatticeIndex p = k;
    p[axis] -= k[axis] > 0 ? 1 : -1;
    parents.push_back(p);
  }
  return parents;
}

SweepPlan::SweepPlan(const GenerateOptions& options, const std::vector<State>& known) {
  std::set<LatticeIndex> there;
  for (const State& state : known) {
    const LatticeIndex k = fine_index(state.at, options.spacing);
    if ((state.at - position_of(k, options.spacing)).norm() < 1e-6 * options.spacing) there.insert(k);
  }
  const std::vector<Vec3> outward = lattice(options.box, options.spacing);
  for (const Vec3& x : outward) {
    const LatticeIndex k = fine_index(x, options.spacing);
    all_.insert(k);
    if (!there.contains(k)) missing_.push_back(k);
  }
  wanted_.insert(missing_.begin(), missing_.end());
  plan_groups(outward, options.spacing);
  plan_coarse();
}

void SweepPlan::plan_coarse() {
  std::set<LatticeIndex> needed;
  std::vector<LatticeIndex> open;
  const auto need = [&](const LatticeIndex& c) {
    if (all_.contains(twice(c)) && needed.insert(c).second) open.push_back(c);
  };
  for (const LatticeIndex& k : missing_)
    if (is_coarse(k)) need(cell_of(k));
  for (const auto& group : groups_)
    for (const LatticeIndex& corner : corners_of(group)) need(corner);
  while (!open.empty()) {
    const LatticeIndex c = open.back();
    open.pop_back();
    for (const LatticeIndex& p : towards_rest(c)) need(p);
  }
  coarse_.assign(needed.begin(), needed.end());
}

void SweepPlan::plan_groups(const std::vector<Vec3>& outward, double spacing) {
  std::vector<CellGroup> cells;
  std::map<LatticeIndex, std::size_t> group_of;
  for (const Vec3& x : outward) {
    const LatticeIndex k = fine_index(x, spacing);
    if (is_coarse(k)) continue;
    const auto [at, added] = group_of.emplace(cell_of(k), cells.size());
    if (added) cells.push_back({{at->first}, {}});
    cells[at->second].fine.push_back(k);
  }
  join_small(cells, group_of);
  for (CellGroup& group : cells)
    if (std::ranges::any_of(group.fine, [&](const LatticeIndex& k) { return wanted_.contains(k); }))
      groups_.push_back(std::move(group.fine));
}

std::vector<LatticeIndex> corners_of(std::span<const LatticeIndex> fine) {
  std::set<LatticeIndex> corners;
  for (const LatticeIndex& k : fine)
    for (const LatticeIndex& c : corners_of(k)) corners.insert(c);
  return {corners.begin(), corners.end()};
}

SweepOptions sweep_options(const Body& body, const GenerateOptions& options, const std::stop_token& stop,
                           SolvedNodes solved) {
  const bool soft = std::ranges::any_of(materials(body), [](const Material& material) {
    return law_entry(material.law).softens || material.poisson >= 0.49;
  });
  return {.spacing = options.spacing,
          .residual_tolerance = (soft ? 5 : 20) * options.tolerance,
          .stop = stop,
          .coarse = std::move(solved)};
}

SweepNode solve_coarse_node(SweepWorker& worker, const LatticeIndex& coarse, double spacing,
                            const SolvedNodes& solved) {
  SweepNode node;
  node.index = coarse;
  node.state.at = position_of(coarse, 2 * spacing);
  std::vector<const SweepNode*> parents;
  const SweepNode* opposite = nullptr;
  for (const LatticeIndex& p : towards_rest(coarse))
    if (const SweepNode* parent = solved(p)) {
      const LatticeIndex b = beyond(coarse, p);
      if (parents.empty() && level(b) < level(p)) opposite = solved(b);
      parents.push_back(parent);
    }
  worker.solve_coarse(node, parents, opposite);
  return node;
}

std::vector<SweepNode> solve_fine_nodes(SweepWorker& worker, std::span<const LatticeIndex> fine,
                                        double spacing, const SolvedNodes& solved) {
  std::vector<SweepNode> nodes;
  std::vector<std::vector<const SweepNode*>> corners;
  for (const LatticeIndex& k : fine) {
    SweepNode node;
    node.index = k;
    node.state.at = position_of(k, spacing);
    corners.emplace_back();
    for (const LatticeIndex& c : corners_of(k))
      if (const SweepNode* corner = solved(c)) corners.back().push_back(corner);
    std::stable_sort(
        corners.back().begin(), corners.back().end(),
        [](const SweepNode* a, const SweepNode* b) { return level(a->index) < level(b->index); });
    nodes.push_back(std::move(node));
  }
  worker.solve_cell(nodes, corners);
  return nodes;
}

State state_of(const SweepNode& node, const Discretisation& d, const Body& body, bool want_displacements) {
  State state = node.state;
  if (!want_displacements || !state.usable()) return state;
  std::vector<double> u = d.to_nodes(node.field.u.data());
  u.resize(3 * body.mesh.nodes.size());
  state.displacements = std::make_shared<const std::vector<double>>(std::move(u));
  return state;
}

std::vector<LatticeIndex> nodes_looked_at(std::span<const LatticeIndex> fine, double spacing) {
  std::vector<LatticeIndex> nodes;
  for (const LatticeIndex& k : fine) {
    for (const LatticeIndex& c : corners_of(k)) {
      LatticeIndex inner = c;  // from which a prediction is extrapolated outward
      for (std::size_t axis = 0; axis < 3; ++axis)
        inner[axis] -= k[axis] % 2 == 0 || c[axis] == 0 ? 0 : c[axis] > 0 ? 1 : -1;
      for (const LatticeIndex& n :
           between({std::min(c[0], inner[0]), std::min(c[1], inner[1]), std::min(c[2], inner[2])},
                   {std::max(c[0], inner[0]), std::max(c[1], inner[1]), std::max(c[2], inner[2])}))
        nodes.push_back(n);
    }
    if (is_coarse(k))
      for (const LatticeIndex& p : towards_rest(cell_of(k))) {
        nodes.push_back(p);
        nodes.push_back(beyond(cell_of(k), p));
      }
    // the corners around every point of the straight path from rest in steps of at most h (sweep_rays.cpp)
    const Vec3 x = position_of(k, spacing);
    const int steps = std::max(1, static_cast<int>(std::ceil(x.norm() / spacing)));
    LatticeIndex last_low{1, 1, 1}, last_high{};             // of no box
    for (const int parts : {steps, std::max(1, steps - 1)})  // rounding decides between the two
      for (int step = 1; step <= steps; ++step) {
        LatticeIndex low{}, high{};
        for (std::size_t axis = 0; axis < 3; ++axis) {
          const double q = 0.5 * k[axis] * std::min(1.0, static_cast<double>(step) / parts);
          low[axis] = static_cast<int>(std::floor(q - 1e-6));
          high[axis] = static_cast<int>(std::ceil(q + 1e-6));
        }
        if (low == last_low && high == last_high) continue;
        last_low = low;
        last_high = high;
        for (const LatticeIndex& c : between(low, high)) nodes.push_back(c);
      }
  }
  std::ranges::sort(nodes);
  nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
  std::erase_if(nodes, [&](const LatticeIndex& c) {
    return std::ranges::any_of(fine, [&](const LatticeIndex& k) { return is_coarse(k) && cell_of(k) == c; });
  });
  return nodes;
}

}  // namespace forefeel
