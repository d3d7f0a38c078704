#pragma once
// How a model is made: kernel phi(r) = r^k (linear k = 1, cubic 3, quintic 5), data, number of neighbours n.

#include <cstddef>
#include <string_view>

namespace forefeel {

enum class Kernel { linear, cubic, quintic };
enum class Data { force, force_and_stiffness };
enum class Select { label, nearest };
std::string_view name(Kernel kernel);
std::string_view name(Data data);  // "force", "force+stiffness"
std::string_view name(Select select);

struct ModelOptions {
  Kernel kernel = Kernel::cubic;
  Data data = Data::force;
  std::size_t neighbours = 100;  // n
  Select select = Select::label;
  // The ridge (nugget), >= 0, for noisy states: added to the diagonal of the kernel, in units of phi(radius of the
  // set).
  double ridge = 0;
  double length = 0;  // distance between states, used if the set itself does not show it [m]; 0: unknown
};

// The options with no more neighbours than there can be states (but at least uncapped_neighbours, set_sizes.hpp). The
// models are the same; their buffers are smaller. Throws InputError("model.neighbours", ...) if the matrix of one model
// would take more than a gigabyte.
ModelOptions for_states(ModelOptions options, std::size_t states);

}  // namespace forefeel
