#include "geometry/meshing/tet_fill.hpp"

#include <fmt/format.h>
#include <unistd.h>  // _exit

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <numbers>
#include <set>

#include "geometry/common/packer.hpp"
#include "geometry/common/union_find.hpp"
#include "geometry/meshing/child_process.hpp"
#include "geometry/meshing/tet_improve.hpp"

// libtet is compiled with TETLIBRARY: on failure it frees its memory, throws an int, and frees the memory
// again while the stack unwinds. This definition replaces its weak function and ends the process at once.
// TetGen runs in a child process (below).
#define TETLIBRARY
#define terminatetetgen terminatetetgen_of_the_header
#include <tetgen.h>
#undef terminatetetgen
void terminatetetgen(tetgenmesh*, int code);
void terminatetetgen(tetgenmesh*, int code) {
  _exit(100 + code);
}

namespace forefeel {
namespace {

using Clock = std::chrono::steady_clock;

// A power of two (so that scaling is exact) that brings the body to a size that suits TetGen's tolerances.
double scale_for(const Surface& surface) {
  double side = 0;
  for (const Vec3& node : surface.nodes)
    side = std::max(side, (node - surface.nodes.front()).cwiseAbs().maxCoeff());
  return side > 0 && std::isfinite(side) ? std::exp2(6 - std::ilogb(side)) : 1;
}

void load(tetgenio& in, const Surface& surface, double scale) {
  in.firstnumber = 0;
  in.numberofpoints = static_cast<int>(surface.nodes.size());
  in.pointlist = new REAL[3 * surface.nodes.size()];
  for (std::size_t i = 0; i < surface.nodes.size(); ++i)
    for (unsigned k = 0; k < 3; ++k) in.pointlist[3 * i + k] = scale * surface.nodes[i][k];
  in.numberoffacets = static_cast<int>(surface.triangles.size());
  in.facetlist = new tetgenio::facet[surface.triangles.size()];
  for (std::size_t i = 0; i < surface.triangles.size(); ++i) {
    tetgenio::facet& facet = in.facetlist[i];
    tetgenio::init(&facet);
    facet.numberofpolygons = 1;
    facet.polygonlist = new tetgenio::polygon[1];
    tetgenio::polygon& polygon = facet.polygonlist[0];
    tetgenio::init(&polygon);
    polygon.numberofvertices = 3;
    polygon.vertexlist = new int[3];
    std::ranges::copy(surface.triangles[i], polygon.vertexlist);
  }
}

std::string switches_of(const TetFillOptions& options, double scale) {
  // -q: circumradius at most 1.3 shortest edges, dihedral angles of 14 degrees wanted (TetGen does not always reach
  // them)
  std::string switches = "pQO7/7q1.300/14.0";
  if (options.keep_surface) switches += "Y";
  if (options.max_volume > 0 && !options.size)
    switches += fmt::format("a{:.9f}", options.max_volume * scale * scale * scale);
  return switches;
}

// The bound of a graded fill. TetGen's callback has no context; only the child process sets this.
struct Bound {
  const TetFillOptions& options;
  double scale;
};
const Bound* bound_in_child = nullptr;

bool is_too_large(REAL* a, REAL* b, REAL* c, REAL* d, REAL*, REAL) {
  const auto corner = [](const REAL* p) -> Vec3 { return Vec3(p[0], p[1], p[2]) / bound_in_child->scale; };
  const Vec3 origin = corner(a), u = corner(b) - origin, v = corner(c) - origin, w = corner(d) - origin;
  const double edge = bound_in_child->options.size(origin + (u + v + w) / 4);
  return std::abs(u.cross(v).dot(w)) / 6 > bound_in_child->options.max_volume * edge * edge * edge;
}

// In the child: writes coordinates and indices, each behind their count, as unpack() reads them.
int run_tetgen(int out, const Surface& surface, double scale, const TetFillOptions& options) {
  // No destructors: the child process ends soon.
  auto& in = *new tetgenio;
  auto& result = *new tetgenio;
  load(in, surface, scale);
  const std::string switches = switches_of(options, scale);
  const Bound bound{options, scale};
  bound_in_child = &bound;
  if (options.size && options.max_volume > 0) in.tetunsuitable = is_too_large;
  try {
    std::string text = switches;
    tetrahedralize(text.data(), &in, &result);
  } catch (...) {
    return 100;
  }
  const auto points = static_cast<std::uint64_t>(result.numberofpoints);
  const auto tets = static_cast<std::uint64_t>(result.numberoftetrahedra);
  const bool written =
      write_to(out, &points, sizeof points) && write_to(out, result.pointlist, sizeof(Vec3) * points) &&
      write_to(out, &tets, sizeof tets) && write_to(out, result.tetrahedronlist, sizeof(Tet) * tets);
  return written ? 0 : child_cut_short;
}

// Number of connected parts of the surface.
std::size_t parts(const Surface& surface) {
  TetMesh as_tets{.nodes = surface.nodes, .tets = {}, .groups = {}};
  for (const auto& [a, b, c] : surface.triangles) as_tets.tets.push_back({a, b, c, c});
  const std::vector<int> part = components(as_tets);
  return part.empty() ? 0 : static_cast<std::size_t>(1 + *std::max_element(part.begin(), part.end()));
}

std::string reason(const ChildOutcome& outcome) {
  using End = ChildOutcome::End;
  if (outcome.end == End::late) return "TetGen did not finish in time";
  if (outcome.end == End::stopped) return "interrupted";
  if (outcome.end == End::not_begun)
    return fmt::format("TetGen cannot be started: {}", std::strerror(outcome.code));
  if (outcome.end == End::signalled) return fmt::format("TetGen crashed (signal {})", outcome.code);
  switch (outcome.code) {
    case 101:
      return "TetGen ran out of memory";
    case 103:
      return "the surface intersects itself";
    case 104:
      return "the surface has features too small for TetGen";
    case 105:
      return "the surface has facets that nearly touch";
    case 110:
      return "TetGen rejects the surface";
    default:
      return fmt::format("TetGen failed (code {})", outcome.code - 100);
  }
}

std::optional<TetMesh> unpack(const std::string& data, double scale) {
  TetMesh mesh;
  try {
    Unpacker in(Bytes(data.begin(), data.end()));
    mesh.nodes = in.values<Vec3>();
    mesh.tets = in.values<Tet>();
    in.expect_end();
  } catch (const MalformedMessage&) {
    return std::nullopt;
  }
  for (const Tet& tet : mesh.tets)
    for (const NodeIndex node : tet)
      if (node >= mesh.nodes.size()) return std::nullopt;
  for (Vec3& node : mesh.nodes) node /= scale;
  for (std::size_t t = 0; t < mesh.tets.size(); ++t)  // TetGen's own orientation is the opposite of ours
    if (tet_volume(mesh, t) < 0) std::swap(mesh.tets[t][2], mesh.tets[t][3]);
  return mesh;
}

// False where a node is not finite or lies outside the surface's box, beyond rounding.
bool stays_near(const TetMesh& mesh, const Surface& surface) {
  const Box box = bounding_box(surface);
  const Vec3 margin = Vec3::Constant(1e-6 * box.size().norm());
  const Box around{box.low - margin, box.high + margin};
  return std::ranges::all_of(mesh.nodes, [&](const Vec3& node) { return around.contains(node); });
}

// False if the mesh does not fill the surface, that is, if the volumes differ. Checked only for a surface of one closed
// part whose triangles are all kept.
bool fills(const TetMesh& mesh, const Surface& surface) {
  double volume = 0;
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) volume += std::abs(tet_volume(mesh, t));
  const double wanted = enclosed_volume(surface);
  return std::abs(volume - wanted) <= 1e-3 * wanted;
}

}  // namespace

