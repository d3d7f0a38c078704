#include "geometry/coverage/setups.hpp"

#include <cmath>
#include <cstdint>

#include "geometry/common/error.hpp"

namespace forefeel {
namespace {

// A number in [0, 1) that depends on the lattice point alone: the states that a thinned layer keeps must not
// depend on their order.
double share(int i, int j, int k) {
  std::uint64_t x = static_cast<std::uint64_t>(i) * 0x9e3779b97f4a7c15ull +
                    static_cast<std::uint64_t>(j) * 0xbf58476d1ce4e5b9ull +
                    static_cast<std::uint64_t>(k) * 0x94d049bb133111ebull;
  x ^= x >> 31;
  x *= 0xd6e8feb86659fd93ull;
  x ^= x >> 32;
  return static_cast<double>(x >> 11) * 0x1p-53;
}

}  // namespace

std::vector<std::string> setup_names() {
  return {"full", "sparse", "gap", "blank"};
}

Setup make_setup(std::string_view name, const SetupOptions& options) {
  const bool full = name == "full", sparse = name == "sparse", gap = name == "gap";
  if (!full && !sparse && !gap && name != "blank")
    throw InputError("setup",
                     "\"" + std::string(name) + "\" is unknown, expected full, sparse, gap or blank");
  const int beyond = static_cast<int>(std::lround(options.width / options.spacing));
  const int last = full || sparse || name == "blank" ? beyond : beyond + options.depth;
  Setup setup{std::string(name), {}, {}};
  for (int k = -options.half_width; k <= options.half_width; ++k)
    for (int j = -options.half_width; j <= options.half_width; ++j)
      for (int i = -options.depth; i <= last; ++i) {
        const bool known = i <= 0 || full || (gap && i >= beyond) ||
                           (sparse && share(i, j, k) < 0.5 * (1 - static_cast<double>(i) / (beyond + 1)));
        if (known) setup.states.emplace_back(i * options.spacing, j * options.spacing, k * options.spacing);
      }
  const double side = options.half_width * options.spacing;
  setup.box = {Vec3(-options.depth * options.spacing, -side, -side),
               Vec3(last * options.spacing, side, side)};
  return setup;
}

}  // namespace forefeel
