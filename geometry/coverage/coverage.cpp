#include "geometry/coverage/coverage.hpp"

#include "geometry/common/enum_names.hpp"

namespace forefeel {

std::string_view name(Label label) {
  return name_in<Label::blank>({"safe", "sparse", "gap", "blank"}, label);
}

}  // namespace forefeel