std::optional<TetMesh> fill_with_tets(const Surface& surface, const TetFillOptions& options,
                                      std::string& problem) {
  if (options.fills) ++*options.fills;
  const double scale = scale_for(surface);
  const ChildOutcome outcome = run_apart({.deadline = Clock::now() + options.patience},
                                         [&](int out) { return run_tetgen(out, surface, scale, options); });
  if (outcome.end != ChildOutcome::End::exited || outcome.code != 0)
    return problem = reason(outcome), std::nullopt;
  std::optional<TetMesh> mesh = unpack(outcome.data, scale);
  if (!mesh) return problem = "TetGen's answer was cut short", std::nullopt;
  if (!stays_near(*mesh, surface)) return problem = "TetGen's mesh leaves the surface", std::nullopt;
  const bool one_part = parts(surface) == 1;
  if (options.keep_surface && one_part && !fills(*mesh, surface))
    return problem = "TetGen's mesh has another volume than the surface", std::nullopt;
  if (options.keep_surface && !one_part) drop_cavities(*mesh, surface);
  // New nodes on the surface cannot be distinguished from inner ones; then no node may move.
  if (options.improve)
    improve_shapes(*mesh, {.fixed_nodes = options.keep_surface ? surface.nodes.size() : mesh->nodes.size(),
                           .held = options.held,
                           .onto = options.onto});
  return mesh;
}

