#include "apps/study/study_meshes.hpp"

#include <fmt/format.h>

#include <cmath>
#include <map>
#include <utility>

#include "apps/scene/scene_mesh_error.hpp"
#include "geometry/common/counted.hpp"
#include "geometry/common/quantiles.hpp"

namespace forefeel {
namespace {

double usual_error(const std::vector<StudyCellResult>& cells, const std::vector<std::size_t>& among) {
  std::vector<double> errors;
  for (const std::size_t i : among)
    if (const double p95 = cells[i].number("error.p95"); std::isfinite(p95)) errors.push_back(p95);
  return errors.empty() ? unknown : median(std::move(errors));
}

void fill(StudyCellResult& cell, const MeshError& mesh) {
  cell.set("discretisation_error", column_value(mesh.error));
  cell.set("discretisation_low", column_value(mesh.low));
  cell.set("discretisation_high", column_value(mesh.high));
  cell.set("discretisation_positions", static_cast<std::uint64_t>(mesh.positions));
  cell.set("discretisation_by", measured_by(mesh));
}

}  // namespace

std::vector<std::string> MeshFindings::lines() const {
  std::vector<std::string> all = above;
  all.insert(all.end(), others.begin(), others.end());
  return all;
}

MeshFindings measure_meshes(const Globals& globals, const PlannedStudy& planned,
                            std::vector<StudyCellResult>& cells) {
  std::map<BodyIdentity, std::vector<std::size_t>> bodies;  // and their cells
  for (std::size_t i = 0; i < cells.size(); ++i)
    bodies[planned.scenes[planned.plan.cells[i].input].identity].push_back(i);
  Progress progress(globals, "study: the meshes themselves");
  MeshFindings found;
  std::size_t done = 0;
  for (const auto& [identity, among] : bodies) {
    progress.show(static_cast<double>(done) / static_cast<double>(bodies.size()),
                  fmt::format("{} of {}", done, bodies.size()));
    ++done;
    const Scene& scene = planned.scenes[planned.plan.cells[among.front()].input];
    if (!scene.session.judging.discretisation_error) continue;
    const MeshError mesh = MeshErrorTask(scene, MeshErrorTask::When::at_the_end).get();
    for (const std::size_t cell : among) fill(cells[cell], mesh);
    const double shown = usual_error(cells, among);
    const std::string where = bodies.size() > 1 ? " (" + counted(among.size(), "cell") + ")" : "";
    std::string line = discretisation_line(mesh, shown) + where;
    if (std::isfinite(shown))
      line += fmt::format("; the sessions show a p95 of {} (median over cells)", in_percent(shown));
    const bool felt = SessionSummary::Mesh{.error = mesh.error}.is_felt(shown);
    (felt ? found.above : found.others).push_back(std::move(line));
  }
  return found;
}

}  // namespace forefeel
