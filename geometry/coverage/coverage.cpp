#include "geometry/coverage/coverage.hpp"

namespace forefeel {

std::string_view name(Label label) {
  switch (label) {
    case Label::safe:
      return "safe";
    case Label::sparse:
      return "sparse";
    case Label::gap:
      return "gap";
    case Label::blank:
      break;
  }
  return "blank";
}

}  // namespace forefeel
