#include "apps/sites/field_note.hpp"

#include <fmt/format.h>

#include "apps/console/console.hpp"

namespace forefeel {
namespace {

Json range_json(const std::optional<StiffnessRange>& range) {
  return range ? json_numbers({range->least, range->median, range->greatest}) : Json();
}

}  // namespace

FieldNote field_note(const Scene& scene, const FieldFound& found, const Globals& globals) {
  const SiteField& field = *found.field;
  const std::vector<SurfaceStiffness> map = palpation_map(field.rest(), *scene.body, globals.threads);
  return {.sites = field.size(),
          .spacing = field.options().spacing,
          .seconds = found.seconds,
          .kept = found.kept,
          .area = field.rest().map().free_area(),
          .with_pad = range_over(map, &SurfaceStiffness::with_pad),
          .alone = range_over(map, &SurfaceStiffness::alone)};
}

const JsonKeys<FieldNote>& field_keys() {
  using F = FieldNote;
  static const JsonKeys<F> keys{
      {"sites", "", "places of the surface whose jets at rest make the field", &F::sites},
      {"spacing", "m", "of the sites", &F::spacing},
      {"seconds", "s", "that making or reading it took", &F::seconds},
      {"kept", "", "true: it was read from the cache", &F::kept},
      {"area", "m^2", "of the surface that is not clamped", &F::area},
      {"stiffness", "N/m",
       "[least, median, greatest] over the surface's area, at rest, along the normal, with the pad",
       [](const F& f) { return range_json(f.with_pad); }},
      {"body_stiffness", "N/m", "the same of the body alone under the pad",
       [](const F& f) { return range_json(f.alone); }}};
  return keys;
}

std::vector<std::string> in_words(const FieldNote& note) {
  std::vector<std::string> lines{fmt::format("{} sites {:.3g} mm apart over {:.3g} cm2, {} in {:.3g} s",
                                             note.sites, 1e3 * note.spacing, 1e4 * note.area,
                                             note.kept ? "read from the cache" : "solved", note.seconds)};
  const auto add = [&](const std::optional<StiffnessRange>& range, const char* what) {
    if (range)
      lines.push_back(
          fmt::format("stiffness at rest along the normal, {}: {:.4g} to {:.4g} N/m, median {:.4g}", what,
                      range->least, range->greatest, range->median));
  };
  add(note.with_pad, "with the pad");
  add(note.alone, "body alone");
  return lines;
}

}  // namespace forefeel
