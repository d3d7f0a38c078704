#pragma once
// What the commands write, for `forefeel help outputs`: a table for each document and CSV file, made of the rows that
// write it (document_keys.hpp, geometry/common/field.hpp). Each function stands beside them.

#include <vector>

#include "geometry/common/declared.hpp"

namespace forefeel {

DeclaredTable solve_output();           // solve --json
DeclaredTable mesh_output();            // mesh --json
DeclaredTable generate_output();        // generate --json
DeclaredTable generate_sites_output();  // generate --json with contact.anywhere
DeclaredTable placement_output();       // generate --error --json
DeclaredTable evaluate_output();        // evaluate --json
DeclaredTable classify_sites_output();  // classify --json of states with sites
DeclaredTable labelled_sites_output();  // classify -o of states with sites
DeclaredTable evaluate_sites_output();  // evaluate --json with sites
DeclaredTable sited_forces_output();    // evaluate -o with sites
DeclaredTable forces_output();          // evaluate -o
DeclaredTable classify_output();        // classify --json
DeclaredTable coverage_output();        // classify -o with positions
DeclaredTable left_out_output();        // classify --bars -o NAME.vtu
DeclaredTable info_scene_output();      // info SCENE --json
DeclaredTable summary_output();         // summary.json of a session

}  // namespace forefeel
