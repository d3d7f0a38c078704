#include "geometry/meshing/tet_fill.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <map>

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
    for (int k = 0; k < 3; ++k) in.pointlist[3 * i + k] = scale * surface.nodes[i][k];
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
    polygon.vertexlist =
        new int[3]{surface.triangles[i][0], surface.triangles[i][1], surface.triangles[i][2]};
  }
}

bool write_all(int descriptor, const void* data, std::size_t size) {
  const char* at = static_cast<const char*>(data);
  while (size > 0) {
    const ssize_t n = ::write(descriptor, at, size);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return false;
    at += n, size -= static_cast<std::size_t>(n);
  }
  return true;
}

// In the child: writes two counts, coordinates, indices.
[[noreturn]] void run_child(int out, const Surface& surface, double scale, const std::string& switches) {
  // No destructors: the process ends here.
  auto& in = *new tetgenio;
  auto& result = *new tetgenio;
  load(in, surface, scale);
  try {
    std::string text = switches;
    tetrahedralize(text.data(), &in, &result);
  } catch (...) {
    _exit(100);
  }
  const std::int64_t counts[2] = {result.numberofpoints, result.numberoftetrahedra};
  const bool written =
      write_all(out, counts, sizeof counts) &&
      write_all(out, result.pointlist, sizeof(REAL) * 3 * static_cast<std::size_t>(counts[0])) &&
      write_all(out, result.tetrahedronlist, sizeof(int) * 4 * static_cast<std::size_t>(counts[1]));
  _exit(written ? 0 : 99);
}

// Reads all that the child writes; false after the deadline.
bool drain(int in, Clock::time_point deadline, std::string& data) {
  char block[1 << 16];
  for (;;) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(deadline - Clock::now()).count();
    if (left <= 0) return false;
    pollfd wait{in, POLLIN, 0};
    const int ready = ::poll(&wait, 1, static_cast<int>(std::min<long long>(left, 1000)));
    if (ready < 0 && errno != EINTR) return false;
    if (ready <= 0) continue;
    const ssize_t n = ::read(in, block, sizeof block);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return n == 0;
    data.append(block, static_cast<std::size_t>(n));
  }
}

// Number of connected parts of the surface.
std::size_t parts(const Surface& surface) {
  TetMesh as_tets{.nodes = surface.nodes, .tets = {}, .groups = {}};
  for (const auto& [a, b, c] : surface.triangles) as_tets.tets.push_back({a, b, c, c});
  const std::vector<int> part = components(as_tets);
  return part.empty() ? 0 : static_cast<std::size_t>(1 + *std::max_element(part.begin(), part.end()));
}

std::string reason(int status) {
  if (WIFSIGNALED(status)) return fmt::format("TetGen crashed (signal {})", WTERMSIG(status));
  switch (WEXITSTATUS(status)) {
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
      return fmt::format("TetGen failed (code {})", WEXITSTATUS(status) - 100);
  }
}

std::optional<TetMesh> unpack(const std::string& data, double scale) {
  std::int64_t counts[2];
  if (data.size() < sizeof counts) return std::nullopt;
  std::memcpy(counts, data.data(), sizeof counts);
  const auto points = static_cast<std::size_t>(counts[0]), tets = static_cast<std::size_t>(counts[1]);
  if (data.size() != sizeof counts + 24 * points + 16 * tets) return std::nullopt;
  TetMesh mesh;
  mesh.nodes.resize(points), mesh.tets.resize(tets);
  std::memcpy(static_cast<void*>(mesh.nodes.data()), data.data() + sizeof counts, 24 * points);
  std::memcpy(mesh.tets.data(), data.data() + sizeof counts + 24 * points, 16 * tets);
  for (Vec3& node : mesh.nodes) node /= scale;
  for (std::size_t t = 0; t < tets; ++t)  // TetGen's own orientation is the opposite of ours
    if (tet_volume(mesh, t) < 0) std::swap(mesh.tets[t][2], mesh.tets[t][3]);
  return mesh;
}

}  // namespace

std::optional<TetMesh> fill_with_tets(const Surface& surface, const TetFillOptions& options,
                                      std::string& problem) {
  std::string switches = fmt::format("pQO7/7q{:.3f}/{:.1f}", options.radius_edge, options.min_dihedral_deg);
  if (options.keep_surface) switches += "Y";
  const double scale = scale_for(surface);
  if (options.max_volume > 0) switches += fmt::format("a{:.9f}", options.max_volume * scale * scale * scale);
  int ends[2];
  if (::pipe(ends) != 0) return problem = fmt::format("no pipe: {}", std::strerror(errno)), std::nullopt;
  const pid_t child = ::fork();
  if (child == 0) {
    ::close(ends[0]);
    run_child(ends[1], surface, scale, switches);
  }
  ::close(ends[1]);
  if (child < 0)
    return ::close(ends[0]), problem = fmt::format("no process: {}", std::strerror(errno)), std::nullopt;
  std::string data;
  const bool in_time = drain(ends[0], Clock::now() + options.patience, data);
  ::close(ends[0]);
  if (!in_time) ::kill(child, SIGKILL);
  int status = 0;
  while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  if (!in_time)
    return problem = fmt::format("TetGen did not finish within {} s", options.patience.count()), std::nullopt;
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) return problem = reason(status), std::nullopt;
  std::optional<TetMesh> mesh = unpack(data, scale);
  if (!mesh) problem = "TetGen's answer was cut short";
  if (mesh && options.keep_surface && parts(surface) > 1) drop_cavities(*mesh, surface);
  // New nodes on the surface cannot be told from inner ones; in that case no node may move.
  if (mesh && options.improve)
    improve_shapes(*mesh, {.fixed_nodes = options.keep_surface ? surface.nodes.size() : mesh->nodes.size()});
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
    double coarse = 0, fine = 0, bound = enclosed_volume(surface_) / asked / 0.6;
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
    improve_shapes(*raw.mesh, {.fixed_nodes = surface.nodes.size()});
    const std::size_t count = raw.mesh->tets.size();
    left_by_flips = static_cast<double>(count) / before;
    if (!result.mesh || log_ratio(count, asked) < log_ratio(result.mesh->tets.size(), asked))
      result.mesh = std::move(*raw.mesh);
    if (log_ratio(result.mesh->tets.size(), asked) <= std::log1p(share)) break;
  }
  result.too_fine = result.too_fine && static_cast<double>(result.mesh->tets.size()) > asked * (1 + share);
  return result;
}

}  // namespace forefeel
