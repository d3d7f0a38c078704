#include "apps/offline/forces_csv.hpp"

#include "apps/console/outputs.hpp"
#include "apps/offline/offline_bars.hpp"
#include "geometry/common/field.hpp"
#include "geometry/common/output_file.hpp"

namespace forefeel {
namespace {

struct ForceRow {
  const Vec3& at;
  const Evaluation& found;
  std::size_t i;  // of the point
};

std::vector<Field<ForceRow>> force_columns(bool barred, bool of_jets, const std::string& value = {}) {
  using R = ForceRow;
  std::vector<Field<R>> columns{{"x,y,z", "m", "position", [](Cells& o, const R& r) { put(o, r.at); }},
                                {"fx,fy,fz", "N", "approximated force of the body on the tip",
                                 [](Cells& o, const R& r) { put(o, r.found.made.forces[r.i]); }},
                                {"label", "", "coverage there: safe, sparse, gap or blank",
                                 [](Cells& o, const R& r) { put(o, r.found.made.labels[r.i]); }}};
  if (!value.empty())
    columns[1] = {value, "", "approximated value",
                  [](Cells& o, const R& r) { put(o, r.found.made.forces[r.i].x()); }};
  if (of_jets)
    columns.push_back({"trusted", "", "with --data jet: 1 where its jets are within their trust, else 0",
                       [](Cells& o, const R& r) { o.flag(r.found.made.trusted[r.i]); }});
  if (barred)
    columns.push_back({"bar90,bar95,bar99", "N", bar_meaning,
                       [](Cells& o, const R& r) { o.vector(r.found.bars->at[r.i]); }});
  return columns;
}

}  // namespace

void write_forces(const std::string& file, const std::vector<Vec3>& points, const Evaluation& found,
                  const std::string& value) {
  const std::vector<Field<ForceRow>> columns =
      force_columns(found.bars.has_value(), !found.made.trusted.empty(), value);
  OutputFile out(file);
  out.write(header_of<ForceRow>(columns));
  for (std::size_t i = 0; i < points.size(); ++i)
    out.write(csv_row<ForceRow>(columns, {points[i], found, i}));
  out.commit();
}

DeclaredTable forces_output() {
  return {"forces.csv", "What evaluate writes with -o.", declared<ForceRow>(force_columns(true, true))};
}

}  // namespace forefeel
