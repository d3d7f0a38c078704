#pragma once
// How a model is made: kernel phi(r) = r^k (linear k = 1, cubic 3, quintic 5), data, number of neighbours n. With data
// `jet` the model blends the energy jets of n states (jet_set.hpp); of states without jets it is made as with
// force+stiffness.

#include <cstddef>
#include <string_view>

#include "geometry/common/tolerance.hpp"

namespace forefeel {

enum class Kernel { linear, cubic, quintic };
enum class Data { force, force_and_stiffness, jet };
enum class Select { label, nearest };
std::string_view name(Kernel kernel);
std::string_view name(Data data);  // "force", "force+stiffness", "jet"
std::string_view name(Select select);

struct ModelOptions {
  Kernel kernel = Kernel::cubic;
  Data data = Data::force;
  std::size_t neighbours = 100;  // n
  Select select = Select::label;
  // The ridge (nugget), >= 0, for noisy states: added to the diagonal of the kernel, in units of phi(radius of the
  // set).
  double ridge = 0;
  Tolerance tolerance = {};  // error of a jet up to which a state confirms it
  double length = 0;  // distance between states, used if the set itself does not show it [m]; 0: unknown
};

std::size_t usual_neighbours(Data data);  // n where it is not given: 100, 25 and 8
inline constexpr std::size_t most_jets = 64;

// The options with no more neighbours than there can be states (but at least uncapped_neighbours, set_sizes.hpp). The
// models are the same; their buffers are smaller. Throws InputError("model.neighbours", ...) if the matrix of one model
// would take more than a gigabyte.
ModelOptions for_states(ModelOptions options, std::size_t states);

}  // namespace forefeel
