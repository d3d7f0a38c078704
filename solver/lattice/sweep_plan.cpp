#include "solver/lattice/sweep_plan.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "geometry/coverage/state_space.hpp"
#include "solver/body/law.hpp"

namespace forefeel {
namespace {

// The corners of the cell, face or edge that a fine position lies on. Nothing if it lies outside of the box.
using CellAround = std::array<std::pair<int, int>, 3>;
std::optional<CellAround> cell_around(const CoarsePlanes& planes, const Vec3& q) {
  CellAround cell;
  for (unsigned axis = 0; axis < 3; ++axis) {
    const auto found = planes.around(axis, q[axis]);
    if (!found) return std::nullopt;
    cell[axis] = *found;
  }
  return cell;
}

std::vector<LatticeIndex> sorted_once(std::vector<LatticeIndex> some) {
  std::ranges::sort(some);
  some.erase(std::unique(some.begin(), some.end()), some.end());
  return some;
}

std::vector<LatticeIndex> corners_of(const CellAround& cell) {
  std::vector<LatticeIndex> corners;
  for (unsigned i = 0; i < 8; ++i)
    corners.push_back({(i & 1) != 0 ? cell[0].second : cell[0].first,
                       (i & 2) != 0 ? cell[1].second : cell[1].first,
                       (i & 4) != 0 ? cell[2].second : cell[2].first});
  return sorted_once(std::move(corners));
}

std::vector<LatticeIndex> corners_of(const CoarsePlanes& planes, const LatticeIndex& k) {
  const auto cell = cell_around(planes, Vec3(k[0], k[1], k[2]));
  return cell ? corners_of(*cell) : std::vector<LatticeIndex>{};
}

// The coarse cell that a fine index lies in, named by the numbers of its lower planes.
LatticeIndex name_of(const CoarsePlanes& planes, const LatticeIndex& k) {
  LatticeIndex cell{};
  for (std::size_t axis = 0; axis < 3; ++axis)
    cell[axis] =
        static_cast<int>(std::ranges::upper_bound(planes.at[axis], k[axis]) - planes.at[axis].begin());
  return cell;
}

// Fine positions that are solved together, and the coarse cells that hold them.
struct CellGroup {
  std::vector<LatticeIndex> cells, fine;
};

// Positions further apart than this [h] along an axis are seldom solved with one factor.
constexpr int widest_group = 3;

int width_of(const std::vector<LatticeIndex>& some, const std::vector<LatticeIndex>& others) {
  int widest = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    int low = some.front()[axis], high = low;
    for (const auto* list : {&some, &others})
      for (const LatticeIndex& k : *list) {
        low = std::min(low, k[axis]);
        high = std::max(high, k[axis]);
      }
    widest = std::max(widest, high - low);
  }
  return widest;
}

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
            if (width_of(groups[at->second].fine, groups[g].fine) > widest_group) continue;
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
std::optional<LatticeIndex> beyond(const CoarsePlanes& planes, const LatticeIndex& coarse,
                                   const LatticeIndex& parent) {
  LatticeIndex b = parent;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (parent[axis] == coarse[axis]) continue;
    const auto next = planes.next(axis, parent[axis], parent[axis] > coarse[axis] ? 1 : -1);
    if (!next) return std::nullopt;
    b[axis] = *next;
  }
  return b;
}

}  // namespace

LatticeIndex fine_index(const Vec3& x, double spacing) {
  LatticeIndex k{};
  for (unsigned i = 0; i < 3; ++i) k[i] = static_cast<int>(std::lround(x[i] / spacing));
  return k;
}

Vec3 position_of(const LatticeIndex& k, double spacing) {
  return spacing * Vec3(k[0], k[1], k[2]);
}

int level(const LatticeIndex& k) {
  return std::abs(k[0]) + std::abs(k[1]) + std::abs(k[2]);
}

