#include "geometry/coverage/regions.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <set>

#include "geometry/common/union_find.hpp"
#include "geometry/coverage/bridge.hpp"
#include "geometry/coverage/fill_distance.hpp"
#include "geometry/coverage/region_tree.hpp"

namespace forefeel {
struct Regions::Impl {
  RegionTree tree;
};

Regions::Regions(const PointOctree& points, DelaunayIndex& delaunay, const StateSpaceOptions& options)
    : impl_(new Impl{RegionTree(points, delaunay, options)}) {}
Regions::~Regions() = default;

Label Regions::label_at(const Vec3& q) const {
  return impl_->tree.label_at(q);
}
double Regions::finest() const {
  return impl_->tree.voxel();
}
const Box& Regions::box() const {
  return impl_->tree.box();
}
std::size_t Regions::pending() const {
  return impl_->tree.pending();
}
void Regions::inserted(const Vec3& at, std::span<const std::uint32_t> disturbed) {
  impl_->tree.inserted(at, disturbed);
}
bool Regions::settle(std::size_t budget, const std::function<void(double)>& progress) const {
  return impl_->tree.settle(budget, progress);
}

std::array<double, 4> Regions::volumes() const {
  settle();
  std::array<double, 4> volume{};
  impl_->tree.for_each_leaf([&](std::int32_t, const RegionNode& leaf) {
    volume[static_cast<std::size_t>(leaf.label)] += impl_->tree.box_of(leaf).size().prod();
  });
  return volume;
}

namespace {

// Calls meet(other leaf) for every leaf across the upper face of `node` along `axis`.
template <class Meet>
void across(const RegionTree& tree, const RegionNode& node, std::size_t axis, Meet&& meet) {
  const std::size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
  const auto face = [&](auto&& self, std::array<std::int32_t, 3> low, std::int32_t width) -> void {
    const std::int32_t found = tree.leaf_of(low);
    if (found < 0) return;
    const RegionNode& other = tree.node(found);
    if (other.kind == RegionNode::Kind::leaf && other.width() >= width) return meet(found, other);
    if (width == 1) return;
    const std::int32_t half = width / 2;
    for (const std::int32_t du : {0, half})
      for (const std::int32_t dv : {0, half}) {
        std::array<std::int32_t, 3> part = low;
        part[u] += du;
        part[v] += dv;
        self(self, part, half);
      }
  };
  std::array<std::int32_t, 3> low = node.low;
  low[axis] += node.width();
  face(face, low, node.width());
}

// Numbers the leaves of the tree, so that vectors can hold a value for each.
struct LeafTable {
  std::vector<std::int32_t> node;   // by leaf
  std::vector<std::uint32_t> leaf;  // by node
};

LeafTable list_leaves(const RegionTree& tree) {
  LeafTable table;
  tree.for_each_leaf([&](std::int32_t index, const RegionNode&) {
    if (table.leaf.size() <= static_cast<std::size_t>(index))
      table.leaf.resize(static_cast<std::size_t>(index) + 1);
    table.leaf[static_cast<std::size_t>(index)] = static_cast<std::uint32_t>(table.node.size());
    table.node.push_back(index);
  });
  return table;
}

struct Facet {
  std::uint32_t leaf, past;  // past: the leaf across one of the upper faces of `leaf`
};

// Calls visit(facet) for every facet that two leaves share, in order of `leaf`. All threads search for facets; visit()
// is called by one thread at a time.
template <class Visit>
void for_each_facet(const RegionTree& tree, const LeafTable& table, Visit&& visit) {
  constexpr std::size_t block = 2048, blocks = 64;
  std::vector<std::vector<Facet>> found(blocks);
  const std::size_t leaves = table.node.size();
  for (std::size_t start = 0; start < leaves; start += block * blocks) {
#pragma omp parallel for schedule(dynamic)
    for (std::size_t b = 0; b < blocks; ++b) {
      found[b].clear();
      const std::size_t first = std::min(leaves, start + b * block), last = std::min(leaves, first + block);
      for (std::size_t i = first; i < last; ++i)
        for (std::size_t axis = 0; axis < 3; ++axis)
          across(tree, tree.node(table.node[i]), axis, [&](std::int32_t other, const RegionNode&) {
            found[b].push_back({static_cast<std::uint32_t>(i), table.leaf[static_cast<std::size_t>(other)]});
          });
    }
    for (const std::vector<Facet>& some : found)
      for (const Facet& facet : some) visit(facet);
  }
}

// Components by union over shared facets, numbered by label, then by falling volume. Returns the component of
// each leaf.
std::vector<std::uint32_t> find_components(const RegionTree& tree, const LeafTable& table,
                                           std::vector<RegionComponent>& components) {
  UnionFind sets(table.node.size());
  const auto label = [&](std::uint32_t leaf) { return tree.node(table.node[leaf]).label; };
  for_each_facet(tree, table, [&](const Facet& facet) {
    if (label(facet.leaf) == label(facet.past)) sets.join(facet.leaf, facet.past);
  });
  std::vector<std::uint32_t> number(table.node.size(), 0xffffffffu), component(table.node.size());
  std::vector<RegionComponent> found;
  std::vector<double> largest;
  for (std::size_t i = 0; i < table.node.size(); ++i) {
    const std::uint32_t root = sets.find(static_cast<std::uint32_t>(i));
    const RegionNode& leaf = tree.node(table.node[i]);
    const Box box = tree.box_of(leaf);
    if (number[root] == 0xffffffffu) {
      number[root] = static_cast<std::uint32_t>(found.size());
      found.push_back({.label = leaf.label, .bounds = box, .safe_neighbours = {}, .sides = {}});
      largest.push_back(-1);
    }
    component[i] = number[root];
    RegionComponent& mine = found[component[i]];
    mine.volume += box.size().prod();
    ++mine.leaves;
    mine.bounds = {mine.bounds.low.cwiseMin(box.low), mine.bounds.high.cwiseMax(box.high)};
    if (leaf.width() > largest[component[i]]) largest[component[i]] = leaf.width(), mine.inner = box.centre();
  }
  std::vector<std::uint32_t> order(found.size()), rank(found.size());
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return found[a].label != found[b].label ? found[a].label < found[b].label
                                            : found[a].volume > found[b].volume;
  });
  for (std::size_t i = 0; i < order.size(); ++i) {
    rank[order[i]] = static_cast<std::uint32_t>(i);
    components.push_back(std::move(found[order[i]]));
  }
  for (std::uint32_t& c : component) c = rank[c];
  return component;
}

