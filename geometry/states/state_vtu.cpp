// States as a VTU point cloud: inline binary data. Values that no state has are left out. If only some states have a
// value, the others get NaN.

#include <algorithm>
#include <cmath>

#include "geometry/mesh/vtu_writer.hpp"
#include "geometry/states/state_file.hpp"
#include "geometry/states/state_outcome.hpp"

namespace forefeel {

void write_states_vtu(const std::filesystem::path& file, std::span<const State> states) {
  VtuWriter out(file, VtuData::base64);
  // value(state, k): component k of the array's value for that state.
  const auto array = [&]<class T>(T, const char* name, int width, auto&& value) {
    out.array<T>(name, states.size(), width, [&](std::size_t i, int k) { return value(states[i], k); });
  };
  // Left out if no state has a value.
  const auto known = [&](const char* name, int width, auto&& value) {
    const bool any = std::ranges::any_of(states, [&](const State& state) {
      for (int k = 0; k < width; ++k)
        if (!std::isnan(value(state, k))) return true;
      return false;
    });
    if (any) array(double{}, name, width, value);
  };
  out.begin(states.size(), states.size());
  const bool force = std::ranges::any_of(states, [](const State& s) { return !s.force.hasNaN(); });
  out.section("PointData", force ? "Vectors=\"force\"" : "");
  known("force", 3, [](const State& s, int k) { return s.force[k]; });
  known("stiffness", 9, [](const State& s, int k) { return s.stiffness(k / 3, k % 3); });
  known("site", 3, [](const State& s, int k) { return s.site[k]; });
  known("energy", 1, [](const State& s, int) { return s.energy; });
  known("spacing", 1, [](const State& s, int) { return s.spacing; });
  known("residual", 1, [](const State& s, int) { return s.solve.residual; });
  known("seconds", 1, [](const State& s, int) { return s.solve.seconds; });
  known("min_jacobian", 1, [](const State& s, int) { return s.solve.min_jacobian; });
  known("parent", 3, [](const State& s, int k) { return s.solve.parent[k]; });
  array(std::int32_t{}, "iterations", 1, [](const State& s, int) { return s.solve.iterations; });
  array(std::uint8_t{}, "status", 1, [](const State& s, int) { return static_cast<int>(outcome(s)); });
  array(std::uint8_t{}, "multivalued", 1, [](const State& s, int) { return s.solve.multivalued; });
  out.section("Points");
  array(double{}, "position", 3, [](const State& s, int k) { return s.at[k]; });
  out.vertices(states.size());
  out.finish();
}

}  // namespace forefeel