std::vector<LatticeIndex> towards_rest(const CoarsePlanes& planes, const LatticeIndex& coarse) {
  std::array<std::size_t, 3> axes{0, 1, 2};
  std::stable_sort(axes.begin(), axes.end(),
                   [&](std::size_t a, std::size_t b) { return std::abs(coarse[a]) > std::abs(coarse[b]); });
  std::vector<LatticeIndex> parents;
  for (const std::size_t axis : axes) {
    if (coarse[axis] == 0) continue;
    LatticeIndex p = coarse;
    const auto next = planes.next(axis, coarse[axis], coarse[axis] > 0 ? -1 : 1);
    if (!next) continue;
    p[axis] = *next;
    parents.push_back(p);
  }
  return parents;
}

SweepPlan::SweepPlan(const LatticeOptions& options, const std::vector<State>& known)
    : planes_(coarse_planes(options.box, options.spacing)) {
  std::set<LatticeIndex> there;
  for (const State& state : known) {
    const LatticeIndex k = fine_index(state.at, options.spacing);
    if ((state.at - position_of(k, options.spacing)).norm() < 1e-6 * options.spacing) there.insert(k);
  }
  const std::vector<Vec3> outward = lattice(options.box, options.spacing);
  positions_ = outward.size();
  for (const Vec3& x : outward) {
    const LatticeIndex k = fine_index(x, options.spacing);
    if (!there.contains(k)) missing_.push_back(k);
  }
  wanted_ = sorted_once(missing_);
  plan_groups(outward, options.spacing);
  plan_coarse();
}

void SweepPlan::plan_coarse() {
  std::set<LatticeIndex> needed;
  std::vector<LatticeIndex> open;
  const auto need = [&](const LatticeIndex& c) {
    if (needed.insert(c).second) open.push_back(c);
  };
  for (const LatticeIndex& k : missing_)
    if (planes_.holds(k)) need(k);
  for (const auto& group : groups_)
    for (const LatticeIndex& corner : corners_of(planes_, group)) need(corner);
  while (!open.empty()) {
    const LatticeIndex c = open.back();
    open.pop_back();
    for (const LatticeIndex& p : towards_rest(planes_, c)) need(p);
  }
  coarse_.assign(needed.begin(), needed.end());
}

void SweepPlan::plan_groups(const std::vector<Vec3>& outward, double spacing) {
  std::vector<CellGroup> cells;
  std::map<LatticeIndex, std::size_t> group_of;
  for (const Vec3& x : outward) {
    const LatticeIndex k = fine_index(x, spacing);
    if (planes_.holds(k)) continue;
    const auto [at, added] = group_of.emplace(name_of(planes_, k), cells.size());
    if (added) cells.push_back({{at->first}, {}});
    cells[at->second].fine.push_back(k);
  }
  join_small(cells, group_of);
  for (CellGroup& group : cells)
    if (std::ranges::any_of(group.fine, [&](const LatticeIndex& k) { return is_wanted(k); }))
      groups_.push_back(std::move(group.fine));
}

std::vector<LatticeIndex> corners_of(const CoarsePlanes& planes, std::span<const LatticeIndex> fine) {
  std::vector<LatticeIndex> corners;
  for (const LatticeIndex& k : fine)
    for (const LatticeIndex& c : corners_of(planes, k)) corners.push_back(c);
  return sorted_once(std::move(corners));
}

std::vector<SweepPiece> pieces_of(const SweepPlan& plan) {
  std::vector<SweepPiece> pieces;
  std::map<LatticeIndex, std::size_t> number;
  const auto add = [&](bool is_coarse, std::vector<LatticeIndex> states,
                       std::span<const LatticeIndex> needed) {
    SweepPiece piece{.is_coarse = is_coarse, .states = std::move(states)};
    for (const LatticeIndex& c : needed)
      if (const auto at = number.find(c); at != number.end()) {
        pieces[at->second].before.push_back(pieces.size());
        ++piece.waits_for;
      }
    pieces.push_back(std::move(piece));
  };
  std::vector<LatticeIndex> outward = plan.coarse();
  std::ranges::stable_sort(outward, {}, level);
  for (const LatticeIndex& c : outward) {
    add(true, {c}, towards_rest(plan.planes(), c));
    number[c] = pieces.size() - 1;
  }
  for (const std::vector<LatticeIndex>& group : plan.groups())
    add(false, group, corners_of(plan.planes(), group));
  return pieces;
}

