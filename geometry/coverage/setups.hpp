#pragma once
// The situations of the paper's Fig. 1 and their like as sets of states (positions only), for tests, examples and
// benches. A slab of full lattice occupies x <= 0; the HIP leaves it along +x.
//   full    no border: the lattice fills the box
//   sparse  beyond the slab the density of states descends: each layer keeps fewer lattice points
//   gap     a second slab begins at x = width; nothing is known between
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
  double width = 0.048;    // of the gap, or of what lies beyond the slab [m]
};

struct Setup {
  std::string name;
  std::vector<Vec3> states;
  Box box;  // slabs and what lies between or beyond
};

std::vector<std::string> setup_names();
Setup make_setup(std::string_view name, const SetupOptions& options = {});  // InputError lists the names

}  // namespace forefeel
