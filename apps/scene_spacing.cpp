#include "apps/scene_spacing.hpp"

#include <fmt/format.h>

#include <cmath>
#include <fstream>

#include "apps/sha256.hpp"
#include "geometry/error.hpp"
#include "geometry/output_file.hpp"
#include "solver/revision.hpp"

namespace forefeel {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr std::int64_t rule = 1;  // of choosing; a new number makes what was kept before count for nothing

fs::path file_of(const BodyIdentity& identity, const AutoSpacingOptions& options, const fs::path& folder) {
  if (folder.empty()) return {};
  Sha256 hash;
  hash.add(rule).add(solver_revision());
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
  for (const double x :
       {c.safe_spread, c.safe_cone_radius, c.safe_angle_deg, options.tolerance, options.floor})
    hash.add(x);
  hash.add(static_cast<std::int64_t>(options.positions)).add(static_cast<std::int64_t>(options.least_safe));
  return folder / (hash.hex().substr(0, 32) + ".spacing.json");
}

Json to_file(const SpacingChoice& c) {
  const auto number = [](double v) { return std::isfinite(v) ? Json(v) : Json(nullptr); };
  return {{"spacing", c.spacing}, {"p95", number(c.p95)}, {"max", number(c.max)}, {"safe", c.safe},
          {"states", c.states},   {"solves", c.solves},   {"holds", c.holds}};
}

// Nothing where the file is missing, torn or of another form.
bool read_kept(const fs::path& file, SpacingChoice& choice) {
  std::ifstream in(file);
  if (file.empty() || !in) return false;
  const Json kept = Json::parse(in, nullptr, false);
  if (!kept.is_object()) return false;
  try {
    const auto number = [&](const char* key) {
      return kept.at(key).is_null() ? unknown : kept.at(key).get<double>();
    };
    choice.spacing = kept.at("spacing").get<double>();
    choice.p95 = number("p95");
    choice.max = number("max");
    choice.safe = kept.at("safe").get<std::size_t>();
    choice.states = kept.at("states").get<std::size_t>();
    choice.solves = kept.at("solves").get<std::size_t>();
    choice.holds = kept.at("holds").get<bool>();
  } catch (const Json::exception&) {
    return false;
  }
  choice.kept = true;
  return choice.spacing > 0;
}

}  // namespace

SpacingChoice automatic_spacing(const std::shared_ptr<const Body>& body, const BodyIdentity& identity,
                                const AutoSpacingOptions& options, const fs::path& folder) {
  SpacingChoice choice;
  choice.tolerance = options.tolerance;
  const fs::path file = file_of(identity, options, folder);
  if (read_kept(file, choice)) return choice;
  const AutoSpacingReport report = choose_spacing(body, options);
  const AutoSpacingTrial& last = report.trials.back();
  choice = {.spacing = report.spacing,
            .tolerance = options.tolerance,
            .p95 = last.p95,
            .max = last.max,
            .safe = last.safe,
            .states = last.states,
            .solves = report.solves,
            .holds = report.holds,
            .kept = false};
  if (file.empty()) return choice;
  try {
    OutputFile out(file);
    out.write(to_file(choice).dump(2) + "\n");
    out.commit();
  } catch (const InputError&) {  // it is worked out again next time
  }
  return choice;
}

std::string in_words(const SpacingChoice& c) {
  return fmt::format(
      "spacing \"auto\": {:.4g} mm; at {} safe positions the error is at most {:.2g} % (asked: {:g} %), {} "
      "solves{}",
      1e3 * c.spacing, c.safe, 100 * c.max, 100 * c.tolerance, c.solves, c.kept ? ", kept from before" : "");
}

Json to_json(const SpacingChoice& c) {
  Json document = to_file(c);
  document["tolerance"] = c.tolerance;
  return document;
}

}  // namespace forefeel
