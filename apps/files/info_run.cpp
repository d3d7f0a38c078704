#include "apps/files/info_run.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <chrono>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "apps/console/document_keys.hpp"
#include "apps/console/json.hpp"
#include "apps/console/provenance.hpp"
#include "geometry/common/counted.hpp"
#include "geometry/common/error.hpp"
#include "geometry/common/scanner.hpp"

namespace forefeel {
namespace {

// Local time of a file's last change. A summary holds none: equal runs are equal bytes.
std::string written_at(const std::filesystem::path& file) {
  const auto when = std::chrono::file_clock::to_sys(std::filesystem::last_write_time(file));
  return fmt::format("{:%Y-%m-%d %H:%M}",
                     fmt::localtime(std::chrono::system_clock::to_time_t(
                         std::chrono::time_point_cast<std::chrono::system_clock::duration>(when))));
}

}  // namespace

int info_run(const Globals& globals, const std::filesystem::path& folder) {
  const std::filesystem::path file = folder / "summary.json";
  if (!std::filesystem::exists(file))
    throw InputError({.file = folder.string()},
                     "is a folder without summary.json, expected the folder of a session, or a file");
  Json summary;
  try {
    summary = Json::parse(read_text_file(file));
  } catch (const Json::exception&) {
    throw InputError({.file = file.string()}, "is not JSON, expected the summary of a session");
  }
  const auto at = [&](const char* path) { return summary.value(Json::json_pointer(path), Json()); };
  const auto words = [](const Json& value) {
    return value.is_string() ? value.get<std::string>() : "unknown";
  };
  const auto percent = [](const Json& value) {
    return value.is_number() ? said_percent(value.get<double>()) : std::string("unknown");
  };
  const auto count = [](const Json& value) {
    return value.is_number() ? value.dump() : std::string("unknown");
  };
  const std::filesystem::path report = folder / "report.html";
  const std::vector<std::string> next{report.string(), "forefeel show " + shell_quoted(folder.string())};
  Json document{{"kind", "run"},
                {"command", at("/provenance/command")},
                {"written", written_at(file)},
                {"seconds", at("/seconds")},
                {"frames", at("/frames")},
                {"interrupted", at("/interrupted")},
                {"states", {{"start", at("/states/start")}, {"solved", at("/states/solved")}}},
                {"error", {{"p95", at("/error/p95")}, {"within_jnd", at("/error/within_jnd")}}},
                {"attention", at("/attention")},
                {"next", next}};
  if (globals.json) print_json(document);
  answer(globals, fmt::format("{}: a session, written {}{}", folder.string(), words(document["written"]),
                              document["interrupted"] == true ? ", interrupted" : ""));
  answer(globals, "  " + words(document["command"]));
  answer(globals, fmt::format("  {} s, {} frames; {} states at the start, {} solved",
                              count(document["seconds"]), count(document["frames"]),
                              count(document["states"]["start"]), count(document["states"]["solved"])));
  answer(globals,
         fmt::format("  error of the force: {} for 95 % of the samples; {} of them below what a hand feels",
                     percent(document["error"]["p95"]), percent(document["error"]["within_jnd"])));
  for (const Json& line : document["attention"]) answer(globals, "  attention: " + words(line));
  answer(globals, fmt::format("  next: open {}, or {}", next[0], next[1]));
  return 0;
}

}  // namespace forefeel
