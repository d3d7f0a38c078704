#pragma once
// `spacing = "auto"` of a scene (scheduling/placement/auto_spacing.hpp), computed once per body, box, model
// and tolerance and kept in the cache folder; and state_space.tolerance, a share of the force (0.07) or a force in
// newtons ("0.07 N").

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>

#include "geometry/common/tolerance.hpp"
#include "geometry/states/state_file.hpp"
#include "scheduling/placement/auto_spacing.hpp"

namespace forefeel {

struct SpacingChoice {
  AutoSpacingTrial found;   // of the chosen spacing
  std::size_t solves = 0;   // of all trials
  double tolerance = 0.07;  // of the error [1]
  double allowed_share = 0.05, confidence = 0.95;
  bool holds = false;  // found.share_bound <= allowed_share
  bool kept = false;   // read from the cache folder; nothing was solved
};

// The values depend only on the arguments. If folder is empty, nothing is cached. Unless `quiet`, a progress line shows
// the spacing being tried.
SpacingChoice automatic_spacing(const std::shared_ptr<const Body>& body, const BodyIdentity& identity,
                                const AutoSpacingOptions& options, const std::filesystem::path& folder,
                                bool quiet);

std::string in_words(const SpacingChoice& choice);
nlohmann::ordered_json to_json(const SpacingChoice& choice);

class SceneTable;

// From the table [state_space]; nullopt if the key is missing. InputError for a value that is not a tolerance above 0.
std::optional<Tolerance> read_tolerance(const SceneTable& state_space);
// From a scene file with its overrides. Reads no other key.
std::optional<Tolerance> written_tolerance(const std::filesystem::path& file,
                                           std::span<const std::string> overrides);

}  // namespace forefeel
