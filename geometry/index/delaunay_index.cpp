#include "geometry/index/delaunay_index.hpp"

#include <CGAL/Delaunay_triangulation_3.h>
#include <CGAL/Delaunay_triangulation_cell_base_3.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_cell_base_with_info_3.h>
#include <CGAL/Triangulation_vertex_base_with_info_3.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <atomic>
#include <cassert>
#include <cmath>

#include "geometry/index/integer_predicates.hpp"

namespace forefeel {
namespace {

// CGAL's exact predicates, with the signs that rounding leaves open decided on integers where the points allow it.
struct Kernel : CGAL::Exact_predicates_inexact_constructions_kernel {
  using Exact = CGAL::Exact_predicates_inexact_constructions_kernel;
  using Point = Exact::Point_3;
  static std::array<double, 3> coordinates(const Point& p) { return {p.x(), p.y(), p.z()}; }

  struct Orientation_3 : Exact::Orientation_3 {
    using Exact::Orientation_3::operator();
    CGAL::Orientation operator()(const Point& p, const Point& q, const Point& r, const Point& s) const {
      const Vec3 a(q.x() - p.x(), q.y() - p.y(), q.z() - p.z()),
          b(r.x() - p.x(), r.y() - p.y(), r.z() - p.z()), c(s.x() - p.x(), s.y() - p.y(), s.z() - p.z());
      const double volume = a.dot(b.cross(c));
      // Six products of three differences, each rounded by at most 9 units in the last place with those of the sums.
      const double bound =
          1e-14 * a.cwiseAbs().maxCoeff() * b.cwiseAbs().maxCoeff() * c.cwiseAbs().maxCoeff();
      if (std::abs(volume) > bound && bound > 1e-250) return volume > 0 ? CGAL::POSITIVE : CGAL::NEGATIVE;
      const GridPoints<4> grid({coordinates(p), coordinates(q), coordinates(r), coordinates(s)});
      if (!grid.exact()) return Exact::Orientation_3()(p, q, r, s);
      return static_cast<CGAL::Orientation>(orientation_sign(grid(1, 0), grid(2, 0), grid(3, 0)));
    }
  };
  Orientation_3 orientation_3_object() const { return {}; }

  struct Side_of_oriented_sphere_3 : Exact::Side_of_oriented_sphere_3 {
    CGAL::Oriented_side operator()(const Point& p, const Point& q, const Point& r, const Point& s,
                                   const Point& t) const {
      const Vec3 o = vec(t), a = vec(p) - o, b = vec(r) - o, c = vec(q) - o, d = vec(s) - o;
      const double aa = a.squaredNorm(), bb = b.squaredNorm(), cc = c.squaredNorm(), dd = d.squaredNorm();
      const Vec3 ab = a.cross(b), cd = c.cross(d);
      const double sum = dd * ab.dot(c) - cc * ab.dot(d) + bb * cd.dot(a) - aa * cd.dot(b);
      const Vec3 most = a.cwiseAbs().cwiseMax(b.cwiseAbs()).cwiseMax(c.cwiseAbs()).cwiseMax(d.cwiseAbs());
      // 24 products, each at most this one, rounded by at most 24 units in the last place with those of the sums.
      const double bound = 1.5e-13 * most.prod() * std::max({aa, bb, cc, dd});
      if (std::abs(sum) > bound && bound > 1e-250)
        return sum > 0 ? CGAL::ON_POSITIVE_SIDE : CGAL::ON_NEGATIVE_SIDE;
      const GridPoints<5> grid(
          {coordinates(p), coordinates(q), coordinates(r), coordinates(s), coordinates(t)});
      if (!grid.exact()) return Exact::Side_of_oriented_sphere_3()(p, q, r, s, t);
      return static_cast<CGAL::Oriented_side>(sphere_sign(grid(0, 4), grid(2, 4), grid(1, 4), grid(3, 4)));
    }
  };
  Side_of_oriented_sphere_3 side_of_oriented_sphere_3_object() const { return {}; }

  static Vec3 vec(const Point& p) { return {p.x(), p.y(), p.z()}; }
};

}  // namespace
}  // namespace forefeel

template <>
struct CGAL::Triangulation_structural_filtering_traits<
    forefeel::Kernel> {  // as for the kernel it derives from
  using Use_structural_filtering_tag = CGAL::Tag_true;
};

