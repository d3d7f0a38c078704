#pragma once
// A scene file as input of a program of one's own:
//
//   #include <forefeel/scene.hpp>   // find_package(forefeel COMPONENTS command), target forefeel::command
//
//   const forefeel::SceneInput scene = forefeel::read_scene("organ.toml");
//   forefeel::StateSpace space(scene.input.touched.space);
//   forefeel::Solver solver(scene.input.touched.body);
//
// A complete program: apps/examples/own_loop.cpp.

#include <filesystem>
#include <string>
#include <vector>

#include "scheduling/session/session_input.hpp"
#include "scheduling/session/session_options.hpp"

namespace forefeel {

struct SceneInput {
  SessionInput input;      // body, box and spacing of its states; no state is known yet
  SessionOptions options;  // of [session]; the model is options.model.fit
  std::vector<std::string> warnings;
};

// overrides: "key.path=value" as of --set. InputError names file, key and what was expected. A scene with
// contact.anywhere is refused: its field is solved first, by the command.
SceneInput read_scene(const std::filesystem::path& file, const std::vector<std::string>& overrides = {});

}  // namespace forefeel
