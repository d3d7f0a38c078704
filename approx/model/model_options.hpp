#pragma once
// How a model is made (kernel, data, number of neighbours), and how many centres it can then have.

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
  double ridge = 0;   // >= 0, on the kernel's diagonal in units of phi(radius of the set), for noisy states
  double length = 0;  // distance between states where the set itself does not tell [m]; 0: unknown
};

// n where members have weights: of fewer states one that comes or goes decides alone how steep the force is,
// however little it counts. (Of one neighbour there is nothing to weigh.)
constexpr std::size_t weighted_neighbours(const ModelOptions& options) {
  const std::size_t n = options.neighbours, least = options.data == Data::force ? 20 : 16;
  return options.select == Select::label && n > 1 && n < least ? least : n;
}
// n where they have not: without stiffness of fewer the polynomial is hardly determined, so that what takes over where
// a safe region ends would differ by more than the JND.
constexpr std::size_t nearest_neighbours(const ModelOptions& options) {
  const std::size_t n = options.neighbours, least = options.data == Data::force ? 20 : 1;
  return options.select == Select::label && n > 1 && n < least ? least : n;
}
// How many come in between two sides, each of which would have about half of n.
constexpr std::size_t bridging_neighbours(const ModelOptions& options) {
  const std::size_t n = weighted_neighbours(options);
  return options.select == Select::label && n > 1 ? (n < 32 ? n : 32) : 0;
}
constexpr std::size_t most_neighbours(const ModelOptions& options) {
  return weighted_neighbours(options) + weighted_neighbours(options) / 6 + bridging_neighbours(options);
}
// A set with weights is held by as many places about it that carry the affine fit of the set and count
// hardly: a polynomial term that one state more would determine alone comes in gradually too. (Stiffness
// determines a linear one.)
constexpr std::size_t affine_places(const ModelOptions& options) {
  const bool determined = options.data == Data::force_and_stiffness && options.kernel == Kernel::cubic;
  return options.select == Select::label && !determined ? 10 : 0;
}

// for_states() never caps below this many neighbours: smaller sets are made by other rules.
constexpr std::size_t uncapped_neighbours = 32;

// The options with no more neighbours than there can be states (at least uncapped_neighbours). The models are the
// same; their buffers are smaller. Throws InputError("model.neighbours", ...) if the matrix of one model would take
// more than a gigabyte.
ModelOptions for_states(ModelOptions options, std::size_t states);

}  // namespace forefeel
