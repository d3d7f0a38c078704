#pragma once
// The keys that commands print with --json, for `forefeel help outputs`. Each list is beside the code that prints the
// keys; tests/apps/test_json_keys.cpp compares it with what is printed. Dots join nested keys, "[]" is each entry of a
// list of objects, words in capitals stand for any name.

#include <vector>

#include "geometry/common/declared.hpp"

namespace forefeel {

std::vector<Declared> declared_solve_json();
std::vector<Declared> declared_mesh_json();       // of `mesh`, without --study
std::vector<Declared> declared_labels_json();     // of these, from a label volume alone
std::vector<Declared> declared_generate_json();   // without --error
std::vector<Declared> declared_placement_json();  // of generate --error
std::vector<Declared> declared_evaluate_json();   // without those of error bars

}  // namespace forefeel
