#pragma once
// The discretisation error of each body of a study (apps/scene/scene_mesh_error.hpp), measured after its
// sessions. The errors that the sessions report themselves are relative to solves on the same mesh.

#include <string>
#include <vector>

#include "apps/console/console.hpp"
#include "apps/study/planned_study.hpp"
#include "scheduling/study/cell_result.hpp"

namespace forefeel {

struct MeshFindings {
  // A line for each body. above: bodies whose discretisation error exceeds the error of their sessions (median of their
  // 95th percentiles).
  std::vector<std::string> above, others;
  std::vector<std::string> lines() const;  // those above first
};

// Fills the columns discretisation_error, discretisation_positions and discretisation_by of the cells. Bodies whose
// scene has session.discretisation_error = false are skipped.
MeshFindings measure_meshes(const Globals& globals, const PlannedStudy& planned,
                            std::vector<StudyCellResult>& cells);

}  // namespace forefeel