SweepOptions sweep_options(const Body& body, const LatticeOptions& options, const std::stop_token& stop,
                           SolvedNodes solved) {
  const bool soft = std::ranges::any_of(materials(body), [](const Material& material) {
    return law_entry(material.law).softens || material.poisson >= 0.49;
  });
  return {.spacing = options.spacing,
          .planes = coarse_planes(options.box, options.spacing),
          .residual_tolerance = (soft ? 5 : 20) * options.tolerance,
          .stop = stop,
          .coarse = std::move(solved)};
}

SweepNode solve_coarse_node(SweepWorker& worker, const LatticeIndex& coarse) {
  const SweepOptions& options = worker.options();
  SweepNode node;
  node.index = coarse;
  node.state.at = position_of(coarse, options.spacing);
  std::vector<const SweepNode*> parents;
  const SweepNode* opposite = nullptr;
  for (const LatticeIndex& p : towards_rest(options.planes, coarse))
    if (const SweepNode* parent = options.coarse(p)) {
      const auto b = beyond(options.planes, coarse, p);
      if (parents.empty() && b && level(*b) < level(p)) opposite = options.coarse(*b);
      parents.push_back(parent);
    }
  worker.solve_coarse(node, parents, opposite);
  return node;
}

SweepCell cell_of(const SweepOptions& options, std::span<const LatticeIndex> fine) {
  SweepCell cell;
  for (const LatticeIndex& k : fine) {
    SweepNode node;
    node.index = k;
    node.state.at = position_of(k, options.spacing);
    cell.corners.emplace_back();
    for (const LatticeIndex& c : corners_of(options.planes, k))
      if (const SweepNode* corner = options.coarse(c)) cell.corners.back().push_back(corner);
    std::stable_sort(
        cell.corners.back().begin(), cell.corners.back().end(),
        [](const SweepNode* a, const SweepNode* b) { return level(a->index) < level(b->index); });
    cell.nodes.push_back(std::move(node));
  }
  return cell;
}

std::vector<SweepNode> solve_fine_nodes(SweepWorker& worker, std::span<const LatticeIndex> fine) {
  SweepCell cell = cell_of(worker.options(), fine);
  worker.solve_together(cell);
  for (std::size_t place = 0; place < cell.open.size(); ++place) worker.correct(cell, place);
  worker.find_paths(cell);
  for (std::size_t place = 0; place < cell.open.size(); ++place) worker.follow_path(cell, place);
  return std::move(cell.nodes);
}

std::vector<LatticeIndex> nodes_looked_at(const CoarsePlanes& planes, std::span<const LatticeIndex> fine) {
  std::set<LatticeIndex> nodes;
  const auto look = [&](const Vec3& q) {
    const auto cell = cell_around(planes, q);
    if (!cell) return;
    for (const LatticeIndex& c : corners_of(*cell)) nodes.insert(c);
  };
  for (const LatticeIndex& k : fine) {
    const Vec3 q(k[0], k[1], k[2]);
    look(q);
    if (planes.holds(k)) {
      for (const LatticeIndex& p : inner_corners(planes, k)) nodes.insert(p);
      for (const LatticeIndex& p : towards_rest(planes, k))
        if (const auto b = beyond(planes, k, p)) nodes.insert(*b);
    }
    // the corners around every point of the straight path from rest in steps of at most h (sweep_rays.cpp)
    const int steps = std::max(1, static_cast<int>(std::ceil(q.norm())));
    for (const int parts : {steps, std::max(1, steps - 1)})  // rounding decides between the two
      for (int step = 1; step < parts; ++step) look(q * step / parts);
  }
  for (const LatticeIndex& k : fine)
    if (planes.holds(k)) nodes.erase(k);
  return {nodes.begin(), nodes.end()};
}

}  // namespace forefeel
