#include "apps/scene/scene_spacing.hpp"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "apps/console/console.hpp"
#include "apps/console/interrupt.hpp"
#include "apps/console/json.hpp"
#include "apps/scene/cache_folder.hpp"
#include "apps/scene/scene_declared.hpp"
#include "apps/scene/scene_table.hpp"
#include "geometry/common/counted.hpp"
#include "geometry/common/error.hpp"
#include "geometry/common/sha256.hpp"
#include "solver/kernels/revision.hpp"

namespace forefeel {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr std::int64_t spacing_rule =
    2;  // version of the rule of choice; a new number invalidates kept choices

fs::path file_of(const BodyIdentity& identity, const AutoSpacingOptions& options, const fs::path& folder) {
  if (folder.empty()) return {};
  Sha256 hash;
  hash.add(spacing_rule).add(solver_revision());
  for (const auto& [key, value] : identity) hash.add(key + "=" + value + "\n");
  for (const Vec3& corner : {options.box.low, options.box.high})
    for (const double x : corner) hash.add(x);
  const ModelOptions& m = options.model;
  hash.add(name(m.kernel))
      .add(name(m.data))
      .add(name(m.select))
      .add(static_cast<std::int64_t>(m.neighbours))
      .add(m.ridge);
  const CoverageOptions& c = options.coverage;
  for (const double x : {c.safe_spread, c.safe_cone_radius, c.safe_angle_deg, options.tolerance,
                         options.floor, options.allowed_share, options.confidence})
    hash.add(x);
  hash.add(static_cast<std::int64_t>(options.positions));
  return folder / (hash.hex().substr(0, 32) + ".spacing.json");
}

Json to_file(const SpacingChoice& c) {
  const auto number = [](double v) { return std::isfinite(v) ? Json(v) : Json(nullptr); };
  return {
      {"spacing", c.found.spacing}, {"p95", number(c.found.p95)}, {"max", number(c.found.max)},
      {"safe", c.found.safe},       {"above", c.found.above},     {"share_above_bound", c.found.share_bound},
      {"states", c.found.states},   {"solves", c.solves},         {"holds", c.holds}};
}

// False if the file holds something else.
bool take(const Json& kept, SpacingChoice& choice) {
  AutoSpacingTrial& found = choice.found;
  try {
    const auto number = [&](const char* key) {
      return kept.at(key).is_null() ? unknown : kept.at(key).get<double>();
    };
    found.spacing = kept.at("spacing").get<double>();
    found.p95 = number("p95");
    found.max = number("max");
    found.safe = kept.at("safe").get<std::size_t>();
    found.above = kept.at("above").get<std::size_t>();
    found.share_bound = kept.at("share_above_bound").get<double>();
    found.states = kept.at("states").get<std::size_t>();
    choice.solves = kept.at("solves").get<std::size_t>();
    choice.holds = kept.at("holds").get<bool>();
  } catch (const Json::exception&) {
    return false;
  }
  choice.kept = true;
  return choice.found.spacing > 0;
}

}  // namespace

SpacingChoice automatic_spacing(const std::shared_ptr<const Body>& body, const BodyIdentity& identity,
                                const AutoSpacingOptions& options, const fs::path& folder, bool quiet) {
  SpacingChoice choice;
  choice.tolerance = options.tolerance;
  choice.allowed_share = options.allowed_share;
  choice.confidence = options.confidence;
  const fs::path file = file_of(identity, options, folder);
  if (const std::optional<Json> kept = read_kept(file); kept && take(*kept, choice)) return choice;
  AutoSpacingOptions watched = options;
  watched.interrupted = &interrupt_flag();
  Globals globals;
  globals.quiet = quiet;
  Progress progress(globals, "spacing \"auto\"");
  watched.progress = [&](const AutoSpacingProgress& p) {
    progress.show(fmt::format("try {} of at most {}, {:.3g} mm: {} of {} {}", p.trial, p.trials,
                              1e3 * p.spacing, p.done, p.total, p.checking ? "tight solves" : "states"));
  };
  const AutoSpacingReport report = choose_spacing(body, watched);
  if (report.interrupted)
    throw Interrupted(
        "interrupted while the spacing was measured: nothing of it is kept, and nothing was written");
  choice.found = report.trials.back();
  choice.solves = report.solves;
  choice.holds = report.holds;
  keep(file, to_file(choice));
  return choice;
}

std::string in_words(const SpacingChoice& c) {
  const std::string solves = fmt::format("; {} solves{}", c.solves, c.kept ? ", kept from before" : "");
  if (c.found.safe == 0)
    return fmt::format(
        "spacing \"auto\": {:.4g} mm; too few positions of the box are safe on it to judge by{}",
        1e3 * c.found.spacing, solves);
  const std::string worst = std::isfinite(c.found.max) ? in_percent(c.found.max) : "without an equilibrium";
  return fmt::format(
      "spacing \"auto\": {:.4g} mm; of {} safe positions {} above {:g} % error (p95 {}, worst {}), so "
      "that with "
      "{:g} % confidence at most {} of what is safe is above it (allowed: {:g} %{}){}",
      1e3 * c.found.spacing, c.found.safe, c.found.above == 1 ? "1 is" : fmt::format("{} are", c.found.above),
      100 * c.tolerance, in_percent(c.found.p95), worst, 100 * c.confidence, in_percent(c.found.share_bound),
      100 * c.allowed_share, c.holds ? "" : ", does not hold", solves);
}

Json to_json(const SpacingChoice& c) {
  Json document = to_file(c);
  document["share_above"] = c.found.safe > 0
                                ? Json(static_cast<double>(c.found.above) / static_cast<double>(c.found.safe))
                                : Json();
  document["share_above_allowed"] = c.allowed_share;
  document["confidence"] = c.confidence;
  document["tolerance"] = c.tolerance;
  return document;
}

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