namespace {

double log_ratio(std::size_t count, double asked) {
  return std::abs(std::log(static_cast<double>(count) / asked));
}

// The volume bound whose mesh comes nearest to a count.
class BoundSearch {
 public:
  BoundSearch(const Surface& surface, TetFillOptions options) : surface_(surface), options_(options) {
    options_.improve = false;
  }

  struct Result {
    std::optional<TetMesh> mesh;
    bool too_fine = false;
    std::string problem;
  };
  Result nearest(double asked, double share) {
    Result best;
    const auto attempt = [&](double bound) -> std::size_t {
      const std::optional<TetMesh>& mesh = fill(bound, best.problem);
      if (!mesh || mesh->tets.empty()) return 0;
      if (!best.mesh || log_ratio(mesh->tets.size(), asked) < log_ratio(best.mesh->tets.size(), asked))
        best.mesh = mesh;
      return mesh->tets.size();
    };
    const auto near = [&](std::size_t count) { return log_ratio(count, asked) <= std::log1p(share); };
    const std::size_t free = attempt(0);
    best.too_fine = static_cast<double>(free) > asked * (1 + share);
    if (free == 0 || best.too_fine || near(free)) return best;
    // The mean volume is about 0.6 of the bound. From there: find bounds on both sides, then halve the
    // interval.
    // A tetrahedron as large as wanted has 0.15 of the cube of its edge.
    double coarse = 0, fine = 0;
    double bound = (options_.size ? 0.15 : enclosed_volume(surface_) / asked) / 0.6;
    for (int k = 0; k < 16; ++k) {
      const std::size_t count = attempt(bound);
      if (count == 0 || near(count)) break;
      (static_cast<double>(count) < asked ? coarse : fine) = bound;
      bound = coarse == 0 ? fine * 1.3 : fine == 0 ? coarse / 1.3 : std::sqrt(coarse * fine);
      if (coarse != 0 && fine != 0 && coarse / fine < 1 + 1e-3) break;
    }
    return best;
  }

 private:
  const std::optional<TetMesh>& fill(double bound, std::string& problem) {
    const auto known = tried_.find(bound);
    if (known != tried_.end()) return known->second;
    options_.max_volume = bound;
    return tried_[bound] = fill_with_tets(surface_, options_, problem);
  }

  const Surface& surface_;
  TetFillOptions options_;
  std::map<double, std::optional<TetMesh>> tried_;
};

}  // namespace