// Finds the safe components next to each component; next to a gap, those behind its sparse rim.
void find_safe_neighbours(const RegionTree& tree, const LeafTable& table,
                          const std::vector<std::uint32_t>& component,
                          std::vector<RegionComponent>& components) {
  std::vector<std::set<std::uint32_t>> beside(components.size()), near_safe(components.size());
  std::vector<bool> rim(table.node.size());
  for_each_facet(tree, table, [&](const Facet& facet) {
    if (tree.node(table.node[facet.leaf]).label == tree.node(table.node[facet.past]).label) return;
    rim[facet.leaf] = rim[facet.past] = true;
    beside[component[facet.leaf]].insert(component[facet.past]);
    beside[component[facet.past]].insert(component[facet.leaf]);
  });
  for (std::size_t i = 0; i < table.node.size(); ++i) {
    const RegionNode& leaf = tree.node(table.node[i]);
    if (leaf.label != Label::gap || !rim[i]) continue;
    const Box box = tree.box_of(leaf);
    tree.for_each_safe_near(box, tree.rim(box.centre()), [&](std::int32_t safe) {
      near_safe[component[i]].insert(component[table.leaf[static_cast<std::size_t>(safe)]]);
    });
  }
  name_safe_neighbours(beside, near_safe, components);
}

