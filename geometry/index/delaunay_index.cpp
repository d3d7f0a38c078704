#include "geometry/index/delaunay_index.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>

#include "geometry/index/delaunay_cgal.hpp"

namespace forefeel {
namespace {

Spread spread_of(const Simplex& simplex, CellHandle cell) {
  Spread result;
  result.inside = true;
  result.spread = simplex.spread();
  result.weights = simplex.weight;
  for (int i = 0; i < 4; ++i) {
    result.states[static_cast<std::size_t>(i)] = {cell->vertex(i)->info()};
    result.at[static_cast<std::size_t>(i)] = vec(cell->vertex(i)->point());
  }
  return result;
}

}  // namespace

std::uint64_t next_version() {
  static std::atomic<std::uint64_t> last{0};
  return last.fetch_add(1, std::memory_order_relaxed) + 1;
}

struct DelaunayIndex::Impl {
  Delaunay triangulation;
  std::uint64_t version = next_version();
  std::vector<VertexHandle> vertex;  // by id
  Inside inside;

  // Heights that rounding of the states' coordinates may have made [m].
  double grain() const { return 64 * rounding * inside.largest(); }
  CellHandle start(StateId near) const {
    if (near.valid() && near.value < vertex.size() && vertex[near.value] != VertexHandle())
      return vertex[near.value]->cell();
    return {};
  }
  CellHandle solid_cell(const Vec3& q, CellHandle from, Simplex& simplex) const;
  CellHandle inner_cell(CellHandle cell, const Vec3& q, double longest, Simplex& simplex) const;
  double least_circumradius(CellHandle cell, const Simplex& simplex) const;
};

// A cell for q that is not flat, if the cell found is flat, or infinite because q lies outside the hull by
// rounding. It is the cell of a place beside q, towards the inside of the hull. Over the flat cells of a face
// the lifted hull can only rise outwards (it is convex and does not fall steeply inside), so the inner cell
// has the least spread.
CellHandle DelaunayIndex::Impl::inner_cell(CellHandle cell, const Vec3& q, double longest,
                                           Simplex& simplex) const {
  const Vec3 toward = (inside.place() - q).normalized();
  // None of these is a direction of a lattice, because a step along a flat cell would stay in the cell.
  static const std::array<Vec3, 4> aside{Vec3(0.267, -0.534, 0.802), Vec3(-0.771, 0.154, 0.617),
                                         Vec3(0.577, 0.742, -0.342), Vec3(-0.302, -0.905, -0.301)};
  for (const double step : {1e-11, 1e-9}) {
    const double length = std::max(step * longest, 8 * grain());
    for (const double bend : {0.0, 0.3, 0.03, 0.003})
      for (const Vec3& other : aside) {
        const Vec3 beside = q + length * (toward + bend * other).normalized();
        const CellHandle found = triangulation.locate(point(beside), cell);
        if (!triangulation.is_infinite(found) && simplex.set(found, q, grain())) return found;
        if (bend == 0) break;
      }
  }
  return {};
}

// A cell that contains q and is not flat; q may lie outside the hull by rounding.
CellHandle DelaunayIndex::Impl::solid_cell(const Vec3& q, CellHandle from, Simplex& simplex) const {
  if (triangulation.dimension() < 3) return {};
  const CellHandle cell = triangulation.locate(point(q), from);
  if (!triangulation.is_infinite(cell)) {
    if (simplex.set(cell, q, grain())) return cell;
    double longest = 0;
    for (const Vec3& corner : simplex.at) longest = std::max(longest, (corner - simplex.at[0]).norm());
    return inner_cell(cell, q, longest, simplex);
  }
  const Exit exit(triangulation, cell, q);
  const double slack = grain() + 1e-13 * exit.longest;
  if (exit.height > slack) return {};
  const Vec3 within = q + slack * (inside.place() - q).normalized();
  if (triangulation.is_infinite(triangulation.locate(point(within), cell))) return {};
  return inner_cell(cell, q, exit.longest, simplex);
}

// Over all cells that contain q: those at the vertex, edge or facet where q lies.
double DelaunayIndex::Impl::least_circumradius(CellHandle cell, const Simplex& simplex) const {
  double least = circumradius(cell);
  const auto take = [&](CellHandle other) {
    if (!triangulation.is_infinite(other)) least = std::min(least, circumradius(other));
  };
  std::array<int, 4> on{}, off{};
  std::size_t carried = 0, zero = 0;
  for (int i = 0; i < 4; ++i) {
    if (simplex.weight[static_cast<std::size_t>(i)] > on_face)
      on[carried++] = i;
    else
      off[zero++] = i;
  }
  if (carried == 3) take(cell->neighbor(off[0]));
  if (carried == 2) {
    auto around = triangulation.incident_cells(cell, on[0], on[1]);
    const auto first = around;
    do take(around);
    while (++around != first);
  }
  if (carried == 1) {
    // CGAL's own traversal marks cells, which would be a race between queries.
    const VertexHandle here = cell->vertex(on[0]);
    std::vector<CellHandle> star{cell};
    for (std::size_t next = 0; next < star.size(); ++next) {
      take(star[next]);
      for (int i = 0; i < 4; ++i) {
        const CellHandle other = star[next]->neighbor(i);
        if (other->has_vertex(here) && std::find(star.begin(), star.end(), other) == star.end())
          star.push_back(other);
      }
    }
  }
  return least;
}

DelaunayIndex::DelaunayIndex() : impl_(std::make_unique<Impl>()) {}
DelaunayIndex::~DelaunayIndex() = default;
DelaunayIndex::DelaunayIndex(DelaunayIndex&&) noexcept = default;
DelaunayIndex& DelaunayIndex::operator=(DelaunayIndex&&) noexcept = default;

int DelaunayIndex::dimension() const {
  return impl_->triangulation.dimension();
}
StateId DelaunayIndex::insert(StateId id, const Vec3& at, StateId near) {
  Impl& my = *impl_;
  const std::size_t before = my.triangulation.number_of_vertices();
  const VertexHandle vertex = my.triangulation.insert(point(at), my.start(near));
  if (my.triangulation.number_of_vertices() == before) return {vertex->info()};
  my.version = next_version();
  my.inside.add(at);
  vertex->info() = id.value;
  if (my.vertex.size() <= id.value)
    my.vertex.resize(std::max<std::size_t>(id.value + 1, 2 * my.vertex.size()));
  my.vertex[id.value] = vertex;
  return id;
}

Vec3 DelaunayIndex::position(StateId id) const {
  return vec(impl_->vertex[id.value]->point());
}

Spread DelaunayIndex::spread(const Vec3& q, StateId near, bool with_alpha) const {
  Simplex simplex;
  const CellHandle cell = impl_->solid_cell(q, impl_->start(near), simplex);
  if (cell == CellHandle()) return {};
  simplex.clamp();
  Spread result = spread_of(simplex, cell);
  if (with_alpha) result.alpha = impl_->least_circumradius(cell, simplex);
  return result;
}

Spread DelaunayIndex::spread(const Vec3& q, PathWalk& walk) const {
  const Impl& my = *impl_;
  const bool current = walk.version == my.version;
  std::array<double, 4> weight;
  if (current && walk.holds(q, weight)) {
    Spread result{.inside = true, .states = walk.states, .weights = weight, .at = walk.at};
    double sum = 0;
    for (std::size_t i = 0; i < 4; ++i) sum += weight[i] * (walk.at[i] - q).squaredNorm();
    result.spread = std::sqrt(sum);
    return result;
  }
  // The search only starts at the cell; nothing is written through the pointer.
  CellHandle from = my.start(walk.near);
  if (current && walk.cell)
    from = Tds::Cell_range::s_iterator_to(*static_cast<Tds::Cell*>(const_cast<void*>(walk.cell)));
  Simplex simplex;
  const CellHandle cell = my.solid_cell(q, from, simplex);
  walk.version = my.version;
  walk.cached = false;
  walk.cell = nullptr;
  walk.near = {};
  if (cell == CellHandle()) return {};
  simplex.clamp();
  const Spread result = spread_of(simplex, cell);
  walk.cell = &*cell;
  walk.states = result.states;
  walk.near = result.states[0];
  walk.keep(result.at);
  return result;
}

std::vector<DelaunayIndex::Cell> DelaunayIndex::cells() const {
  std::vector<Cell> result;
  if (dimension() < 3) return result;
  result.reserve(impl_->triangulation.number_of_finite_cells());
  for (const CellHandle cell : impl_->triangulation.finite_cell_handles()) {
    Cell out;
    for (int i = 0; i < 4; ++i) out.states[static_cast<std::size_t>(i)] = {cell->vertex(i)->info()};
    const Vec3 centre = circumcentre(cell);
    out.centre = vec(cell->vertex(0)->point()) + centre;
    out.circumradius = centre.norm();
    result.push_back(out);
  }
  return result;
}

std::vector<StateId> DelaunayIndex::hull_states() const {
  std::vector<StateId> result;
  if (dimension() < 3) return result;
  std::vector<VertexHandle> corners;
  impl_->triangulation.finite_adjacent_vertices(impl_->triangulation.infinite_vertex(),
                                                std::back_inserter(corners));
  for (const VertexHandle corner : corners) result.push_back({corner->info()});
  return result;
}

}  // namespace forefeel
