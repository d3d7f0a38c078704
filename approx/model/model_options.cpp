#include "approx/model/model_options.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "geometry/common/error.hpp"

namespace forefeel {

std::string_view name(Kernel kernel) {
  return kernel == Kernel::linear ? "linear" : kernel == Kernel::cubic ? "cubic" : "quintic";
}
std::string_view name(Data data) {
  return data == Data::force ? "force" : data == Data::force_and_stiffness ? "force+stiffness" : "jet";
}
std::size_t usual_neighbours(Data data) {
  return data == Data::force ? 100 : data == Data::force_and_stiffness ? 25 : 8;
}
std::string_view name(Select select) {
  return select == Select::label ? "label" : "nearest";
}
std::string_view name(Smoothness smoothness) {
  return smoothness == Smoothness::gaussian   ? "gaussian"
         : smoothness == Smoothness::matern52 ? "matern52"
                                              : "matern32";
}

namespace {

constexpr double most_bytes = 1e9;

double matrix_bytes(ModelOptions options, std::size_t neighbours) {
  options.neighbours = neighbours;
  const double rows_each = options.data == Data::force ? 1 : 4, spare = 1.125;
  const double rows =
      rows_each * spare * static_cast<double>(most_neighbours(options) + affine_places(options));
  return rows * rows * sizeof(double);
}

}  // namespace

ModelOptions for_states(ModelOptions options, std::size_t states) {
  const std::size_t asked = options.neighbours;
  options.neighbours = std::min(asked, std::max(states, uncapped_neighbours));
  if (matrix_bytes(options, options.neighbours) <= most_bytes) return options;
  std::size_t low = uncapped_neighbours, high = options.neighbours;  // low fits, high does not
  while (high - low > 1)
    (matrix_bytes(options, (low + high) / 2) <= most_bytes ? low : high) = (low + high) / 2;
  throw InputError("model.neighbours",
                   fmt::format("is {}, and there may be {} states: a model of so many takes {:.2g} GB, "
                               "expected at most {} neighbours",
                               asked, states, 1e-9 * matrix_bytes(options, options.neighbours), low));
}

}  // namespace forefeel
