// forefeel replay RUN: renders a recorded run again and compares every force, bit by bit.

#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "apps/console/commands.hpp"
#include "apps/console/console.hpp"
#include "apps/console/json.hpp"
#include "apps/console/provenance.hpp"
#include "apps/scene/scene_anywhere.hpp"
#include "apps/scene/scene_session.hpp"
#include "geometry/common/counted.hpp"
#include "geometry/common/error.hpp"
#include "geometry/common/scanner.hpp"
#include "scheduling/render/frame_table.hpp"
#include "scheduling/session/input_replay.hpp"

namespace forefeel {
namespace {

namespace fs = std::filesystem;

fs::path inputs_of(const fs::path& given) {
  std::error_code error;
  const fs::path file = fs::is_directory(given, error) ? given / inputs_file_name : given;
  if (fs::exists(file, error)) return file;
  if (file == given) throw InputError({.file = given.string()}, "no such folder, expected that of a run");
  throw InputError({.file = file.string()},
                   "no such file, expected the record of a run (session.record = true in its scene)");
}

std::string in_words(const Vec3& force) {
  return fmt::format("{}, {}, {} N", force[0], force[1], force[2]);  // reads back to the same bits
}

std::string in_words(const ForceDifference& difference) {
  return fmt::format("first difference in frame {} ({:.3f} s), {} force: {} recorded, {} replayed",
                     difference.frame, difference.t, difference.sent ? "sent" : "rendered",
                     in_words(difference.recorded), in_words(difference.replayed));
}

nlohmann::ordered_json to_json(const ReplayReport& report, std::size_t rows) {
  nlohmann::ordered_json first;
  if (report.first)
    first = {{"frame", report.first->frame},
             {"t", number(report.first->t)},
             {"force", report.first->sent ? "sent" : "rendered"},
             {"recorded", vector3(report.first->recorded)},
             {"replayed", vector3(report.first->replayed)}};
  return {{"frames", report.frames},
          {"equal", report.equal},
          {"first_difference", first},
          {"seconds", number(report.seconds)},
          {"whole", report.whole},
          {"states", report.states},
          {"failed", report.failed},
          {"models", report.models},
          {"bytes", report.bytes},
          {"recorded_by", report.made_by},
          {"replayed_by", report.replayed_by},
          {"frames_csv_rows", rows}};
}

void tell(const Globals& globals, const ReplayReport& report, std::size_t rows) {
  answer(globals,
         fmt::format("{} of {} equal: {:.3f} s, {}, {}", report.equal, counted(report.frames, "frame"),
                     report.seconds, counted(report.states, "state"), counted(report.models, "model")));
  answer(globals,
         rows > 0
             ? fmt::format("compared: session.inputs, and the same positions and forces in {} of frames.csv",
                           counted(rows, "row"))
             : std::string("compared: session.inputs alone; there is no frames.csv beside it"));
  if (report.first) answer(globals, in_words(*report.first));
}

// The scene that the run's own summary names.
Scene recorded_scene(const fs::path& inputs) {
  const fs::path summary = inputs.parent_path() / "summary.json";
  if (std::error_code error; fs::is_regular_file(summary, error)) {
    const nlohmann::json document = nlohmann::json::parse(read_text_file(summary), nullptr, false);
    if (document.is_object() && document.contains("provenance"))
      if (std::optional<Scene> scene = scene_of(made_by(document["provenance"].dump())))
        return *std::move(scene);
  }
  throw InputError(
      {.file = inputs.string()},
      "is of a body that may be touched anywhere, and its scene was not found or has changed, expected "
      "--scene SCENE, with the --set of the run");
}

int run_replay(const Globals& globals, const std::string& run, const std::string& scene_file) {
  const fs::path file = inputs_of(run);
  Progress progress(globals, "replay");
  const auto touched = [&] {
    const Scene scene =
        scene_file.empty()
            ? recorded_scene(file)
            : load_scene_with_sites(scene_file, globals.set, {.spacing = false, .quiet = globals.quiet});
    SessionInput input = session_input(scene);
    touch_anywhere(scene, globals, input);
    return input.touched;
  };
  const ReplayReport report = replay_inputs(
      file, program_text(), [&](double t) { progress.show(fmt::format("{:.1f} s", t)); }, touched);
  // A record that does not replay says so itself.
  const std::size_t rows = report.first ? 0 : compare_frame_table(file.parent_path() / "frames.csv", file);
  if (!report.whole)
    warn(globals,
         fmt::format("{}: ends early, because the run was killed or its disk was full: {} "
                     "there, up to {:.3f} s",
                     file.string(), counted(report.frames, "frame is", "frames are"), report.seconds));
  if (report.made_by != report.replayed_by)
    warn(globals, fmt::format("recorded by {}, replayed by {}: forces may differ in their last bits",
                              report.made_by, report.replayed_by));
  if (globals.json)
    print_json(to_json(report, rows));
  else
    tell(globals, report, rows);
  flush_warnings();
  return report.first || report.frames == 0 || !report.whole ? 1 : 0;
}

}  // namespace

void add_replay(CommandLine& line) {
  const auto run = std::make_shared<std::string>(), scene = std::make_shared<std::string>();
  Command sub = line.add(
      "replay",
      "Render a recorded run again and compare each force with the recorded one, bit by bit. A frames.csv of "
      "another run beside the record is refused; other files of the run are not read. Exit code 1: a force "
      "differs, or the record ends early");
  sub.runs([run, scene](const Globals& globals) { return run_replay(globals, *run, *scene); });
  sub.option("RUN", *run, "Folder of a session, whose session.inputs is read").required();
  sub.option("--scene", *scene,
             "Scene of the run, where its body may be touched anywhere; default: that of its summary.json")
      .shows("SCENE");
}

}  // namespace forefeel
