#include "solver/system/factor_layout.hpp"

#include <algorithm>
#include <functional>
#include <utility>

namespace forefeel {
namespace {

// A supernode before layout: nodes first .. first + pivots - 1, which share the later nodes in `rest`.
struct Supernode {
  std::uint32_t first = 0, pivots = 0;
  std::vector<std::uint32_t> rest;  // sorted; the contact, numbered n, is last where present
};

// Cost of a front besides its flops: bookkeeping, and adding its update matrix to the parent.
double front_cost(const Supernode& s) {
  const double rest = static_cast<double>(s.rest.size());
  return 10000 + 150 * rest * rest + elimination_flops(s.pivots, rest);
}

std::vector<Supernode> supernodes(const BlockPattern& pattern, std::int64_t free_nodes) {
  const auto n = static_cast<std::size_t>(free_nodes);
  std::vector<std::vector<std::uint32_t>> column(n), children(n);
  std::vector<std::size_t> mark(n + 1, n + 1);
  std::vector<Supernode> result;
  for (std::uint32_t j = 0; j < n; ++j) {
    const auto take = [&](std::uint32_t i) {
      if (i <= j || mark[i] == j) return;
      mark[i] = j;
      column[j].push_back(i);
    };
    for (const std::uint32_t i : pattern.row(j)) take(i);
    for (const std::uint32_t child : children[j])
      for (const std::uint32_t i : column[child]) take(i);
    std::sort(column[j].begin(), column[j].end());
    if (!column[j].empty() && column[j][0] < n) children[column[j][0]].push_back(j);
    Supernode fresh{j, 1, column[j]};
    // Joins a supernode with the one before it while that is a child and the joint front is cheaper.
    while (!result.empty()) {
      const Supernode& last = result.back();
      const bool child =
          !last.rest.empty() && last.rest[0] >= fresh.first && last.rest[0] < fresh.first + fresh.pivots;
      if (!child) break;
      Supernode joint{last.first, last.pivots + fresh.pivots, fresh.rest};
      const bool same = last.rest.size() == fresh.rest.size() + fresh.pivots;
      if (!same && front_cost(joint) > front_cost(last) + front_cost(fresh)) break;
      result.pop_back();
      fresh = std::move(joint);
    }
    result.push_back(std::move(fresh));
    for (const std::uint32_t child : children[j]) std::vector<std::uint32_t>().swap(column[child]);
  }
  return result;
}

std::int64_t padded(std::int64_t count, std::int64_t multiple) {
  return (count + multiple - 1) / multiple * multiple;
}

constexpr double least_shared_flops = 1e8;  // some milliseconds
constexpr double largest_part = 1.0 / 24;   // of the flops

}  // namespace

double elimination_flops(double pivots, double rest) {
  const double k = 3 * pivots, m = 3 * (pivots + rest);
  return k * m * m - k * k * m + k * k * k / 3;
}

FactorLayout::FactorLayout(const BlockPattern& pattern, std::int64_t free_nodes, std::int64_t padding)
    : row_start(pattern.row_start) {
  size.free_nodes = free_nodes;
  size.padding = padding;
  place_fronts(pattern);
  place_blocks(pattern);
  cut();
}

FrontTree FactorLayout::tree() const {
  return {.free_nodes = size.free_nodes,
          .fronts = fronts.data(),
          .rows = rows.data(),
          .children = children.data(),
          .runs = runs.data(),
          .row_start = row_start.data(),
          .place = place.data()};
}

FrontTree FactorLayout::tree_of_top() const {
  FrontTree top_of = tree();
  top_of.fronts = fronts_of_top.data();
  return top_of;
}

// Position of a node within a front: pivots first, then the rest.
std::int32_t FactorLayout::position(const Front& f, std::int32_t node) const {
  if (node < f.first + f.pivots) return node - f.first;
  const auto begin = rows.begin() + f.rows, end = begin + f.rest;
  return f.pivots + static_cast<std::int32_t>(std::lower_bound(begin, end, node) - begin);
}

void FactorLayout::place_fronts(const BlockPattern& pattern) {
  const std::vector<Supernode> supernode = supernodes(pattern, size.free_nodes);
  std::vector<std::int32_t> owner;  // of the nodes in elimination order
  for (std::size_t s = 0; s < supernode.size(); ++s)
    owner.insert(owner.end(), supernode[s].pivots, static_cast<std::int32_t>(s));
  for (const Supernode& s : supernode) {
    Front f;
    f.first = static_cast<std::int32_t>(s.first);
    f.pivots = static_cast<std::int32_t>(s.pivots);
    f.rest = static_cast<std::int32_t>(s.rest.size());
    f.rows = static_cast<std::int64_t>(rows.size());
    rows.insert(rows.end(), s.rest.begin(), s.rest.end());
    if (!s.rest.empty() && s.rest[0] < owner.size()) f.parent = owner[s.rest[0]];
    f.ld = padded(3 * (f.pivots + f.rest), size.padding);
    f.panel = size.panel;
    size.panel += 3 * f.pivots * f.ld;
    f.update_ld = padded(3 * f.rest, size.padding);
    size.flops += elimination_flops(f.pivots, f.rest);
    fronts.push_back(f);
  }
  std::vector<std::vector<std::int32_t>> of(fronts.size());
  for (std::size_t s = 0; s < fronts.size(); ++s)
    if (fronts[s].parent >= 0) (of.begin() + fronts[s].parent)->push_back(static_cast<std::int32_t>(s));
  for (std::size_t s = 0; s < fronts.size(); ++s) {
    fronts[s].children = {static_cast<std::int64_t>(children.size()),
                          static_cast<std::int64_t>(of[s].size())};
    children.insert(children.end(), of[s].begin(), of[s].end());
  }
  for (Front& f : fronts) {
    f.runs.first = static_cast<std::int64_t>(runs.size());
    if (f.parent < 0) continue;
    const Front& parent = at(f.parent);
    const std::int32_t* const rest = rows.data() + f.rows;
    for (std::int32_t i = 0; i < f.rest; ++i) {
      const std::int32_t to = position(parent, rest[i]);
      const bool goes_on = f.runs.count > 0 && runs.back().to + runs.back().length == to;
      if (goes_on)
        ++runs.back().length;
      else
        runs.push_back({i, to, 1}), ++f.runs.count;
    }
  }
}

void FactorLayout::place_blocks(const BlockPattern& pattern) {
  place.reserve(pattern.column.size());
  std::uint32_t i = 0;
  for (const Front& f : fronts)
    for (std::int32_t pivot = 0; pivot < f.pivots; ++pivot, ++i)
      for (const std::uint32_t j : pattern.row(i)) place.push_back(position(f, static_cast<std::int32_t>(j)));
  place.resize(pattern.column.size());  // and the diagonal of the contact, which no front holds
}

// Two stacks, for fronts of even and odd depth: a front's update matrix is made on one stack while those of its
// children are on top of the other, so that nothing has to be moved. `of`: in elimination order; those of their
// children that are not among them lie elsewhere. What no front of `of` adds up stays at the end.
std::int64_t FactorLayout::place_stacks(const std::vector<std::int64_t>& of, std::int64_t base) {
  std::vector<char> odd(of.size(), 0);
  const auto place_of = [&](std::int64_t front) {
    const auto found = std::ranges::lower_bound(of, front);
    return found == of.end() || *found != front ? of.size() : static_cast<std::size_t>(found - of.begin());
  };
  for (std::size_t i = of.size(); i-- > 0;)
    if (const std::size_t above = place_of(at(of[i]).parent); above < of.size()) odd[i] = odd[above] == 0;
  std::int64_t next[2] = {base, base}, end[2] = {base, base};
  for (std::size_t i = 0; i < of.size(); ++i) {
    Front& f = *(fronts.begin() + of[i]);
    const std::size_t mine = odd[i] != 0 ? 1 : 0;
    f.update = next[mine];
    next[mine] = f.update + 3 * f.rest * f.update_ld;
    end[mine] = std::max(end[mine], next[mine]);
    for (std::int64_t c = 0; c < f.children.count; ++c) {
      const std::int64_t child = *(children.begin() + f.children.first + c);
      if (place_of(child) == of.size()) continue;
      next[1 - mine] = at(child).update;
      break;
    }
  }
  for (std::size_t i = 0; i < of.size(); ++i)
    if (odd[i] != 0) (fronts.begin() + of[i])->update += end[0] - base;
  return end[0] + end[1] - 2 * base;
}

// Rows of the part's fronts that lie above its root move to its tail.
void FactorLayout::place_tail(Subtree& part) {
  const Front its_root = root(part);
  const std::int32_t first_above = its_root.first + its_root.pivots;
  part.nodes = {static_cast<std::int64_t>(met.size()), its_root.rest};
  part.tail = size.free_nodes + 1 + size.tails;
  const std::vector<std::int32_t> nodes(rows.begin() + its_root.rows,
                                        rows.begin() + its_root.rows + its_root.rest);
  met.insert(met.end(), nodes.begin(), nodes.end());
  size.tails += its_root.rest;
  for (std::int64_t s = part.fronts.first; s < part.fronts.first + part.fronts.count; ++s)
    for (std::int64_t i = 0; i < at(s).rest; ++i) {
      std::int32_t& row = *(rows.begin() + at(s).rows + i);
      if (row >= first_above)
        row = static_cast<std::int32_t>(part.tail + (std::ranges::lower_bound(nodes, row) - nodes.begin()));
    }
}

void FactorLayout::cut() {
  const auto count = static_cast<std::int64_t>(fronts.size());
  std::vector<double> below(fronts.size());
  std::vector<std::int64_t> first(fronts.size());  // of the subtree
  for (std::int64_t s = 0; s < count; ++s) {
    const auto i = static_cast<std::size_t>(s);
    below[i] = elimination_flops(at(s).pivots, at(s).rest);
    first[i] = s;
    for (std::int64_t c = 0; c < at(s).children.count; ++c) {
      const auto child = static_cast<std::size_t>(*(children.begin() + at(s).children.first + c));
      below[i] += below[child];
      first[i] = std::min(first[i], first[child]);
    }
  }
  const bool shared = size.flops >= least_shared_flops;
  const auto in_top = [&](std::int64_t s) {
    return s < 0 || below[static_cast<std::size_t>(s)] > largest_part * size.flops;
  };
  if (!shared) parts.push_back({.fronts = {0, count}, .nodes = {}, .flops = size.flops});
  for (std::int64_t s = 0; shared && s < count; ++s) {
    const auto i = static_cast<std::size_t>(s);
    if (in_top(s))
      top.push_back(s);
    else if (in_top(at(s).parent))
      parts.push_back({.fronts = {first[i], s - first[i] + 1}, .nodes = {}, .flops = below[i]});
  }
  std::ranges::stable_sort(parts, std::greater{}, &Subtree::flops);
  std::int64_t most_rest = 0;
  const auto take_work = [&] {
    const std::int64_t before = size.work;
    size.work += 3 * std::exchange(most_rest, 0) + size.padding;
    return before;
  };
  for (Subtree& part : parts) {
    std::vector<std::int64_t> of;
    for (std::int64_t s = part.fronts.first; s < part.fronts.first + part.fronts.count; ++s) {
      of.push_back(s);
      most_rest = std::max<std::int64_t>(most_rest, at(s).rest);
    }
    part.work = take_work();
    const std::int64_t stack = place_stacks(of, 0);
    if (!shared) size.stack = stack;
    if (!shared) return;
    size.scratch = std::max(size.scratch, stack);
  }
  for (const std::int64_t s : top) most_rest = std::max<std::int64_t>(most_rest, at(s).rest);
  size.top_work = take_work();
  size.stack = place_stacks(top, 0);
  fronts_of_top = fronts;
  for (Subtree& part : parts) {
    part.kept = (fronts_of_top.begin() + part.fronts.first + part.fronts.count - 1)->update = size.stack;
    size.stack += 3 * root(part).rest * root(part).update_ld;
    place_tail(part);
  }
}

}  // namespace forefeel
