#include "apps/scene/scene_tolerance.hpp"

#include "apps/scene/scene_declared.hpp"
#include "apps/scene/scene_table.hpp"

namespace forefeel {

std::optional<Tolerance> read_tolerance(const SceneTable& state_space) {
  if (!state_space.has("tolerance")) return {};
  if (state_space.holds_text("tolerance")) {
    const std::optional<Tolerance> tolerance = tolerance_from(*state_space.text("tolerance"));
    if (!tolerance || !tolerance->newtons)
      throw state_space.wrong("tolerance", "a share of the force above 0, or newtons above 0 as \"0.07 N\"");
    return tolerance;
  }
  Tolerance tolerance;
  tolerance.value = *state_space.number("tolerance", positive());
  return tolerance;
}

std::optional<Tolerance> written_tolerance(const std::filesystem::path& file,
                                           std::span<const std::string> overrides) {
  const SceneDocument document = SceneDocument::read(file, overrides);
  return read_tolerance(document.root(scene_sections()).sub("state_space", state_space_rows().names()));
}

}  // namespace forefeel
