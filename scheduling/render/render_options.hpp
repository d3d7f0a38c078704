#pragma once
// The options of the safety rules (safety.hpp), and the settings of a render loop.

#include <limits>
#include <optional>
#include <string_view>

#include "approx/switch/relaxation.hpp"
#include "approx/switch/switch_options.hpp"

namespace forefeel {

enum class Passivity { observe, control };
std::string_view name(Passivity passivity);

struct SafetyOptions {
  double force_limit = 12;     // that of an omega.3 [N]; a lower limit of the device is used instead
  double slew_limit = 1000;    // [N/s]
  double ramp_seconds = 0.1;   // start-up [s]
  double stale_seconds = 0.5;  // watchdog [s]
  Passivity passivity = Passivity::observe;
  std::optional<double> coupling =
      {};  // control: largest stiffness rendered [N/m]; unset: that of the device
};

// Throws InputError with the key of an invalid value.
void check(const SafetyOptions& options);

// Of the passivity control (passivity.hpp).
struct PassivityOptions {
  Passivity mode = Passivity::observe;
  double coupling = std::numeric_limits<double>::infinity();     // K_c [N/m]
  double resolution = 0;                                         // r [m]
  double force_limit = std::numeric_limits<double>::infinity();  // [N]
  double recovery = 1;                                           // time constant with which gains rise [s]
};

struct RenderOptions {
  SwitchOptions switching = {};
  SafetyOptions safety = {};
  double frame = 1e-3;       // [s]
  Viscosity viscosity = {};  // of the body
  PassivityOptions passivity = {};
};

}  // namespace forefeel
