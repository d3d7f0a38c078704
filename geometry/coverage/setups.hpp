#pragma once
// Example sets of states (positions only), after the situations of the paper's Fig. 1; for tests, examples
// and benches. A slab of full lattice fills x <= 0; the HIP leaves it along +x.
//   full    the lattice fills the whole box
//   sparse  beyond the slab each layer keeps fewer lattice points than the one before
//   gap     a second slab begins at x = width; nothing is known between the two
//   blank   nothing is known beyond the slab

#include <string>
#include <string_view>
#include <vector>

#include "geometry/common/types.hpp"

namespace forefeel {

struct SetupOptions {
  double spacing = 0.006;  // h [m]
  int depth = 8;           // layers of a slab
  int half_width = 10;     // lattice steps to each side in y and z
  double width = 0.048;    // of the gap, or of the part beyond the slab [m]
};

struct Setup {
  std::string name;
  std::vector<Vec3> states;
  Box box;  // slabs, and the part between or beyond them [m]
};

std::vector<std::string> setup_names();
Setup make_setup(std::string_view name, const SetupOptions& options = {});  // InputError for other names

}  // namespace forefeel
