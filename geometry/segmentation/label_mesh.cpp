#include "geometry/segmentation/label_mesh.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <unordered_map>

#include "geometry/common/enum_names.hpp"
#include "geometry/common/error.hpp"
#include "geometry/meshing/child_process.hpp"
#include "geometry/meshing/tet_improve.hpp"
#include "geometry/meshing/tetrahedralise.hpp"
#include "geometry/segmentation/label_domain.hpp"

namespace forefeel {
namespace {

// ---- Flat tetrahedra that perturbation and exudation leave are opened by moving nodes. No tetrahedron is added or
// removed, so each keeps its label.

constexpr double flat = 5;  // dihedral angle [deg]

TetMesh as_mesh(const LabelledTets& mesh) {
  TetMesh result{.nodes = mesh.nodes, .tets = mesh.tets, .groups = {}};
  for (std::size_t t = 0; t < result.tets.size(); ++t)
    if (tet_volume(result, t) < 0) std::swap(result.tets[t][2], result.tets[t][3]);
  return result;
}

// Nodes with tetrahedra of more than one subdomain, or on the boundary.
std::vector<char> on_interfaces(const LabelledTets& mesh, const TetMesh& body) {
  std::vector<int> of(mesh.nodes.size(), 0);
  std::vector<char> result(mesh.nodes.size(), 0);
  for (std::size_t t = 0; t < mesh.tets.size(); ++t)
    for (const NodeIndex node : mesh.tets[t]) {
      int& its = of[node];
      if (its != 0 && its != mesh.subdomain[t]) result[node] = 1;
      its = mesh.subdomain[t];
    }
  for (const NodeIndex node : surface_nodes(body)) result[node] = 1;
  return result;
}

}  // namespace

bool has_flat_tets(const LabelledTets& mesh) {
  const TetMesh body = as_mesh(mesh);
  const double side = longest_side(body), least = 2e-14 * side * side * side;
  for (std::size_t t = 0; t < body.tets.size(); ++t)
    if (!(tet_volume(body, t) > least)) return true;
  return false;
}

void mend_slivers(LabelledTets& mesh) {
  TetMesh body = as_mesh(mesh);
  mesh.tets = body.tets;
  if (body.tets.empty() || mesh_quality(body).min_dihedral_deg >= flat) return;
  // Nodes of interfaces first, as improve_shapes() expects them.
  const std::vector<char> fixed = on_interfaces(mesh, body);
  std::vector<NodeIndex> order, number(fixed.size());
  for (const char kind : {char{1}, char{0}})
    for (std::size_t i = 0; i < fixed.size(); ++i)
      if (fixed[i] == kind)
        number[i] = static_cast<NodeIndex>(order.size()), order.push_back(static_cast<NodeIndex>(i));
  for (std::size_t i = 0; i < order.size(); ++i) body.nodes[i] = mesh.nodes[order[i]];
  for (Tet& tet : body.tets)
    for (NodeIndex& node : tet) node = number[node];
  improve_shapes(
      body, {.fixed_nodes = static_cast<std::size_t>(std::ranges::count(fixed, char{1})), .flips = false});
  for (std::size_t i = 0; i < order.size(); ++i) mesh.nodes[order[i]] = body.nodes[i];
}

// ---- the mesh

namespace {

// ---- which labels

constexpr std::size_t most_named = 40;     // labels listed in an error
constexpr std::size_t most_at_once = 255;  // labels of a mesh; more are a scan, or an atlas to choose from

std::string values_of(const LabelVolume& volume) {
  std::string text;
  std::size_t labels = 0;
  for (const std::int64_t value : volume.values) {
    if (value == 0 || ++labels > most_named) continue;
    text += (text.empty() ? "" : ", ") + std::to_string(value);
  }
  if (labels > most_named) text += fmt::format(", ... ({} in all)", labels);
  return text.empty() ? "none but 0" : text;
}

std::vector<LabelRegion> wanted_regions(const LabelVolume& volume, const LabelMeshOptions& options) {
  std::vector<LabelRegion> regions;
  for (const auto& [label, name] : options.labels) {
    if (!std::ranges::binary_search(volume.values, label))
      throw InputError(options.name,
                       fmt::format("has no label {}, expected those it has: {}", label, values_of(volume)));
    regions.push_back({.name = name, .label = label});
  }
  if (options.labels.empty() && volume.values.size() > most_at_once)
    throw InputError(options.name,
                     fmt::format("holds {} different values, expected at most {}: a volume of labels "
                                 "rather than a scan, or --labels that choose some of {}",
                                 volume.values.size(), most_at_once, values_of(volume)));
  if (options.labels.empty())
    for (const std::int64_t value : volume.values)
      if (value != 0) regions.push_back({.name = fmt::format("label_{}", value), .label = value});
  if (regions.empty())
    throw InputError(options.name, "holds no label but 0, the background; expected a body");
  return regions;
}

std::vector<int> subdomains(const LabelVolume& volume, const std::vector<LabelRegion>& regions) {
  std::vector<int> result(volume.values.size(), 0);
  for (std::size_t r = 0; r < regions.size(); ++r)
    *(result.begin() + (std::ranges::lower_bound(volume.values, regions[r].label) - volume.values.begin())) =
        static_cast<int>(r) + 1;
  return result;
}

// ---- the answer of the child process

struct Made {
  LabelledTets mesh;
  double hausdorff = 0;
};

// Another number of elements, within the 5 % that are allowed, gives another mesh, perhaps without flat tetrahedra.
LabelledTets without_flat_tets(const LabelDomain& domain, std::size_t elements, double seconds,
                               LabelTold& told) {
  LabelledTets mesh;
  for (const double share : {1.0, 1.025, 0.975}) {
    mesh =
        mesh_domain(domain, static_cast<std::size_t>(share * static_cast<double>(elements)), seconds, told);
    mend_slivers(mesh);
    if (mesh.tets.empty() || !has_flat_tets(mesh)) break;
  }
  return mesh;
}

int make_in_child(int out, const LabelDomain& domain, const Surface& voxels, const LabelMeshOptions& options,
                  double limit, LabelTold& told) {
  Made made{.mesh = without_flat_tets(domain, options.elements, 0.1 * limit, told)};
  told.step = static_cast<int>(LabelMeshStep::compare);
  const TetMesh mesh{.nodes = made.mesh.nodes, .tets = made.mesh.tets, .groups = {}};
  if (!mesh.tets.empty()) made.hausdorff = hausdorff_distance(voxels, boundary_surface(mesh));
  return write_to(out, &made.hausdorff, sizeof made.hausdorff) && write_to(out, made.mesh.nodes) &&
                 write_to(out, made.mesh.tets) && write_to(out, made.mesh.subdomain)
             ? 0
             : child_cut_short;
}

Made received(const std::string& data) {
  Made made;
  ChildAnswer answer(data);
  answer.take(&made.hausdorff, sizeof made.hausdorff);
  answer.take(made.mesh.nodes);
  answer.take(made.mesh.tets);
  answer.take(made.mesh.subdomain);
  return made;
}

[[noreturn]] void fail(const ChildOutcome& outcome, const LabelMeshOptions& options, double limit) {
  if (outcome.end == ChildOutcome::End::late)
    throw InputError(
        options.name,
        fmt::format("no mesh was found in {:g} s, the limit of time; expected fewer elements, fewer "
                    "--labels where there are many or tiny ones, or a longer --time-limit",
                    limit));
  if (outcome.end == ChildOutcome::End::not_begun)
    throw InputError(options.name, fmt::format("cannot be meshed: {}", std::strerror(outcome.code)));
  if (outcome.end == ChildOutcome::End::signalled)
    throw InputError(options.name, fmt::format("cannot be meshed: CGAL crashed (signal {})", outcome.code));
  throw InputError(options.name, "CGAL cannot mesh it, expected labels with connected parts of many voxels");
}

// ---- checks and warnings

void check_count(std::size_t made, const LabelMeshOptions& options) {
  const double ratio = static_cast<double>(made) / static_cast<double>(options.elements);
  if (!(std::abs(ratio - 1) <= 0.05))
    throw InputError(
        options.name,
        fmt::format(
            "{} elements cannot be met within 5 %, the nearest is {}{}", options.elements, made,
            ratio > 1 ? ": expected at least that many, fewer are larger than its thinnest parts" : ""));
}

void measure(const TetMesh& mesh, const LabelledTets& made, const LabelVolume& volume,
             const LabelDomain& domain, double scale, std::vector<LabelRegion>& regions) {
  for (const LabelDomain::Part& part : domain.parts()) {
    LabelRegion& region = regions[static_cast<std::size_t>(part.subdomain) - 1];
    region.voxels += part.voxels;
    ++region.parts;
    region.touches_border |= part.touches_border;
  }
  for (LabelRegion& region : regions)
    region.voxel_volume = scale * scale * scale * volume.voxel_volume() * static_cast<double>(region.voxels);
  for (std::size_t t = 0; t < made.tets.size(); ++t) {
    LabelRegion& region = regions[static_cast<std::size_t>(made.subdomain[t]) - 1];
    region.mesh_volume += tet_volume(mesh, t);
    ++region.elements;
  }
}

// A mesh that lost most of its body is none: thin sheets have no node of the mesher's first ones.
void check_volume(const std::vector<LabelRegion>& regions, const LabelMeshOptions& options) {
  constexpr double least = 0.5;  // share of the voxels' volume
  double meshed = 0, wanted = 0;
  for (const LabelRegion& region : regions) {
    meshed += region.mesh_volume;
    wanted += region.voxel_volume;
  }
  if (meshed < least * wanted)
    throw InputError(
        options.name,
        fmt::format("the mesh holds only {:.2g} % of the labels' volume, as parts thinner than an element "
                    "are lost; expected more elements, or --labels without thin parts",
                    100 * meshed / wanted));
}

std::vector<std::string> region_warnings(const std::vector<LabelRegion>& regions) {
  std::vector<std::string> words;
  for (const LabelRegion& r : regions) {
    const double change = r.mesh_volume / r.voxel_volume - 1;
    const std::string who = fmt::format("label {} ({})", r.label, r.name);
    if (r.voxels == 1) words.push_back(who + " is a single voxel");
    if (r.touches_border)
      words.push_back(who + " touches the border of the volume: the organ may be cut off there");
    if (r.elements == 0)
      words.push_back(who + " has no element, it is smaller than they are; more elements may keep it");
    else if (std::abs(change) > 0.05)
      words.push_back(
          fmt::format("{} has {:.0f} % {} volume than its voxels; more elements follow it more closely", who,
                      100 * std::abs(change), change < 0 ? "less" : "more"));
  }
  return words;
}

TetMesh assembled(LabelledTets& made, const std::vector<LabelRegion>& regions, double scale) {
  TetMesh mesh{.nodes = std::move(made.nodes), .tets = std::move(made.tets), .groups = {}};
  for (Vec3& node : mesh.nodes) node *= scale;
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    if (tet_volume(mesh, t) < 0) std::swap(mesh.tets[t][2], mesh.tets[t][3]);
    mesh.element_groups[regions[static_cast<std::size_t>(made.subdomain[t]) - 1].name].push_back(
        static_cast<TetIndex>(t));
  }
  made.tets = mesh.tets;
  return mesh;
}

}  // namespace

