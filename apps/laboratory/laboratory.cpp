#include "apps/laboratory/laboratory.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "apps/cache/cache_folder.hpp"
#include "apps/console/console.hpp"
#include "apps/console/json.hpp"
#include "apps/picture/page.hpp"
#include "apps/picture/plot.hpp"
#include "apps/scene_input/scene_session.hpp"
#include "geometry/common/error.hpp"
#include "geometry/common/output_file.hpp"
#include "geometry/common/quantiles.hpp"
#include "solver/lattice/cached_lattice.hpp"

namespace forefeel {

namespace fs = std::filesystem;

Laboratory::Laboratory(const Globals& globals, const std::string& scene)
    : globals_(globals),
      scene_(scene.empty() ? built_in_scene(globals.set) : load_scene(scene, globals.set)),
      built_in_(scene.empty()) {
  for (const std::string& warning : scene_.source.warnings) warn(globals, warning);
}

std::vector<State> Laboratory::lattice_states(const Box& box, double h, const ShowShare& show) {
  return cached_lattice_states(
      scene_.body, scene_.identity,
      {.spacing = h, .box = box, .threads = globals_.threads, .folder = cache_folder()},
      {.progress =
           [&](std::size_t done, std::size_t total) {
             if (show)
               show(static_cast<double>(done) / static_cast<double>(total),
                    fmt::format("{} of {} states", done, total));
           },
       .damaged = [&](const std::string& message) { warn(globals_, message); }});
}

const std::shared_ptr<ReferenceService>& Laboratory::service() {
  if (service_) return service_;
  service_ = std::make_shared<ReferenceService>(reference_options(session_input()), globals_.threads);
  if (service_->damage()) warn(globals_, *service_->damage());
  return service_;
}

std::vector<State> Laboratory::references(std::span<const Vec3> at, const ShowShare& show) {
  ReferenceService& solver = *service();
  for (const Vec3& x : at) solver.request(x);
  std::vector<State> states;
  for (const Vec3& x : at) {
    states.push_back(solver.get(x));
    if (show)
      show(static_cast<double>(states.size()) / static_cast<double>(at.size()),
           fmt::format("{} of {} tight solves", states.size(), at.size()));
  }
  return states;
}

SessionInput Laboratory::session_input() const {
  SessionInput input = forefeel::session_input(scene_);
  input.touched.displacements = false;
  input.references = service_;
  return input;
}

Mat3 lattice_frame(const Vec3& inward) {
  Eigen::Index axis = 0;
  inward.cwiseAbs().maxCoeff(&axis);
  Mat3 frame = Mat3::Zero();
  frame(axis, 0) = inward[axis] < 0 ? -1 : 1;
  frame((axis + 1) % 3, 1) = 1;
  frame((axis + 2) % 3, 2) = 1;
  return frame;
}

nlohmann::ordered_json quantiles_json(const std::vector<double>& values) {
  nlohmann::ordered_json object;
  object["p50"] = number(quantile_of(values, 0.5));
  object["p95"] = number(quantile_of(values, 0.95));
  object["max"] = number(quantile_of(values, 1));
  return object;
}

void write_text(const fs::path& file, const std::string& text) {
  OutputFile out(file);
  out.write(text);
  out.commit();
}

const char* const plot_style = R"(
set border 3 lc rgb '#8a8a8a' lw 0.8
set tics nomirror out scale 0.5 textcolor rgb '#3a3a3a'
set grid lc rgb '#e4e1da' lw 0.7
)";

const char* line_colour(std::size_t index) {
  constexpr const char* colours[] = {"#d55e00", "#0072b2", "#009e73", "#cc79a7",
                                     "#e69f00", "#56b4e9", "#1b1b1b", "#8a8a8a"};
  return colours[index % 8];
}

std::string draw_into(const fs::path& folder, const LaboratoryPicture& picture) {
  const std::optional<std::string> svg =
      draw_svg(picture.name, picture.width, picture.height, picture.script);
  if (!svg) return "<p class=\"note\">A picture is missing: gnuplot was not found or failed.</p>\n";
  write_text(folder / (picture.name + ".svg"), *svg + "\n");
  return fmt::format("<figure>{}<figcaption>{}</figcaption></figure>\n", *svg, html_escaped(picture.caption));
}

std::string html_table(const std::vector<std::vector<std::string>>& rows) {
  std::string html = "<table>";
  for (std::size_t i = 0; i < rows.size(); ++i) {
    html += "<tr>";
    for (std::size_t j = 0; j < rows[i].size(); ++j) {
      const bool head = i == 0;
      const bool figure = j > 0 && !rows[i][j].empty() &&
                          std::string_view("0123456789+-").find(rows[i][j][0]) != std::string_view::npos;
      html += head ? "<th>" : figure ? "<td class=\"n\">" : "<td>";
      html += html_escaped(rows[i][j]) + (head ? "</th>" : "</td>");
    }
    html += "</tr>\n";
  }
  return html + "</table>\n";
}

}  // namespace forefeel
