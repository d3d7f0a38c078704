#pragma once
// `forefeel mesh` for a label volume: reads its options, makes the mesh, prints the report.

#include <map>
#include <string>

#include "apps/console/console.hpp"
#include "apps/console/document_keys.hpp"
#include "geometry/segmentation/label_mesh.hpp"

namespace forefeel {

// "1=liver,7=tumour" as label -> name; InputError for anything else, for a label or a name given twice.
std::map<std::int64_t, std::string> parse_labels(const std::string& text);

struct LabelBody {
  TetMesh mesh;
  LabelMeshReport report;
  double unit = 1e-3;  // of the file's lengths, as taken [m]
  std::string taken;   // as read: "120 x 120 x 80 voxels of 0.8 x 0.8 x 2 mm, lengths taken in mm"
};
// unit: name of the unit of the file's lengths; empty: its own.
LabelBody body_of_labels(const std::string& file, LabelMeshOptions options, const std::string& unit,
                         Progress& progress);

const JsonKeys<LabelRegion>& label_keys();  // of one label in mesh --json
void tell_labels(const Globals& globals, const LabelBody& body);

}  // namespace forefeel
