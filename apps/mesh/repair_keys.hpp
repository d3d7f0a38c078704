#pragma once
// What mesh --json says about the repair of a surface.

#include "apps/console/document_keys.hpp"
#include "geometry/meshing/surface.hpp"

namespace forefeel {

const JsonKeys<RepairReport>& repair_keys();

}  // namespace forefeel
