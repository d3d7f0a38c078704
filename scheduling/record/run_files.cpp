#include "scheduling/record/run_files.hpp"

#include <fmt/format.h>

#include <cmath>
#include <exception>
#include <future>
#include <iterator>
#include <span>
#include <string>
#include <vector>

#include "geometry/common/error.hpp"
#include "geometry/common/output_file.hpp"

namespace forefeel {
namespace {

using Text = fmt::memory_buffer;

// Shortest text that reads back to the same double; empty where unknown.
void put(Text& out, double value) {
  out.push_back(',');
  if (std::isfinite(value)) fmt::format_to(std::back_inserter(out), "{}", value == 0 ? 0.0 : value);
}
void put(Text& out, const Vec3& v) {
  for (int i = 0; i < 3; ++i) put(out, v[i]);
}

void write(const std::filesystem::path& file, const Text& text) {
  OutputFile out(file);
  out.write({text.data(), text.size()});
  out.commit();
}

Text frames_text(std::span<const FrameRecord> frames, bool real) {
  Text out;
  auto to = std::back_inserter(out);
  for (const FrameRecord& f : frames) {
    fmt::format_to(to, "{}", f.t);
    put(out, f.at);
    put(out, f.sent);
    fmt::format_to(to, ",{},{},{}", name(f.label), f.model, f.known);
    put(out, f.undamped);
    put(out, f.force);
    for (const double value : {f.step.change, f.step.bound, f.step.motion_change}) put(out, value);
    fmt::format_to(to, ",{}", f.step.took_model ? 1 : 0);
    put(out, f.step.undamped_jump);
    fmt::format_to(to, ",{},{}", f.judged.sampled ? 1 : 0, f.judged.first_visit ? 1 : 0);
    put(out, f.judged.reference);
    for (const double value :
         {f.judged.error, f.judged.approximation, f.judged.switching, f.judged.staleness})
      put(out, value);
    if (real) {
      put(out, f.timing.cost_us);
      put(out, f.timing.lateness_us);
    }
    out.push_back('\n');
  }
  return out;
}

void write_frames(const std::filesystem::path& file, const SessionResult& result, bool real) {
  const std::string header = fmt::format(
      "t,x,y,z,fx,fy,fz,label,model,known,ux,uy,uz,rendered_x,rendered_y,rendered_z,switch_change,switch_"
      "bound,"
      "motion_change,took_model,undamped_jump,sampled,first_visit,rx,ry,rz,error,approximation,switch,"
      "staleness{}\n",
      real ? ",cost_us,lateness_us" : "");
  const std::size_t parts = 4, n = result.frames.size();
  std::vector<std::future<Text>> texts;  // of a share of the frames each, side by side
  for (std::size_t part = 0; part < parts; ++part)
    texts.push_back(std::async(std::launch::async,
                               [&result, real, first = part * n / parts, last = (part + 1) * n / parts] {
                                 return frames_text({result.frames.data() + first, last - first}, real);
                               }));
  OutputFile out(file);
  out.write(header);
  for (std::future<Text>& text : texts) {
    const Text mine = text.get();
    out.write({mine.data(), mine.size()});
  }
  out.commit();
}

void write_dispatch(const std::filesystem::path& file, const SessionResult& result) {
  Text out;
  auto to = std::back_inserter(out);
  fmt::format_to(
      to, "id,x,y,z,label,priority,requested,started,finished,first_used,status,worker,parent,known\n");
  for (const DispatchRecord& d : result.dispatch) {
    fmt::format_to(to, "{}", d.id);
    put(out, d.at);
    fmt::format_to(to, ",{}", name(d.label));
    for (const double value : {d.priority, d.requested, d.started, d.finished, d.first_used}) put(out, value);
    fmt::format_to(to, ",{},{},{}", name(d.status), d.worker, d.parent);
    put(out, d.known);
    out.push_back('\n');
  }
  write(file, out);
}

// What an attempt to write failed with, and "; "; empty if it succeeded.
template <class Write>
std::string problem_of(Write write) {
  try {
    write();
    return {};
  } catch (const std::exception& problem) {
    return std::string(problem.what()) + "; ";
  }
}

void write_switches(const std::filesystem::path& file, const SessionResult& result, bool real) {
  Text out;
  auto to = std::back_inserter(out);
  fmt::format_to(to, "t,model,cause,label,n,replaced,jump_undamped{}\n", real ? ",fit_us" : "");
  for (const SwitchRecord& s : result.switches) {
    fmt::format_to(to, "{},{},{},{},{},{}", s.t, s.model, name(s.cause), name(s.label), s.n, s.replaced);
    put(out, s.jump_undamped);
    if (real) put(out, s.fit_us);
    out.push_back('\n');
  }
  write(file, out);
}

}  // namespace

void prepare_run_folder(const std::filesystem::path& folder) {
  if (folder.empty()) throw InputError("--output", "is empty, expected a folder for the files of the run");
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error || !std::filesystem::is_directory(folder))
    throw InputError({.file = folder.string()}, "cannot be made, expected a folder for the files of the run");
  check_writable(folder / "frames.csv");
}

void write_run_files(const std::filesystem::path& folder, const SessionResult& result,
                     const SessionOptions& options) {
  const bool real = options.clock.kind == Clock::real;
  std::future<std::string> others = std::async(std::launch::async, [&] {
    return problem_of([&] { write_dispatch(folder / "dispatch.csv", result); }) +
           problem_of([&] { write_switches(folder / "switches.csv", result, real); });
  });
  std::string problems = problem_of([&] { write_frames(folder / "frames.csv", result, real); });
  problems += others.get();
  if (problems.empty()) return;
  problems.resize(problems.size() - 2);
  throw InputError({.file = folder.string()}, "is incomplete: " + problems);
}

}  // namespace forefeel
