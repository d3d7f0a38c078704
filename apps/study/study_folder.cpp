#include "apps/study/study_folder.hpp"
#include "apps/console/json.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>

#include "apps/console/interrupt.hpp"
#include "apps/console/summary_json.hpp"
#include "geometry/common/error.hpp"
#include "geometry/common/output_file.hpp"

namespace forefeel {
namespace {

namespace fs = std::filesystem;

fs::path record_file(const fs::path& folder, const StudyCell& cell) {
  return folder / "cells" / (cell.key + ".json");
}

ColumnValue value_of(const nlohmann::ordered_json& json) {
  if (json.is_boolean()) return json.get<bool>();
  if (json.is_number_integer()) return json.get<std::uint64_t>();
  if (json.is_number()) return json.get<double>();
  if (json.is_string()) return json.get<std::string>();
  return {};
}

// Nothing if the file is missing, damaged or of another cell.
std::optional<StudyCellResult> read_record(const fs::path& folder, const StudyCell& cell) {
  std::ifstream in(record_file(folder, cell));
  if (!in) return {};
  try {
    const auto record = nlohmann::ordered_json::parse(in);
    if (record.at("key").get<std::string>() != cell.key || record.at("columns").empty()) return {};
    std::vector<Column> columns;
    for (const auto& [name, value] : record.at("columns").items()) columns.push_back({name, value_of(value)});
    StudyCellResult result(std::move(columns));
    if (const auto notes = record.find("notes"); notes != record.end())
      result.set_notes(notes->get<std::vector<std::string>>());
    return result;
  } catch (const nlohmann::json::exception&) {
    return {};
  }
}

void write_record(const fs::path& folder, const StudyCell& cell, const StudyCellResult& result) {
  nlohmann::ordered_json record{{"key", cell.key},
                                {"device", to_text(cell.options.motion.device)},
                                {"cost", to_text(cell.options.workers.cost)}};
  for (const Column& column : result.columns())
    record["columns"][column.name] = forefeel::to_json(column.value);
  record["notes"] = result.notes();
  write_whole(record_file(folder, cell), json_text(record, 1) + "\n");
}

// One process at a time writes to a folder.
class StudyLock {
 public:
  explicit StudyLock(const fs::path& folder) {
    descriptor_ = open((folder / "cells" / "lock").c_str(), O_CREAT | O_RDWR | O_CLOEXEC, 0644);
    if (descriptor_ < 0)
      throw InputError({.file = folder.string()}, "cannot be written, expected a folder for the results");
    if (flock(descriptor_, LOCK_EX | LOCK_NB) != 0) {
      close(descriptor_);
      throw InputError({.file = folder.string()},
                       "another study is writing here, expected a folder of its own");
    }
  }
  ~StudyLock() { close(descriptor_); }
  StudyLock(const StudyLock&) = delete;
  StudyLock& operator=(const StudyLock&) = delete;

 private:
  int descriptor_ = -1;
};

std::string in_words(const StudyProgress& p) {
  const std::string before = p.resumed > 0 ? fmt::format(" ({} there before)", p.resumed) : "";
  return fmt::format("{} of {} cells{}", p.done, p.cells, before);
}

// Copies the cells that other folders hold and this one does not.
void merge(const StudyPlaces& places, const StudyPlan& plan) {
  for (const StudyCell& cell : plan.cells) {
    if (read_record(places.folder, cell)) continue;
    for (const std::string& part : places.parts) {
      const auto record = read_record(part, cell);
      if (!record) continue;
      write_record(places.folder, cell, *record);
      break;
    }
  }
}

}  // namespace

void check_parts(const std::vector<std::string>& parts, const StudyPlan& plan) {
  for (const std::string& part : parts)
    if (std::ranges::none_of(plan.cells,
                             [&](const StudyCell& cell) { return read_record(part, cell).has_value(); }))
      throw InputError(
          "--merge " + part,
          "holds no cell of this study, expected a folder that the same build of forefeel has filled "
          "for the same study: the text of the study, its scenes and traces count");
}

StudyResult run_study_in(const StudyPlaces& places, const StudyPart& part, const StudyPlan& plan,
                         const Globals& globals) {
  const fs::path& folder = places.folder;
  std::error_code error;
  fs::create_directories(folder / "cells", error);
  const StudyLock lock(folder);
  if (!places.manifest.empty()) write_whole(folder / "study.json", places.manifest);
  merge(places, plan);
  Progress progress(globals, "study");
  const InterruptWatch watch;
  return run_study(plan,
                   {.threads = globals.threads,
                    .store = {.load = [&](const StudyCell& cell) { return read_record(folder, cell); },
                              .save = [&](const StudyCell& cell,
                                          const StudyCellResult& row) { write_record(folder, cell, row); }},
                    .interrupted = &watch.flag(),
                    .hurried = &watch.hurry(),
                    .progress = [&](const StudyProgress& p) { progress.show(p.share, in_words(p)); },
                    .warn = [&](const std::string& line) { warn(globals, line); },
                    .part = part});
}

}  // namespace forefeel
