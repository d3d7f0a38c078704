#pragma once
// How a model is made: kernel phi(r) = r^k (linear k = 1, cubic 3, quintic 5), data, number of neighbours n. With data
// `jet` the model blends the energy jets of n states (jet_set.hpp); of states without jets it is made as with
// force+stiffness.

#include <cstddef>
#include <optional>
#include <string_view>

#include "geometry/common/types.hpp"

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
  // Error of a jet up to which a state confirms it: a share of the force, which counts as at least `floor` [N].
  double tolerance = 0.07, floor = 0.05;
  double length = 0;  // distance between states, used if the set itself does not show it [m]; 0: unknown
};

std::size_t usual_neighbours(Data data);  // n where it is not given: 100, 25 and 8
inline constexpr std::size_t most_jets = 64;

// The options with no more neighbours than there can be states (but at least uncapped_neighbours). The models are the
// same; their buffers are smaller. Throws InputError("model.neighbours", ...) if the matrix of one model would take
// more than a gigabyte.
ModelOptions for_states(ModelOptions options, std::size_t states);

// A Gaussian process of measured forces in place of a model (approx/measured). r(t): exp(-t^2 / 2), and Matern's with
// 5/2 and 3/2: fields with two and with one derivative.
enum class Smoothness { gaussian, matern52, matern32 };
std::string_view name(Smoothness smoothness);  // "gaussian", "matern52", "matern32"

struct FieldLaw {
  Smoothness smoothness = Smoothness::gaussian;
  double length = 0, amplitude = 0, noise = 0;  // l [m], a [N], sigma [N]
};

// A thin plate spline (approx/measured/thin_plate.hpp). amplitude 0: none.
struct SplineLaw {
  double length = 0, amplitude = 0, noise = 0;  // [m], [N], sigma [N]
};

struct FieldOptions {
  FieldLaw law = {};
  FieldLaw doubt = {};               // law of the deviation (force_field.hpp); length 0: `law`
  Mat3 stretch = Mat3::Identity();   // A of `doubt` (measured/field_law.cpp)
  SplineLaw spline = {};             // blended with the process (force_field.hpp)
  double stiffest = 0;               // S [N/m] (force_field.hpp)
  bool stated = false;               // S was given: S E is not held by the bound of the force
  std::size_t neighbours = 0;        // rows of each place; 0: all
  std::size_t box = 1;               // neighbouring rows averaged to one, of all rows
  bool even = false;                 // of heaps only the few rows that count (geometry/states/heaps.hpp)
  FieldLaw rough = {};               // the likeliest of Matern's laws with 3/2
  bool local = false;                // the law is sought anew among the rows of each place
  std::optional<double> noise = {};  // known sigma [N]
};

// Of measured states; unknown where not given.
struct KnownNoise {
  std::optional<double> force = {};     // deviation of one component of one force [N]
  std::optional<double> position = {};  // of one coordinate [m]
};

// Sizes of the neighbour sets of a model (neighbours.hpp).

// Neighbour count for sets with weights. With fewer states, one state that enters or leaves would determine the slope
// of the force, however small its weight. (A single neighbour needs no weight.)
constexpr std::size_t weighted_neighbours(const ModelOptions& options) {
  const std::size_t n = options.neighbours, least = options.data == Data::force ? 20 : 16;
  return options.select == Select::label && n > 1 && n < least ? least : n;
}
// Neighbour count for sets without weights. Without stiffness, fewer states hardly determine the polynomial;
// the force would then jump by more than the JND (just noticeable difference) where a safe region ends.
constexpr std::size_t nearest_neighbours(const ModelOptions& options) {
  const std::size_t n = options.neighbours, least = options.data == Data::force ? 20 : 1;
  return options.select == Select::label && n > 1 && n < least ? least : n;
}
// Additional neighbours between two sides of a gap; without them each side would have about half of n.
constexpr std::size_t bridging_neighbours(const ModelOptions& options) {
  const std::size_t n = weighted_neighbours(options);
  return options.select == Select::label && n > 1 ? (n < 32 ? n : 32) : 0;
}
constexpr std::size_t most_neighbours(const ModelOptions& options) {
  return weighted_neighbours(options) + weighted_neighbours(options) / 6 + bridging_neighbours(options);
}
// Number of auxiliary places around a set with weights. Their data are the affine fit of the set, with a small weight.
// So a polynomial term that a single new state determines also enters gradually. (With stiffness, a state alone
// determines the linear terms.)
constexpr std::size_t affine_places(const ModelOptions& options) {
  const bool determined = options.data == Data::force_and_stiffness && options.kernel == Kernel::cubic;
  return options.select == Select::label && !determined ? 10 : 0;
}

// Least number of neighbours that for_states() allows: smaller sets are made by other rules.
constexpr std::size_t uncapped_neighbours = 32;

}  // namespace forefeel
