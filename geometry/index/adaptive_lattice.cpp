#include "geometry/index/adaptive_lattice.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <string>

#include "geometry/common/error.hpp"

namespace forefeel {
namespace {

constexpr int finest = 12;  // levels that a cell number can address

}  // namespace

AdaptiveLattice::AdaptiveLattice(const Box& box, double coarsest) : asked_(box), coarsest_(coarsest) {
  if (!(coarsest > 0)) throw InputError("lattice", "spacing " + std::to_string(coarsest) + ", expected > 0");
  double count = 1;
  for (unsigned axis = 0; axis < 3; ++axis) {
    const auto a = axis;
    const double low = std::floor(box.low[a] / coarsest + 1e-9),
                 high = std::ceil(box.high[a] / coarsest - 1e-9);
    const double steps = std::max(1.0, high - low);
    count *= steps;
    if (!(std::abs(low) < 1e5 && std::abs(high) < 1e5 && count < 1e8))
      throw InputError("lattice", "the box holds more than 1e8 cells, expected a larger spacing");
    low_[axis] = static_cast<std::int32_t>(low);
    roots_[axis] = static_cast<std::int32_t>(steps);
  }
  nodes_.reserve(static_cast<std::size_t>(count));
  for (std::int32_t k = 0; k < roots_[2]; ++k)
    for (std::int32_t j = 0; j < roots_[1]; ++j)
      for (std::int32_t i = 0; i < roots_[0]; ++i)
        nodes_.push_back(
            {.children = -1, .level = 0, .widest = 0, .low = {low_[0] + i, low_[1] + j, low_[2] + k}});
}

double AdaptiveLattice::side_of(const Node& node) const {
  return std::ldexp(coarsest_, -node.level);
}

Box AdaptiveLattice::box_of(const Node& node) const {
  const double side = side_of(node);
  return {side * Vec3(node.low[0], node.low[1], node.low[2]),
          side * Vec3(node.low[0] + 1, node.low[1] + 1, node.low[2] + 1)};
}

AdaptiveLattice::Cell AdaptiveLattice::fine_cell(const Vec3& q) const {
  const double side = std::ldexp(coarsest_, -finest);
  Cell cell;
  for (unsigned axis = 0; axis < 3; ++axis) {
    const double low = std::ldexp(static_cast<double>(low_[axis]), finest);
    const double high = std::ldexp(static_cast<double>(low_[axis] + roots_[axis]), finest) - 1;
    cell[axis] = static_cast<std::int32_t>(std::clamp(std::floor(q[axis] / side), low, high));
  }
  return cell;
}

std::int32_t AdaptiveLattice::leaf_index(const Cell& fine) const {
  const Cell at{(fine[0] >> finest) - low_[0], (fine[1] >> finest) - low_[1], (fine[2] >> finest) - low_[2]};
  std::int32_t index = (at[2] * roots_[1] + at[1]) * roots_[0] + at[0];
  while (nodes_[index].children >= 0) {
    const Node& here = nodes_[index];
    const int shift = finest - here.level - 1;
    index = here.children +
            (((fine[0] >> shift) & 1) | ((fine[1] >> shift) & 1) << 1 | ((fine[2] >> shift) & 1) << 2);
  }
  return index;
}

// Leaves that share a face, edge or corner with the node. In a balanced tree the neighbours of a leaf are at
// most one level finer, so two probes along each side find them all; a coarser one may be visited several
// times.
template <class Visit>
void AdaptiveLattice::for_each_touching(const Node& node, Visit&& visit) const {
  const int shift = finest - node.level;
  const std::int32_t width = 1 << shift;
  Cell base;
  for (std::size_t axis = 0; axis < 3; ++axis) base[axis] = node.low[axis] * width;
  const std::array<std::int32_t, 4> probe{-1, width / 4, width - 1 - width / 4, width};
  for (const std::int32_t dz : probe)
    for (const std::int32_t dy : probe)
      for (const std::int32_t dx : probe) {
        const bool own = dx >= 0 && dx < width && dy >= 0 && dy < width && dz >= 0 && dz < width;
        if (own) continue;
        const Cell at{base[0] + dx, base[1] + dy, base[2] + dz};
        bool inside = true;
        for (std::size_t axis = 0; axis < 3; ++axis) {
          const std::int32_t root = at[axis] >> finest;
          inside = inside && root >= low_[axis] && root < low_[axis] + roots_[axis];
        }
        if (inside) visit(leaf_index(at));
      }
}

void AdaptiveLattice::split(std::int32_t index) {
  const std::int32_t children = nodes_.count();
  nodes_.resize(nodes_.size() + 8);
  Node& parent = nodes_[index];
  parent.children = children;
  for (std::int32_t child = 0; child < 8; ++child)
    nodes_[children + child] = {
        .children = -1,
        .level = parent.level + 1,
        .widest = 0,
        .low = {2 * parent.low[0] + (child & 1), 2 * parent.low[1] + ((child >> 1) & 1),
                2 * parent.low[2] + ((child >> 2) & 1)}};
}

// Splits a leaf, after its coarser neighbours have been split.
void AdaptiveLattice::split_balanced(std::int32_t index, std::size_t& count) {
  const Node node = nodes_[index];
  if (node.children >= 0) return;
  std::vector<std::int32_t> coarser;
  for_each_touching(node, [&](std::int32_t other) {
    if (nodes_[other].level < node.level) coarser.push_back(other);
  });
  for (const std::int32_t other : coarser) split_balanced(other, count);
  split(index);
  ++count;
}

std::size_t AdaptiveLattice::refine(const std::function<double(const LatticeLeaf&)>& target, int max_level) {
  std::size_t count = 0;
  max_level = std::min(max_level, finest - 2);
  // Nodes are appended as they are split, so one pass sees all leaves, new ones included.
  for (std::int32_t i = 0; i < nodes_.count(); ++i) {
    const Node node = nodes_[i];
    if (node.children >= 0 || node.level >= max_level) continue;
    const LatticeLeaf leaf{box_of(node), side_of(node), node.level};
    if (leaf.spacing > target(leaf) * (1 + 1e-9)) split_balanced(i, count);
  }
  if (count > 0) find_widest();
  return count;
}

void AdaptiveLattice::find_widest() {
  for (std::int32_t i = 0; i < nodes_.count(); ++i) {
    if (nodes_[i].children >= 0) continue;
    std::int32_t widest = nodes_[i].level;
    for_each_touching(nodes_[i], [&](std::int32_t other) { widest = std::min(widest, nodes_[other].level); });
    nodes_[i].widest = widest;
  }
}

LatticeLeaf AdaptiveLattice::leaf_at(const Vec3& q) const {
  const Node& node = nodes_[leaf_index(fine_cell(q))];
  return {box_of(node), side_of(node), node.level};
}

double AdaptiveLattice::spacing_at(const Vec3& q) const {
  return std::ldexp(coarsest_, -nodes_[leaf_index(fine_cell(q))].widest);
}

std::optional<double> AdaptiveLattice::spacing_over(const Box& box) const {
  const std::int32_t leaf = leaf_index(fine_cell(box.low));
  // Leaves are cubes: one that holds two opposite corners holds the box.
  if (leaf_index(fine_cell(box.high)) != leaf) return std::nullopt;
  return std::ldexp(coarsest_, -nodes_[leaf].widest);
}

std::vector<LatticeLeaf> AdaptiveLattice::leaves() const {
  std::vector<LatticeLeaf> result;
  for (const Node& node : nodes_)
    if (node.children < 0) result.push_back({box_of(node), side_of(node), node.level});
  return result;
}

std::vector<AdaptiveLattice::Point> AdaptiveLattice::points() const {
  std::map<Cell, double> found;
  for (const Node& node : nodes_) {
    if (node.children >= 0) continue;
    const double side = side_of(node);
    const std::int32_t width = 1 << (finest - node.level);
    for (std::int32_t corner = 0; corner < 8; ++corner) {
      const Cell at{(node.low[0] + (corner & 1)) * width, (node.low[1] + ((corner >> 1) & 1)) * width,
                    (node.low[2] + ((corner >> 2) & 1)) * width};
      const auto [entry, fresh] = found.emplace(at, side);
      if (!fresh) entry->second = std::min(entry->second, side);
    }
  }
  std::vector<Point> result;
  const double unit = std::ldexp(coarsest_, -finest), slack = 1e-9 * coarsest_;
  for (const auto& [cell, spacing] : found) {
    const Vec3 at(cell[0] * unit, cell[1] * unit, cell[2] * unit);
    if ((at.array() >= asked_.low.array() - slack).all() && (at.array() <= asked_.high.array() + slack).all())
      result.push_back({at, spacing});
  }
  std::stable_sort(result.begin(), result.end(),
                   [](const Point& a, const Point& b) { return a.at.squaredNorm() < b.at.squaredNorm(); });
  return result;
}

std::optional<AdaptiveLattice> lattice_of(std::span<const State> states, const Box& box) {
  double least = std::numeric_limits<double>::infinity(), widest = 0;
  std::vector<std::pair<Vec3, double>> marks;
  for (const State& s : states) {
    if (!(s.spacing > 0) || !std::isfinite(s.spacing)) continue;
    least = std::min(least, s.spacing);
    widest = std::max(widest, s.spacing);
    marks.emplace_back(s.at, s.spacing);
  }
  if (marks.empty() || least > widest * (1 - 1e-9)) return std::nullopt;
  AdaptiveLattice lattice(box, widest);
  // A leaf is too wide if a state with a smaller target spacing lies strictly inside it.
  std::ranges::sort(marks, {}, [](const auto& mark) { return mark.first.x(); });
  lattice.refine(
      [&](const LatticeLeaf& leaf) {
        double wanted = leaf.spacing;
        const double slack = 1e-9 * leaf.spacing;
        auto from = std::ranges::upper_bound(marks, leaf.box.low.x() + slack, {},
                                             [](const auto& mark) { return mark.first.x(); });
        for (; from != marks.end() && from->first.x() < leaf.box.high.x() - slack; ++from)
          if ((from->first.array() > leaf.box.low.array() + slack).all() &&
              (from->first.array() < leaf.box.high.array() - slack).all())
            wanted = std::min(wanted, from->second);
        return wanted;
      },
      10);
  return lattice;
}

}  // namespace forefeel