// Finds the sides of each gap, seen from its inner place.
void find_sides(const RegionTree& tree, std::vector<RegionComponent>& components) {
  std::size_t done = 0;
  for (RegionComponent& c : components) {
    if (c.label != Label::gap || done++ >= most_bridges) continue;
    std::vector<Vec3> offsets;
    tree.query().points().for_each_within(
        c.inner, tree.gap_radius(c.inner),
        [&](std::uint32_t, const Vec3& offset, double) { offsets.push_back(offset); });
    c.sides = bridge_sides(offsets, tree.link_deg());
  }
}

// Appends the leaves below `index`; eight leaves of one label become one.
void collect(const RegionTree& tree, std::int32_t index, const LeafTable& table,
             const std::vector<std::uint32_t>& component, std::vector<RegionLeaf>& out) {
  const RegionNode& here = tree.node(index);
  if (here.kind == RegionNode::Kind::leaf) {
    out.push_back({tree.box_of(here), here.label, component[table.leaf[static_cast<std::size_t>(index)]]});
    return;
  }
  if (here.kind != RegionNode::Kind::branch) return;
  const std::size_t start = out.size();
  std::size_t inside = 0;
  for (std::int32_t child = 0; child < 8; ++child) {
    inside += tree.node(here.children + child).kind != RegionNode::Kind::outside;
    collect(tree, here.children + child, table, component, out);
  }
  if (out.size() - start != inside) return;
  for (std::size_t i = start + 1; i < out.size(); ++i)
    if (out[i].label != out[start].label) return;
  // Eight leaves of one label share facets, so they belong to one component.
  out[start].box = tree.box_of(here);
  out.resize(start + 1);
}

}  // namespace

RegionSummary Regions::summary() const {
  settle();
  const RegionTree& tree = impl_->tree;
  RegionSummary result;
  const LeafTable table = list_leaves(tree);
  const std::vector<std::uint32_t> component = find_components(tree, table, result.components);
  find_safe_neighbours(tree, table, component, result.components);
  find_sides(tree, result.components);
  for (std::size_t root = 0; root < tree.root_count(); ++root)
    collect(tree, static_cast<std::int32_t>(root), table, component, result.leaves);
  result.leaf_count = result.leaves.size();
  for (const RegionComponent& c : result.components) {
    result.volume[static_cast<std::size_t>(c.label)] += c.volume;
    ++result.component_count[static_cast<std::size_t>(c.label)];
  }
  return result;
}

// delta has its maxima at Voronoi vertices (circumcentres of the cells) inside the box, or on its boundary.
double Regions::fill_distance() const {
  const RegionTree& tree = impl_->tree;
  const PointOctree& points = tree.query().points();
  if (points.size() == 0) return std::numeric_limits<double>::infinity();
  double largest = 0;
  for (const DelaunayIndex::Ball& ball : tree.query().delaunay().circumballs())
    if (tree.box().contains(ball.centre)) largest = std::max(largest, ball.radius);
  return largest_in_box([&](const Vec3& q) { return std::sqrt(points.nearest(q).squared); }, tree.box(),
                        largest, 4e-3 * tree.voxel());
}

std::optional<LargestHole> Regions::largest_hole() const {
  const RegionTree& tree = impl_->tree;
  std::vector<DelaunayIndex::Ball> balls = tree.query().delaunay().circumballs();
  std::erase_if(balls, [&](const DelaunayIndex::Ball& ball) { return !tree.box().contains(ball.centre); });
  const auto smaller = [](const DelaunayIndex::Ball& a, const DelaunayIndex::Ball& b) {
    return a.radius < b.radius;
  };
  std::make_heap(balls.begin(), balls.end(), smaller);
  while (!balls.empty()) {
    std::pop_heap(balls.begin(), balls.end(), smaller);
    const DelaunayIndex::Ball ball = balls.back();
    balls.pop_back();
    if (tree.query().delaunay().spread(ball.centre, {}).inside) return LargestHole{ball.radius, ball.centre};
  }
  return std::nullopt;
}

}  // namespace forefeel