namespace forefeel {
namespace {

struct CellNote {
  std::int32_t watches = -1;  // head of a list in Impl::links
};
using VertexBase = CGAL::Triangulation_vertex_base_with_info_3<std::uint32_t, Kernel>;
using CellBase = CGAL::Triangulation_cell_base_with_info_3<CellNote, Kernel,
                                                           CGAL::Delaunay_triangulation_cell_base_3<Kernel>>;
using Tds = CGAL::Triangulation_data_structure_3<VertexBase, CellBase>;
using Delaunay = CGAL::Delaunay_triangulation_3<Kernel, Tds>;
using Point = Kernel::Point_3;
using CellHandle = Delaunay::Cell_handle;
using VertexHandle = Delaunay::Vertex_handle;

// What CGAL calls a visitor of hidden points, of which a Delaunay triangulation has none: it sees the cells that an
// insertion destroys while it takes CGAL's own path, which is faster than find_conflicts() and insert_in_hole().
template <class Gone>
struct ConflictVisitor {
  Gone gone;
  template <class Iterator>
  void process_cells_in_conflict(Iterator first, Iterator last) const {
    for (; first != last; ++first) gone(*first);
  }
  void reinsert_vertices(VertexHandle) const {}
  VertexHandle replace_vertex(CellHandle cell, int i, const Point&) const { return cell->vertex(i); }
  void hide_point(CellHandle, const Point&) const {}
};

struct Triangulation : Delaunay {
  // In dimension 3. gone(cell) for every cell that the new point destroys, before it does.
  template <class Gone>
  VertexHandle insert_in_space(const Point& p, CellHandle start, Gone&& gone) {
    Locate_type type;
    int i = 0, j = 0;
    const CellHandle cell = locate(p, type, i, j, start);
    const Conflict_tester_3 tester(p, this);
    ConflictVisitor<Gone&> visitor{gone};
    return insert_in_conflict(p, type, cell, i, j, tester, visitor);
  }
};

constexpr double flat = 1e-7;         // relative height of cells whose circumcentre rounding decides
constexpr double thin = 1e-12;        // relative height of cells that count as coplanar
constexpr double on_face = 1e-9;      // weights below are zero: q lies on a facet, edge or vertex
constexpr double rounding = 0x1p-52;  // of a coordinate

Vec3 vec(const Point& p) {
  return {p.x(), p.y(), p.z()};
}
Point point(const Vec3& v) {
  return {v.x(), v.y(), v.z()};
}

// Corners relative to q, and the barycentric weights of q.
struct Simplex {
  std::array<Vec3, 4> at;
  std::array<double, 4> weight;
  double lowest = 0;

  // False where the cell is lower than `height` [m] or `thin`: its weights would be rounding.
  bool set(CellHandle cell, const Vec3& q, double height) {
    for (int i = 0; i < 4; ++i) at[static_cast<std::size_t>(i)] = vec(cell->vertex(i)->point()) - q;
    const Vec3 a = at[1] - at[0], b = at[2] - at[0], c = at[3] - at[0];
    const double volume = a.dot(b.cross(c));
    const double squared = std::max({a.squaredNorm(), b.squaredNorm(), c.squaredNorm()}),
                 longest = std::sqrt(squared);
    if (volume <= (thin * longest + height) * squared) return false;
    if (volume > 1e-5 * squared * longest) {
      const Vec3 bc = at[2].cross(at[3]), ab = at[0].cross(at[1]);
      weight = {at[1].dot(bc) / volume, -at[0].dot(bc) / volume, at[3].dot(ab) / volume,
                -at[2].dot(ab) / volume};
    } else {
      set_exactly(cell, q);
    }
    lowest = std::min({weight[0], weight[1], weight[2], weight[3]});
    return true;
  }
  // In a thin cell the differences of coordinates must not be rounded, either.
  void set_exactly(CellHandle cell, const Vec3& q) {
    using Long3 = Eigen::Matrix<long double, 3, 1>;
    std::array<Long3, 4> p;
    for (int i = 0; i < 4; ++i)
      p[static_cast<std::size_t>(i)] =
          vec(cell->vertex(i)->point()).cast<long double>() - q.cast<long double>();
    const Long3 bc = p[2].cross(p[3]), ab = p[0].cross(p[1]);
    const std::array<long double, 4> part{p[1].dot(bc), -p[0].dot(bc), p[3].dot(ab), -p[2].dot(ab)};
    const long double whole = part[0] + part[1] + part[2] + part[3];
    for (std::size_t i = 0; i < 4; ++i) weight[i] = static_cast<double>(part[i] / whole);
  }
  void clamp() {
    double sum = 0;
    for (double& w : weight) sum += w = std::max(w, 0.0);
    for (double& w : weight) w /= sum;
  }
  double spread() const {
    double sum = 0;
    for (std::size_t i = 0; i < 4; ++i) sum += weight[i] * at[i].squaredNorm();
    return std::sqrt(sum);
  }
};

// A place well inside the hull, kept while it grows: the mean of the states that are farthest along 26 directions.
class Inside {
 public:
  Inside() {
    for (int k = 0; k < 13; ++k)
      direction_[static_cast<std::size_t>(k)] = Vec3(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1);
    for (std::size_t i = 0; i < 13; ++i)
      low_[i] = std::numeric_limits<double>::infinity(), high_[i] = -low_[i];
  }
  void add(const Vec3& p) {
    bool changed = false;
    for (std::size_t i = 0; i < 13; ++i) {
      const double along = direction_[i].dot(p);
      if (along < low_[i]) low_[i] = along, first_[i] = p, changed = true;
      if (along > high_[i]) high_[i] = along, last_[i] = p, changed = true;
    }
    if (!changed) return;
    largest_ = std::max(largest_, p.cwiseAbs().maxCoeff());
    mean_ = Vec3::Zero();
    for (std::size_t i = 0; i < 13; ++i) mean_ += (first_[i] + last_[i]) / 26;
  }
  const Vec3& place() const { return mean_; }
  double largest() const { return largest_; }  // coordinate of any state, without sign [m]

