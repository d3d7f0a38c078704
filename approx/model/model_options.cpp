#include "approx/model/model_options.hpp"

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

}  // namespace forefeel
