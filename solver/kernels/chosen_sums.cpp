#include "geometry/common/instruction_set.hpp"
#include "solver/kernels/site_sums.hpp"

namespace forefeel {

FOREFEEL_IN_EACH_SET(extern const SiteKernels site_kernels;)

const SiteKernels& site_kernels() {
  return FOREFEEL_CHOSEN(site_kernels);
}

}  // namespace forefeel