 private:
  std::array<Vec3, 13> direction_, first_, last_;
  std::array<double, 13> low_, high_;
  Vec3 mean_ = Vec3::Zero();
  double largest_ = 0;
};

// Circumcentre relative to the first corner; infinite where the cell is flat.
Vec3 circumcentre(CellHandle cell) {
  const Vec3 o = vec(cell->vertex(0)->point());
  const Vec3 a = vec(cell->vertex(1)->point()) - o, b = vec(cell->vertex(2)->point()) - o,
             c = vec(cell->vertex(3)->point()) - o;
  const double aa = a.squaredNorm(), bb = b.squaredNorm(), cc = c.squaredNorm();
  const double volume = a.dot(b.cross(c)), longest = std::max({aa, bb, cc});
  if (volume <= flat * longest * std::sqrt(longest))
    return Vec3::Constant(std::numeric_limits<double>::infinity());
  return (aa * b.cross(c) + bb * c.cross(a) + cc * a.cross(b)) / (2 * volume);
}
double circumradius(CellHandle cell) {
  return circumcentre(cell).norm();
}

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
  Triangulation triangulation;
  std::uint64_t version = next_version();
  std::vector<VertexHandle> vertex;  // by id
  struct Link {
    std::uint32_t token;
    std::int32_t next;
  };
  std::vector<Link> links;
  std::int32_t free_link = -1;
  std::vector<std::uint32_t> disturbed;

  Inside inside;

  // Heights that rounding of the states' coordinates may have made [m].
  double grain() const { return 64 * rounding * inside.largest(); }
  CellHandle start(StateId near) const {
    if (near.valid() && near.value < vertex.size() && vertex[near.value] != VertexHandle())
      return vertex[near.value]->cell();
    return {};
  }
  void add_watch(CellHandle cell, std::uint32_t token);
  void release_watches(CellHandle cell);
  CellHandle solid_cell(const Vec3& q, CellHandle from, Simplex& simplex) const;
  CellHandle inner_cell(CellHandle cell, const Vec3& q, double longest, Simplex& simplex) const;
  double least_circumradius(CellHandle cell, const Simplex& simplex) const;
};

void DelaunayIndex::Impl::add_watch(CellHandle cell, std::uint32_t token) {
  std::int32_t link = free_link;
  if (link >= 0) {
    free_link = links[static_cast<std::size_t>(link)].next;
  } else {
    link = static_cast<std::int32_t>(links.size());
    links.emplace_back();
  }
  links[static_cast<std::size_t>(link)] = {token, cell->info().watches};
  cell->info().watches = link;
}

void DelaunayIndex::Impl::release_watches(CellHandle cell) {
  for (std::int32_t link = cell->info().watches; link >= 0;) {
    Link& here = links[static_cast<std::size_t>(link)];
    disturbed.push_back(here.token);
    const std::int32_t next = here.next;
    here.next = free_link;
    free_link = link;
    link = next;
  }
  cell->info().watches = -1;
}

// The facet by which q left the hull, for an infinite cell: how far q is above its plane.
struct Exit {
  double longest;  // edge [m]
  double height;   // [m]; 0 where the facet is too thin to have a normal

