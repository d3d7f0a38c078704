#pragma once
// The discretisation error of each body of a study (apps/scene/scene_mesh_error.hpp), measured after its
// sessions: what they show beside it is the error against solves on the same mesh.

#include <string>
#include <vector>

#include "apps/console/console.hpp"
#include "apps/study/planned_study.hpp"
#include "scheduling/study/cell_result.hpp"

namespace forefeel {

struct MeshFindings {
  // A line for each body: above the error of its sessions (median over them of the 95th percentile), or not.
  std::vector<std::string> above, others;
  std::vector<std::string> lines() const;  // those above first
};

// Fills the columns discretisation_error, discretisation_positions and discretisation_by of the cells. Bodies
// whose scene says session.discretisation_error = false are left out.
MeshFindings measure_meshes(const Globals& globals, const PlannedStudy& planned,
                            std::vector<StudyCellResult>& cells);

}  // namespace forefeel
