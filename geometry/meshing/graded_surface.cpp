#include "geometry/meshing/graded_surface.hpp"

#include <CGAL/boost/graph/Euler_operations.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "geometry/meshing/surface_cgal.hpp"

namespace forefeel {
namespace {

using cgal::Mesh;
using Vertex = Mesh::Vertex_index;
using Edge = Mesh::Edge_index;
using Half = Mesh::Halfedge_index;
using Face = Mesh::Face_index;

constexpr int rounds = 10, last_rounds = 12;
constexpr double longest = 4.0 / 3, shortest = 4.0 / 5;  // edge over h

enum class Kind : char { free, line, corner };  // of a vertex
enum class Line : char { none, sharp, rim };    // of an edge

class Remesher {
 public:
  explicit Remesher(const GradedInput& input) : input_(input), mesh_(cgal::to_mesh(input.start)) {
    kind_ = mesh_.add_property_map<Vertex, Kind>("v:kind", Kind::free).first;
    kept_ = mesh_.add_property_map<Edge, Line>("e:kept", Line::none).first;
    keep(input.sharp, Line::sharp);
    keep(input.rim, Line::rim);
    for (const NodeIndex node : input.corners) kind_[Vertex(node)] = Kind::corner;
  }

  GradedSurface run() {
    for (int round = 0; round < rounds; ++round) {
      split_long();
      collapse_short();
      flip_all();
      cut_chords();
      for (int k = 0; k < 3; ++k) relax();
    }
    for (int round = 0; round < last_rounds; ++round) {
      flip_all();
      if (round < last_rounds / 2) cut_chords();
      for (int k = 0; k < 4; ++k) relax();
    }
    flip_all();
    GradedSurface result;
    mesh_.collect_garbage();
    for (const Vertex v : mesh_.vertices()) result.held.push_back(kind_[v] != Kind::free);
    result.surface = cgal::from_mesh(mesh_);
    return result;
  }

 private:
  void keep(const std::vector<Link>& lines, Line line) {
    for (const auto& [a, b] : lines) {
      kept_[mesh_.edge(mesh_.halfedge(Vertex(a), Vertex(b)))] = line;
      kind_[Vertex(a)] = kind_[Vertex(b)] = Kind::line;
    }
  }
  bool is_kept(Edge e) const { return kept_[e] != Line::none; }
  Vec3 onto(Line line, const Vec3& p) const {
    return line == Line::none    ? input_.onto(p)
           : line == Line::sharp ? input_.onto_sharp(p)
                                 : input_.onto_rim(p);
  }

  Vec3 at(Vertex v) const {
    const cgal::Point& p = mesh_.point(v);
    return {p.x(), p.y(), p.z()};
  }
  void put(Vertex v, const Vec3& p) { mesh_.point(v) = cgal::Point(p.x(), p.y(), p.z()); }
  Vertex from(Edge e) const { return mesh_.source(mesh_.halfedge(e)); }
  Vertex to(Edge e) const { return mesh_.target(mesh_.halfedge(e)); }
  Vertex apex(Half h) const { return mesh_.target(mesh_.next(h)); }

  // Its length over the wanted one.
  double stretch(const Vec3& a, const Vec3& b) const {
    return (a - b).norm() / input_.size.at(0.5 * (a + b));
  }

  Vec3 area_vector(Vertex a, Vertex b, Vertex c) const { return (at(b) - at(a)).cross(at(c) - at(a)); }
  Vec3 area_vector(Face f) const {
    const Half h = mesh_.halfedge(f);
    return area_vector(mesh_.source(h), mesh_.target(h), apex(h));
  }

  struct Wanted {
    double stretch;
    Edge edge;
  };
  // Edges whose stretch is beyond a bound, the worst first.
  template <class Beyond>
  std::vector<Wanted> edges_where(const Beyond& beyond, bool longest_first) const {
    std::vector<Wanted> result;
    for (const Edge e : mesh_.edges())
      if (const double s = stretch(at(from(e)), at(to(e))); beyond(s)) result.push_back({s, e});
    std::ranges::stable_sort(result, [&](const Wanted& a, const Wanted& b) {
      return longest_first ? a.stretch > b.stretch : a.stretch < b.stretch;
    });
    return result;
  }