  Exit(const Delaunay& triangulation, CellHandle cell, const Vec3& q) {
    const int far = cell->index(triangulation.infinite_vertex());
    const Vec3 a = vec(cell->vertex((far + 1) & 3)->point()), b = vec(cell->vertex((far + 2) & 3)->point()),
               c = vec(cell->vertex((far + 3) & 3)->point());
    const Vec3 normal = (b - a).cross(c - a);
    longest = std::sqrt(std::max({(b - a).squaredNorm(), (c - a).squaredNorm(), (c - b).squaredNorm()}));
    const double area = normal.norm();
    height = area > 1e-6 * longest * longest ? std::abs(normal.dot(q - a)) / area : 0;
  }
};

// A cell that contains q and is not flat, from a flat one or, where q lies outside the hull by rounding, from an
// infinite one: that of a place beside q, towards the inside of the hull. Over the flat cells of a face the lifted
// hull can only rise outwards (it is convex, and does not fall steeply within), so the inner cell has the least spread.
CellHandle DelaunayIndex::Impl::inner_cell(CellHandle cell, const Vec3& q, double longest,
                                           Simplex& simplex) const {
  const Vec3 toward = (inside.place() - q).normalized();
  // No direction of a lattice: a step along a flat cell would stay in it.
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

std::size_t DelaunayIndex::size() const {
  return impl_->triangulation.number_of_vertices();
}
int DelaunayIndex::dimension() const {
  return impl_->triangulation.dimension();
}
std::size_t DelaunayIndex::cell_count() const {
  return impl_->triangulation.number_of_finite_cells();
}
std::span<const std::uint32_t> DelaunayIndex::disturbed() const {
  return impl_->disturbed;
}

StateId DelaunayIndex::insert(StateId id, const Vec3& at, StateId near) {
  Impl& my = *impl_;
  my.disturbed.clear();
  const std::size_t before = my.triangulation.number_of_vertices();
  VertexHandle vertex;
  if (my.triangulation.dimension() == 3) {
    vertex = my.triangulation.insert_in_space(point(at), my.start(near),
                                              [&my](CellHandle gone) { my.release_watches(gone); });
  } else {
    vertex = my.triangulation.insert(point(at));
  }
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
  // The cell is only a place to start from: nothing is written through it.
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

bool DelaunayIndex::watch(const Vec3& q, StateId near, std::uint32_t token) {
  Impl& my = *impl_;
  Simplex simplex;
  if (my.triangulation.dimension() < 3) return false;
  CellHandle cell = my.solid_cell(q, my.start(near), simplex);
  if (cell == CellHandle()) {
    cell = my.triangulation.locate(point(q), my.start(near));
    if (!my.triangulation.is_infinite(cell)) return false;
    // In the plane of a facet q may come to lie in the hull while the facet stays.
    const Exit exit(my.triangulation, cell, q);
    if (exit.height <= 1e-6 * exit.longest + my.grain()) return false;
  }
  my.add_watch(cell, token);
  return true;
}

void DelaunayIndex::watch(const PathWalk& walk, std::uint32_t token) {
  assert(walk.version == impl_->version && walk.cell);
  impl_->add_watch(Tds::Cell_range::s_iterator_to(*static_cast<Tds::Cell*>(const_cast<void*>(walk.cell))),
                   token);
}

std::vector<DelaunayIndex::Cell> DelaunayIndex::cells() const {
  std::vector<Cell> result;
  if (dimension() < 3) return result;
  result.reserve(cell_count());
  for (const CellHandle cell : impl_->triangulation.finite_cell_handles()) {
    Cell out;
    for (int i = 0; i < 4; ++i) out.states[static_cast<std::size_t>(i)] = {cell->vertex(i)->info()};
    out.circumradius = circumradius(cell);
    result.push_back(out);
  }
  return result;
}

std::vector<DelaunayIndex::Ball> DelaunayIndex::circumballs() const {
  std::vector<Ball> result;
  if (dimension() < 3) return result;
  result.reserve(cell_count());
  for (const CellHandle cell : impl_->triangulation.finite_cell_handles()) {
    const Vec3 centre = circumcentre(cell);
    if (centre.allFinite()) result.push_back({vec(cell->vertex(0)->point()) + centre, centre.norm()});
  }
  return result;
}

}  // namespace forefeel
