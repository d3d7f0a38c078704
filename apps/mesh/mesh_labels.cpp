#include "apps/mesh/mesh_labels.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "apps/console/json.hpp"
#include "geometry/common/error.hpp"
#include "geometry/common/scanner.hpp"
#include "geometry/mesh/length_unit.hpp"
#include "geometry/segmentation/label_volume.hpp"

namespace forefeel {
namespace {

std::string taken_in_words(const LabelVolume& volume) {
  const Vec3 steps = 1e3 * volume.axes.colwise().norm().transpose();
  return fmt::format("{} x {} x {} voxels of {:.3g} x {:.3g} x {:.3g} mm; lengths taken in {}{}{}{}",
                     volume.size[0], volume.size[1], volume.size[2], steps[0], steps[1], steps[2],
                     volume.unit, volume.unit_given ? "" : ", since the file names no unit",
                     volume.directions.empty() ? "" : "; x, y, z: ", volume.directions);
}

// Lengths in another unit than the file's own.
void take_in(LabelVolume& volume, const std::string& unit, double metres) {
  volume.axes *= metres / volume.metres;
  volume.origin *= metres / volume.metres;
  volume.unit = unit, volume.metres = metres, volume.unit_given = true;
}

std::string in_words(const LabelMeshProgress& p) {
  return p.meshes == 0 ? std::string(name(p.step)) : fmt::format("{}: {} tried", name(p.step), p.meshes);
}

bool is_group_name(std::string_view name) {
  return !name.empty() && std::ranges::none_of(name, [](char c) { return c == '"' || c == '=' || c < ' '; });
}

}  // namespace

std::map<std::int64_t, std::string> parse_labels(const std::string& text) {
  std::map<std::int64_t, std::string> labels;
  for (std::size_t at = 0; at <= text.size();) {
    const std::size_t end = std::min(text.find(',', at), text.size());
    const std::string_view part = std::string_view(text).substr(at, end - at);
    at = end + 1;
    const std::size_t equals = std::min(part.find('='), part.size());
    const std::string name(trimmed(part.substr(std::min(equals + 1, part.size()))));
    std::int64_t label = 0;
    if (!parse_integer(trimmed(part.substr(0, equals)), label) || !is_group_name(name))
      throw InputError("--labels",
                       fmt::format("'{:.40}', expected LABEL=NAME, as in 1=liver,7=tumour", part));
    if (label == 0) throw InputError("--labels", "0 is the background, expected other labels");
    const bool known = std::ranges::any_of(labels, [&](const auto& of) { return of.second == name; });
    if (known || !labels.emplace(label, name).second)
      throw InputError("--labels", fmt::format("'{:.40}' gives a label or a name a second time", part));
  }
  return labels;
}

LabelBody body_of_labels(const std::string& file, LabelMeshOptions options, const std::string& unit,
                         Progress& progress) {
  LabelVolume volume = read_label_volume(file);
  if (const std::optional<double> metres = unit_of(unit))
    take_in(volume, unit, *metres);
  else if (!volume.unit_unknown.empty())
    throw InputError({.file = file},
                     fmt::format("its unit of length '{:.40}' is unknown, expected {}, or --unit",
                                 volume.unit_unknown, unit_names));
  options.name = file;
  LabelBody body{.mesh = {}, .report = {}, .unit = volume.metres, .taken = taken_in_words(volume)};
  body.mesh = mesh_labels(volume, options, body.report,
                          [&](const LabelMeshProgress& p) { progress.show(in_words(p)); });
  body.report.warnings.insert(body.report.warnings.begin(), volume.warnings.begin(), volume.warnings.end());
  return body;
}

const JsonKeys<LabelRegion>& label_keys() {
  using R = LabelRegion;
  static const JsonKeys<R> keys{
      {"label", "", "with a label volume: the number in it", &R::label},
      {"name", "", "of its group of elements", &R::name},
      {"elements", "", "tetrahedra", &R::elements},
      {"volume", "m^3", "of these", &R::mesh_volume},
      {"voxels", "", "in the volume", &R::voxels},
      {"voxel_volume", "m^3", "of these", &R::voxel_volume},
      {"parts", "", "connected parts of the voxels", &R::parts},
      {"touches_border", "", "true: the label reaches the border of the volume", &R::touches_border}};
  return keys;
}

void tell_labels(const Globals& globals, const LabelBody& body) {
  say(globals, body.taken);
  for (const LabelRegion& r : body.report.regions)
    say(globals,
        fmt::format(
            "label {} ({}): {} elements, {:.4g} cm3; its {} voxels in {} part{} {:.4g} cm3, {:+.2f} %",
            r.label, r.name, r.elements, 1e6 * r.mesh_volume, r.voxels, r.parts, r.parts == 1 ? "" : "s",
            1e6 * r.voxel_volume, 100 * (r.mesh_volume / r.voxel_volume - 1)));
  say(globals,
      fmt::format("Hausdorff distance to the faces of the voxels {:.3g} mm", 1e3 * body.report.hausdorff));
}

}  // namespace forefeel