std::string_view name(LabelMeshStep step) {
  return name_in<LabelMeshStep::compare>(
      {"looking for the size of the tetrahedra", "moving nodes of flat tetrahedra",
       "removing flat tetrahedra", "comparing with the voxels"},
      step);
}

TetMesh mesh_labels(const LabelVolume& volume, const LabelMeshOptions& options, LabelMeshReport& report,
                    const std::function<void(const LabelMeshProgress&)>& show) {
  report.regions = wanted_regions(volume, options);
  const std::vector<int> subdomain = subdomains(volume, report.regions);
  const LabelDomain domain(volume, subdomain);
  const Surface voxels = voxel_surface(volume, {subdomain.begin(), subdomain.end()});
  const double limit = options.time_limit.value_or(default_time_limit(options.elements));
  const SharedValue<LabelTold> told;
  const auto deadline =
      std::chrono::steady_clock::now() + std::chrono::milliseconds(static_cast<std::int64_t>(1e3 * limit));
  const auto tick = [&] {
    if (show) show({.step = static_cast<LabelMeshStep>((*told).step.load()), .meshes = (*told).meshes});
  };
  const ChildOutcome outcome = run_apart({.deadline = deadline, .tick = tick}, [&](int out) {
    return make_in_child(out, domain, voxels, options, limit, *told);
  });
  if (outcome.end != ChildOutcome::End::exited || outcome.code != 0) fail(outcome, options, limit);
  Made made = received(outcome.data);
  check_count(made.mesh.tets.size(), options);
  if (has_flat_tets(made.mesh))
    throw InputError(options.name,
                     "the mesher left flat tetrahedra in three meshes; expected another number of "
                     "elements, or --labels without parts that touch in single voxels");
  Box box{.low = made.mesh.nodes[0], .high = made.mesh.nodes[0]};
  for (const Vec3& x : made.mesh.nodes) box.low = box.low.cwiseMin(x), box.high = box.high.cwiseMax(x);
  const double scale = options.length ? *options.length / box.size().maxCoeff() : 1;
  TetMesh mesh = assembled(made.mesh, report.regions, scale);
  measure(mesh, made.mesh, volume, domain, scale, report.regions);
  report.hausdorff = scale * made.hausdorff;
  check_volume(report.regions, options);
  report.warnings = region_warnings(report.regions);
  return mesh;
}