CountedFill fill_to_count(const Surface& surface, std::size_t elements, double share,
                          TetFillOptions options) {
  CountedFill result;
  BoundSearch search(surface, options);
  const auto asked = static_cast<double>(elements);
  // Flips remove some of TetGen's tetrahedra; the first attempt shows how many.
  double left_by_flips = 0.955;
  for (int k = 0; k < 3; ++k) {
    BoundSearch::Result raw = search.nearest(asked / left_by_flips, share / 2);
    result.problem = raw.problem;
    result.too_fine = raw.too_fine;
    if (!raw.mesh) return result;
    const auto before = static_cast<double>(raw.mesh->tets.size());
    improve_shapes(*raw.mesh,
                   {.fixed_nodes = surface.nodes.size(), .held = options.held, .onto = options.onto});
    const std::size_t count = raw.mesh->tets.size();
    left_by_flips = static_cast<double>(count) / before;
    if (!result.mesh || log_ratio(count, asked) < log_ratio(result.mesh->tets.size(), asked))
      result.mesh = std::move(*raw.mesh);
    if (log_ratio(result.mesh->tets.size(), asked) <= std::log1p(share)) break;
  }
  result.too_fine = result.too_fine && static_cast<double>(result.mesh->tets.size()) > asked * (1 + share);
  return result;
}

// ---- cavities

namespace {

Triangle sorted(Triangle t) {
  std::ranges::sort(t);
  return t;
}

// Number of the region of each tetrahedron. A region is connected without crossing the surface.
std::vector<std::uint32_t> regions_of(const TetMesh& mesh, const Surface& surface) {
  std::set<Triangle> walls;
  for (const Triangle& t : surface.triangles) walls.insert(sorted(t));
  std::vector<std::pair<Triangle, std::uint32_t>> sides;
  for (std::size_t t = 0; t < mesh.tets.size(); ++t)
    for (std::size_t k = 0; k < 4; ++k) {
      const Tet& tet = mesh.tets[t];
      sides.emplace_back(sorted({tet[(k + 1) % 4], tet[(k + 2) % 4], tet[(k + 3) % 4]}),
                         static_cast<std::uint32_t>(t));
    }
  std::ranges::sort(sides);
  UnionFind sets(mesh.tets.size());
  for (std::size_t i = 0; i + 1 < sides.size(); ++i)
    if (sides[i].first == sides[i + 1].first && !walls.contains(sides[i].first))
      sets.join(sides[i].second, sides[i + 1].second);
  std::vector<std::uint32_t> region(mesh.tets.size());
  for (std::uint32_t t = 0; t < region.size(); ++t) region[t] = sets.find(t);
  return region;
}

// Solid angle of a triangle seen from q, over 4 pi (Van Oosterom and Strackee 1983).
double solid_angle(const Vec3& q, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 u = a - q, v = b - q, w = c - q;
  const double lu = u.norm(), lv = v.norm(), lw = w.norm();
  const double denominator = lu * lv * lw + u.dot(v) * lw + v.dot(w) * lu + w.dot(u) * lv;
  return 2 * std::atan2(u.dot(v.cross(w)), denominator) / (4 * std::numbers::pi);
}

double winding_number(const Surface& surface, const Vec3& q) {
  double sum = 0;
  for (const auto& [a, b, c] : surface.triangles)
    sum += solid_angle(q, surface.nodes[a], surface.nodes[b], surface.nodes[c]);
  return sum;
}

}  // namespace

void drop_cavities(TetMesh& mesh, const Surface& surface) {
  const std::vector<std::uint32_t> region = regions_of(mesh, surface);
  std::vector<int> inside(mesh.tets.size(), -1);  // by region; -1: not yet known
  std::vector<Tet> kept;
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    int& known = inside[region[t]];
    if (known < 0) {
      Vec3 centre = Vec3::Zero();
      for (const NodeIndex node : mesh.tets[t]) centre += mesh.nodes[node] / 4;
      known = winding_number(surface, centre) > 0.5;
    }
    if (known) kept.push_back(mesh.tets[t]);
  }
  if (kept.size() == mesh.tets.size()) return;
  mesh.tets = std::move(kept);
  drop_unused_nodes(mesh, surface.nodes.size());
}

}  // namespace forefeel
