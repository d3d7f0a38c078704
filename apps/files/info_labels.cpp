#include "apps/files/info_labels.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "apps/console/console.hpp"
#include "apps/console/document_keys.hpp"
#include "apps/console/json.hpp"
#include "geometry/segmentation/label_volume.hpp"

namespace forefeel {
namespace {

constexpr std::size_t most_shown = 255;  // labels; more are probably no labels

}  // namespace

int info_labels(const Globals& globals, const std::string& file) {
  const LabelVolume volume = read_label_volume(file);
  const Vec3 sizes = volume.axes.colwise().norm().transpose();
  std::vector<std::size_t> voxels(volume.values.size(), 0);
  for (const std::uint16_t at : volume.voxels) ++voxels[at];
  for (const std::string& warning : volume.warnings) warn(globals, file + ": " + warning);
  if (globals.json) {
    Json document{{"kind", "labels"},
                  {"voxels", {volume.size[0], volume.size[1], volume.size[2]}},
                  {"voxel_size", vector3(sizes)},
                  {"unit", volume.unit},
                  {"unit_given", volume.unit_given},
                  {"directions", volume.directions},
                  {"labels", Json::array()}};
    for (std::size_t i = 0; i < voxels.size(); ++i)
      document["labels"].push_back({{"label", volume.values[i]},
                                    {"voxels", voxels[i]},
                                    {"volume", static_cast<double>(voxels[i]) * volume.voxel_volume()}});
    document["warnings"] = volume.warnings;
    print_json(document);
  }
  answer(globals,
         fmt::format("{}: {} x {} x {} voxels of {:.3g} x {:.3g} x {:.3g} mm; lengths taken in {}{}", file,
                     volume.size[0], volume.size[1], volume.size[2], 1e3 * sizes[0], 1e3 * sizes[1],
                     1e3 * sizes[2], volume.unit, volume.unit_given ? "" : ", since the file names no unit"));
  if (!volume.directions.empty()) answer(globals, "  x, y, z: " + volume.directions);
  if (volume.values.size() > most_shown)
    warn(
        globals,
        fmt::format("{}: holds {} different values: a scan rather than labels, or an atlas; the first {} are "
                    "shown",
                    file, volume.values.size(), most_shown));
  for (std::size_t i = 0; i < std::min(voxels.size(), most_shown); ++i)
    answer(globals, fmt::format("  label {}: {} voxels, {:.4g} cm3{}", volume.values[i], voxels[i],
                                1e6 * static_cast<double>(voxels[i]) * volume.voxel_volume(),
                                volume.values[i] == 0 ? ", the background" : ""));
  return 0;
}

}  // namespace forefeel