Surface voxel_surface(const LabelVolume& volume, const std::vector<char>& wanted) {
  Surface surface;
  std::unordered_map<std::size_t, NodeIndex> number;
  const std::int64_t n = volume.size[0], m = volume.size[1], l = volume.size[2];
  const auto is_wanted = [&](std::int64_t i, std::int64_t j, std::int64_t k) {
    return i >= 0 && j >= 0 && k >= 0 && i < n && j < m && k < l && wanted[volume.voxels[volume.at(i, j, k)]];
  };
  const auto corner = [&](const std::array<std::int64_t, 3>& at) {
    const auto key = static_cast<std::size_t>(at[0] + (n + 1) * (at[1] + (m + 1) * at[2]));
    const auto [found, is_new] = number.emplace(key, static_cast<NodeIndex>(surface.nodes.size()));
    if (is_new) {
      const Vec3 index(static_cast<double>(at[0]), static_cast<double>(at[1]), static_cast<double>(at[2]));
      surface.nodes.push_back(volume.position(index - Vec3::Constant(0.5)));
    }
    return found->second;
  };
  for (std::int64_t k = 0; k < l; ++k)
    for (std::int64_t j = 0; j < m; ++j)
      for (std::int64_t i = 0; i < n; ++i) {
        if (!is_wanted(i, j, k)) continue;
        for (std::size_t d = 0; d < 3; ++d)
          for (const std::int64_t side : {0, 1}) {
            std::array<std::int64_t, 3> at{i, j, k}, other = at;
            other[d] += 2 * side - 1;
            if (is_wanted(other[0], other[1], other[2])) continue;
            at[d] += side;
            const std::size_t e = (d + 1) % 3, f = (d + 2) % 3;
            std::array<NodeIndex, 4> quad;
            for (std::size_t c = 0; c < 4; ++c) {
              std::array<std::int64_t, 3> to = at;
              to[e] += c == 1 || c == 2;
              to[f] += c >= 2;
              quad[side ? c : 3 - c] = corner(to);
            }
            surface.triangles.push_back({quad[0], quad[1], quad[2]});
            surface.triangles.push_back({quad[0], quad[2], quad[3]});
          }
      }
  return surface;
}

}  // namespace forefeel
