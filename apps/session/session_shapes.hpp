#pragma once
// The shapes of `forefeel session`: options, files, and the printed summary. Without a rate above 0, none of these
// functions has an effect.

#include <filesystem>
#include <future>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "apps/session/session_arguments.hpp"
#include "scheduling/record/shape_files.hpp"
#include "scheduling/session/shaped_session.hpp"

namespace forefeel {

// A small view of the shapes of a run in its report: the surface of the body, turned with the pointer, over time.

// HTML with its own script and data; it needs no other file.
std::string shape_view(const ShapeLog& log, const ShapeSummary& summary);

// The scene's, with --shape-rate. An InputError names the place that gave the value.
ShapeOptions shape_options(const Scene& scene, const SessionArguments& given);

class SessionShapes {
 public:
  // InputError for a plan whose known states hold no displacements, or are of another body.
  SessionShapes(const ShapeOptions& options, const SessionPlan& plan, const SessionArguments& given);

  ShapedRun* wanted() { return run_ ? &*run_ : nullptr; }  // for run_session(); null: none
  std::vector<std::string> files() const;                  // in the run's folder
  // After the session. The series is written on a thread of its own.
  void begin_files(const std::filesystem::path& run);
  void finish_files(const std::filesystem::path& run);    // throws what could not be written
  std::shared_future<std::string> begin_picture() const;  // for the report; invalid without shapes
  void add_to(nlohmann::ordered_json& document) const;    // key `shape`
  std::optional<std::string> in_words() const;            // one line

 private:
  std::optional<ShapedRun> run_;
  std::future<void> series_;
};

}  // namespace forefeel
