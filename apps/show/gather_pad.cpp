#include "apps/show/gather_pad.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

#include "solver/body/pad.hpp"

namespace forefeel {
namespace {

constexpr int most_parts = 64;  // of a side of a facet

// A facet of the surface, and the springs at its points.
struct Facet {
  std::uint32_t number = 0;
  std::array<Vec3, 3> corner;  // [m], as the pad's site
  Vec3 normal;
};

class Splitter {
 public:
  Splitter(const Pad& pad, const PadSurface& surface) : pad_(pad), surface_(surface) {
    out_.peak = pad_peak(pad);
  }

  // The parts of a facet on which springs act.
  void add(const Facet& facet) {
    double longest = 0;
    for (std::size_t i = 0; i < 3; ++i)
      longest = std::max(longest, (facet.corner[i] - facet.corner[(i + 1) % 3]).norm());
    const int n = std::clamp(static_cast<int>(std::ceil(8 * longest / pad_.radius)), 1, most_parts);
    std::map<std::array<int, 2>, NodeIndex> known;
    for (int i = 0; i < n; ++i)
      for (int j = 0; i + j < n; ++j) {
        add_part(facet, n, {{{i, j}, {i + 1, j}, {i, j + 1}}}, known);
        if (i + j + 1 < n) add_part(facet, n, {{{i + 1, j}, {i + 1, j + 1}, {i, j + 1}}}, known);
      }
  }
  ShownPad take() { return std::move(out_); }

 private:
  using Place = std::array<int, 2>;

  void add_part(const Facet& facet, int n, const std::array<Place, 3>& places,
                std::map<Place, NodeIndex>& known) {
    std::array<Vec3, 3> at;
    std::array<double, 3> weight{};
    for (std::size_t k = 0; k < 3; ++k) {
      const double a = double(places[k][0]) / n, b = double(places[k][1]) / n;
      at[k] = Vec3(1 - a - b, a, b);
      const Vec3 y = at[k][0] * facet.corner[0] + at[k][1] * facet.corner[1] + at[k][2] * facet.corner[2];
      weight[k] = pad_density(pad_, surface_, y, facet.normal) / out_.peak;
    }
    if (weight == std::array<double, 3>{}) return;
    Triangle part{};
    for (std::size_t k = 0; k < 3; ++k) {
      const auto [found, fresh] = known.try_emplace(places[k], static_cast<NodeIndex>(out_.facet.size()));
      part[k] = found->second;
      if (!fresh) continue;
      out_.facet.push_back(facet.number);
      out_.at.push_back(at[k]);
      out_.weight.push_back(weight[k]);
    }
    out_.triangles.push_back(part);
  }

  const Pad& pad_;
  const PadSurface& surface_;
  ShownPad out_;
};

}  // namespace

std::optional<ShownPad> shown_pad(const Body& body, const ShownBody& shown) {
  if (!body.pad) return {};
  std::map<Triangle, std::uint32_t> number;  // of each triangle of the surface, by its nodes in the mesh
  for (std::size_t t = 0; t < shown.triangles.size(); ++t) {
    const Triangle& own = shown.triangles[t];
    number[{shown.node[own[0]], shown.node[own[1]], shown.node[own[2]]}] = static_cast<std::uint32_t>(t);
  }
  const PadSurface surface = pad_surface(body.mesh, *body.pad);
  Splitter splitter(*body.pad, surface);
  for (const PadFacet& facet : surface.facets) {
    const auto corner = [&](std::size_t i) { return body.mesh.nodes[facet.corners[i]]; };
    const std::array<Vec3, 3> corners{corner(0), corner(1), corner(2)};
    const Vec3 normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalized();
    splitter.add({number.at(facet.corners), corners, normal});
  }
  return splitter.take();
}

namespace {

// Colours at the nodes of the surface. weight: by node of the mesh; a clamped node has none.
void colour_nodes(const std::map<NodeIndex, double>& weight, const ShownBody& shown, ShownPad& pad) {
  for (std::size_t t = 0; t < shown.triangles.size(); ++t) {
    const auto known = [&](NodeIndex own) { return weight.contains(shown.node[own]); };
    if (std::ranges::none_of(shown.triangles[t], known)) continue;
    Triangle part{};
    for (std::size_t i = 0; i < 3; ++i) {
      const NodeIndex own = shown.triangles[t][i];
      part[i] = static_cast<NodeIndex>(pad.facet.size());
      pad.facet.push_back(static_cast<std::uint32_t>(t));
      pad.at.push_back(Vec3::Unit(static_cast<int>(i)));
      pad.weight.push_back(known(own) ? weight.at(shown.node[own]) : 1);
    }
    pad.triangles.push_back(part);
  }
}

}  // namespace

std::string_view name(PadShade shade) {
  return shade == PadShade::springs ? "springs" : shade == PadShade::stiffness ? "stiffness" : "error";
}

std::optional<ShownPad> shown_stiffness(const std::vector<SurfaceStiffness>& map, const ShownBody& shown) {
  const std::optional<StiffnessRange> range = range_over(map, &SurfaceStiffness::alone);
  if (!range) return {};
  ShownPad pad;
  pad.shade = PadShade::stiffness;
  pad.least = range->least, pad.peak = range->greatest;
  std::map<NodeIndex, double> weight;
  const double span = std::max(range->greatest - range->least, 1e-12 * range->greatest);
  for (const SurfaceStiffness& at : map) weight[at.node] = (at.alone - range->least) / span;
  colour_nodes(weight, shown, pad);
  return pad;
}

std::optional<ShownPad> shown_error(const std::vector<SurfaceError>& map, double tolerance, double depth,
                                    const ShownBody& shown) {
  if (map.empty()) return {};
  ShownPad pad;
  pad.shade = PadShade::error;
  pad.peak = tolerance, pad.depth = depth;
  std::map<NodeIndex, double> weight;
  double area = 0, above = 0;
  for (const SurfaceError& at : map) {
    weight[at.node] = std::min(1.0, at.error / tolerance);
    area += at.area, above += at.error > tolerance ? at.area : 0;
  }
  pad.share = above / area;
  colour_nodes(weight, shown, pad);
  return pad;
}

}  // namespace forefeel