  void split_long() {
    for (int pass = 0; pass < 20; ++pass) {
      const std::vector<Wanted> wanted = edges_where([](double s) { return s > longest; }, true);
      if (wanted.empty()) return;
      for (const Wanted& w : wanted) split(w.edge);
      flip_all();
    }
  }

  void split(Edge e) {
    const Line line = kept_[e];
    const Vec3 middle = 0.5 * (at(from(e)) + at(to(e)));
    const Half h = mesh_.halfedge(e);
    const Half first = CGAL::Euler::split_edge(h, mesh_);  // ends at the new vertex, h follows
    const Half back = mesh_.opposite(first);
    const Vertex v = mesh_.target(first);
    const Half left = CGAL::Euler::split_face(first, mesh_.next(mesh_.next(first)), mesh_);
    const Half right = CGAL::Euler::split_face(mesh_.prev(back), mesh_.next(back), mesh_);
    kept_[mesh_.edge(first)] = kept_[mesh_.edge(h)] = line;
    kept_[mesh_.edge(left)] = kept_[mesh_.edge(right)] = Line::none;
    kind_[v] = line == Line::none ? Kind::free : Kind::line;
    put(v, onto(line, middle));
  }

  void collapse_short() {
    for (int pass = 0; pass < 20; ++pass) {
      bool any = false;
      for (const Wanted& w : edges_where([](double s) { return s < shortest; }, false)) {
        if (mesh_.is_removed(w.edge) || stretch(at(from(w.edge)), at(to(w.edge))) >= shortest) continue;
        any = collapse(w.edge) || any;
      }
      if (!any) return;
    }
  }

  // Where the node that two become lies; false if they must stay two.
  bool place_of(Edge e, Vec3& place) const {
    const Vertex a = from(e), b = to(e);
    const Kind lower = std::min(kind_[a], kind_[b]), upper = std::max(kind_[a], kind_[b]);
    if (lower == Kind::corner) return false;
    if (lower == Kind::line && !is_kept(e)) return false;
    place = lower == upper ? onto(kept_[e], 0.5 * (at(a) + at(b))) : kind_[a] == upper ? at(a) : at(b);
    return true;
  }

  // Whether the triangles around v, without those of the edge, keep their sense and length when v moves.
  bool can_move(Vertex v, Vertex other, const Vec3& place) const {
    for (const Half h : CGAL::halfedges_around_target(v, mesh_)) {
      const Vertex b = mesh_.source(h), c = apex(h);  // triangle (b, v, c)
      if (b == other || c == other) continue;
      const Vec3 before = (at(v) - at(b)).cross(at(c) - at(b)), after = (place - at(b)).cross(at(c) - at(b));
      if (before.dot(after) <= 0.3 * before.norm() * after.norm()) return false;
      if (other != Mesh::null_vertex() && stretch(place, at(b)) > longest) return false;
    }
    return true;
  }

  bool collapse(Edge e) {
    Vec3 place;
    if (!place_of(e, place) || !CGAL::Euler::does_satisfy_link_condition(e, mesh_)) return false;
    const Vertex a = from(e), b = to(e);
    if (!can_move(a, b, place) || !can_move(b, a, place)) return false;
    const Half h = mesh_.halfedge(e), back = mesh_.opposite(h);
    const std::array<Vertex, 2> apexes{apex(h), apex(back)};
    std::array<Line, 2> kept{};
    for (std::size_t k = 0; k < 2; ++k) {
      const Edge one = mesh_.edge(mesh_.halfedge(a, apexes[k])),
                 two = mesh_.edge(mesh_.halfedge(b, apexes[k]));
      if (is_kept(one) && is_kept(two)) return false;  // two lines would become one
      kept[k] = std::max(kept_[one], kept_[two]);
    }
    const Kind kind = std::max(kind_[a], kind_[b]);
    const Vertex v = CGAL::Euler::collapse_edge(e, mesh_);
    put(v, place);
    kind_[v] = kind;
    for (std::size_t k = 0; k < 2; ++k) kept_[mesh_.edge(mesh_.halfedge(v, apexes[k]))] = kept[k];
    return true;
  }

  static double cotangent(const Vec3& at, const Vec3& b, const Vec3& c) {
    return (b - at).dot(c - at) / (b - at).cross(c - at).norm();
  }

