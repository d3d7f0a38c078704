#include "approx/model/model_options.hpp"

namespace forefeel {

std::string_view name(Kernel kernel) {
  return kernel == Kernel::linear ? "linear" : kernel == Kernel::cubic ? "cubic" : "quintic";
}
std::string_view name(Data data) {
  return data == Data::force ? "force" : "force+stiffness";
}
std::string_view name(Select select) {
  return select == Select::label ? "label" : "nearest";
}

}  // namespace forefeel
