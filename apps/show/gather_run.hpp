#pragma once
// Reads the folder of a run: positions of the hand, forces sent, known states, shapes of the body.

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "apps/scene/scene_anywhere.hpp"
#include "apps/show/show_content.hpp"
#include "geometry/states/state_header.hpp"

namespace forefeel {

struct RunFolder {
  std::filesystem::path folder;
  std::vector<ShownState> states;  // with displacements where the run kept them
  BodyIdentity identity;           // empty if not known
  double spacing = unknown;        // [m]
  std::optional<Box> box;          // [m]
  ShownRun run;                    // without shapes
  MadeBy made_by;                  // from summary.json
};

bool is_run_folder(const std::filesystem::path& folder);  // holds frames.csv
// InputError for a missing or damaged frames.csv, dispatch.csv or states.csv.
RunFolder read_run(const std::filesystem::path& folder);

// Shapes at times of the run: those that it recorded (session.shape_rate); InputError if they are damaged or of another
// body. If it recorded none, shapes are fitted to the displacements of the states known at each time: a weighted
// least-squares fit, linear in position, of the nearest states and of rest. Empty if no state has displacements.
std::vector<ShownShape> shapes_of_run(const RunFolder& run, const ShownBody& body);

}  // namespace forefeel