  void flip_all() {
    for (int pass = 0; pass < 20; ++pass) {
      bool any = false;
      for (const Edge e : mesh_.edges()) any = flip(e) || any;
      if (!any) return;
    }
  }

  bool flip(Edge e) {
    if (is_kept(e)) return false;
    const Half h = mesh_.halfedge(e);
    const Vertex a = from(e), b = to(e), p = apex(h), q = apex(mesh_.opposite(h));
    if (!(cotangent(at(p), at(a), at(b)) + cotangent(at(q), at(a), at(b)) < -1e-9)) return false;
    if (p == q || mesh_.halfedge(p, q) != Mesh::null_halfedge()) return false;
    const Vec3 one = area_vector(p, a, q), two = area_vector(q, b, p);
    const Vec3 before = area_vector(a, b, p) + area_vector(b, a, q);
    const auto agrees = [&](const Vec3& now) { return now.dot(before) > 0.5 * now.norm() * before.norm(); };
    if (!agrees(one) || !agrees(two)) return false;
    CGAL::Euler::flip_edge(h, mesh_);
    return true;
  }

  // A triangle whose nodes all lie on lines belongs to neither side for a set of nodes: its inner edge is cut.
  void cut_chords() {
    std::vector<Edge> chords;
    for (const Edge e : mesh_.edges()) {
      const Half h = mesh_.halfedge(e);
      const auto lined = [&](Vertex v) { return kind_[v] != Kind::free; };
      if (!is_kept(e) && lined(from(e)) && lined(to(e)) && (lined(apex(h)) || lined(apex(mesh_.opposite(h)))))
        chords.push_back(e);
    }
    for (const Edge e : chords) split(e);
  }

  void relax() {
    for (const Vertex v : mesh_.vertices())
      if (kind_[v] == Kind::free)
        relax_free(v);
      else if (kind_[v] == Kind::line)
        relax_on_line(v);
  }

  // To the centroid of the triangles around it, of density 1/h^4, along the tangent plane.
  void relax_free(Vertex v) {
    Vec3 sum = Vec3::Zero(), normal = Vec3::Zero();
    double weight = 0;
    for (const Face f : CGAL::faces_around_target(mesh_.halfedge(v), mesh_)) {
      const Half h = mesh_.halfedge(f);
      const Vec3 centroid = (at(mesh_.source(h)) + at(mesh_.target(h)) + at(apex(h))) / 3;
      const Vec3 area = area_vector(f);
      const double size = input_.size.at(centroid), density = area.norm() / (size * size * size * size);
      sum += density * centroid, weight += density, normal += area;
    }
    if (!(weight > 0) || !(normal.norm() > 0)) return;
    normal.normalize();
    Vec3 step = sum / weight - at(v);
    step -= normal.dot(step) * normal;
    try_place(v, input_.onto(at(v) + step));
  }

  // Half-way between its neighbours on the line, in units of h.
  void relax_on_line(Vertex v) {
    std::array<Vec3, 2> ends;
    std::size_t found = 0;
    Line line = Line::none;
    for (const Half h : CGAL::halfedges_around_target(v, mesh_))
      if (is_kept(mesh_.edge(h))) {
        if (found == 2) return;
        line = kept_[mesh_.edge(h)];
        ends[found++] = at(mesh_.source(h));
      }
    if (found != 2) return;
    const double one = stretch(at(v), ends[0]), two = stretch(at(v), ends[1]);
    if (!(one + two > 0)) return;
    const Vec3 towards = one > two ? ends[0] : ends[1];
    try_place(v, onto(line, at(v) + 0.5 * std::abs(one - two) / std::max(one, two) * (towards - at(v))));
  }

  void try_place(Vertex v, const Vec3& place) {
    if (can_move(v, Mesh::null_vertex(), place)) put(v, place);
  }

  const GradedInput& input_;
  Mesh mesh_;
  Mesh::Property_map<Vertex, Kind> kind_;
  Mesh::Property_map<Edge, Line> kept_;
};

}  // namespace

GradedSurface graded_surface(const GradedInput& input) {
  GradedSurface result = Remesher(input).run();
  result.onto = input.onto;
  return result;
}

}  // namespace forefeel
