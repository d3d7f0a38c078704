#include "scheduling/record/run_files.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstdint>
#include <exception>
#include <future>
#include <iterator>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "geometry/common/error.hpp"
#include "geometry/common/output_file.hpp"

namespace forefeel {
namespace {

using Text = fmt::memory_buffer;

// Shortest text that reads back to the same double; empty where unknown.
void put(Text& out, double value) {
  if (std::isfinite(value)) fmt::format_to(std::back_inserter(out), "{}", value == 0 ? 0.0 : value);
}
void put(Text& out, const Vec3& v) {
  for (int i = 0; i < 3; ++i) {
    if (i > 0) out.push_back(',');
    put(out, v[i]);
  }
}
void put(Text& out, std::string_view word) {
  out.append(word);
}
void put(Text& out, std::int64_t number) {
  fmt::format_to(std::back_inserter(out), "{}", number);
}
void put(Text& out, bool flag) {
  out.push_back(flag ? '1' : '0');
}

// One column, or the columns of a vector: header, unit, meaning, and the function that writes its cells.
template <class Record>
struct RunColumn {
  std::string_view names, unit, meaning;
  void (*write)(Text&, const Record&);
  bool real = false;     // under the real clock only
  bool viscous = false;  // of a viscous body only
};

struct Circumstances {
  bool real = false, viscous = false;
  template <class Record>
  bool show(const RunColumn<Record>& column) const {
    return (real || !column.real) && (viscous || !column.viscous);
  }
};

using Frame = FrameRecord;
constexpr RunColumn<Frame> frame_columns[] = {
    {"t", "s", "time of the frame", [](Text& o, const Frame& f) { put(o, f.t); }},
    {"x,y,z", "m", "position of the tip, from its rest position",
     [](Text& o, const Frame& f) { put(o, f.at); }},
    {"fx,fy,fz", "N", "force sent to the device: after the safety rules",
     [](Text& o, const Frame& f) { put(o, f.sent); }},
    {"label", "", "coverage at the tip: safe, sparse, gap or blank",
     [](Text& o, const Frame& f) { put(o, name(f.label)); }},
    {"model", "", "serial number of the model that is rendered; 0: none",
     [](Text& o, const Frame& f) { put(o, std::int64_t{f.step.model}); }},
    {"known", "", "number of known states", [](Text& o, const Frame& f) { put(o, std::int64_t{f.known}); }},
    {"ux,uy,uz", "N", "force of the newest model, as if models changed at once",
     [](Text& o, const Frame& f) { put(o, f.undamped); }},
    {"rendered_x,rendered_y,rendered_z", "N", "rendered force: after the switch, before the safety rules",
     [](Text& o, const Frame& f) { put(o, f.force); }},
    {"switch_change", "N", "change of the rendered force by the switch in this frame",
     [](Text& o, const Frame& f) { put(o, f.step.change); }},
    {"switch_bound", "N", "bound of the switch's rule on that change",
     [](Text& o, const Frame& f) { put(o, f.step.bound); }},
    {"motion_change", "N", "change of the rendered force by the motion",
     [](Text& o, const Frame& f) { put(o, f.step.motion_change); }},
    {"took_model", "", "1: a newer model is rendered from this frame on",
     [](Text& o, const Frame& f) { put(o, f.step.took_model); }},
    {"undamped_jump", "N", "difference of the two models where a newer one is taken",
     [](Text& o, const Frame& f) { put(o, f.step.undamped_jump); }},
    {"sampled", "", "1: compared with a tight solve, at equal distances along the path",
     [](Text& o, const Frame& f) { put(o, f.judged.sampled); }},
    {"first_visit", "", "1: compared with a tight solve, as the first frame in its lattice cell",
     [](Text& o, const Frame& f) { put(o, f.judged.first_visit); }},
    {"rx,ry,rz", "N", "reference: force of the tight solve",
     [](Text& o, const Frame& f) { put(o, f.judged.reference); }},
    {"error", "1", "|rendered - reference| / max(|reference|, session.error_floor)",
     [](Text& o, const Frame& f) { put(o, f.judged.error); }},
    {"approximation", "1", "part of the error: newest model against the reference",
     [](Text& o, const Frame& f) { put(o, f.judged.approximation); }},
    {"switch", "1", "part of the error: rendered force against the newest model",
     [](Text& o, const Frame& f) { put(o, f.judged.switching); }},
    {"staleness", "1", "part of the error: newest model against one of all states known by then",
     [](Text& o, const Frame& f) { put(o, f.judged.staleness); }},
    {"cost_us", "us", "time to compute the frame", [](Text& o, const Frame& f) { put(o, f.timing.cost_us); },
     true},
    {"lateness_us", "us", "delay of the frame's start",
     [](Text& o, const Frame& f) { put(o, f.timing.lateness_us); }, true},
    {"bar90,bar95,bar99", "N",
     "error bar: |rendered - reference| is at most this with 90, 95, 99 %; empty where nothing is known of "
     "it "
     "yet; of the elastic force where the body is viscous",
     [](Text& o, const Frame& f) {
       const auto& [at_90, at_95, at_99] = f.bar.half_width;
       put(o, Vec3(at_90, at_95, at_99));
     }},
    {"bar_scale", "N", "scale of the newest model's error that the error bar is made of",
     [](Text& o, const Frame& f) { put(o, f.bar.scale); }},
    {"trusted", "", "1: the force is that of energy jets within their trust and the tolerance; else 0",
     [](Text& o, const Frame& f) { put(o, f.bar.trusted); }},
    {"elastic_x,elastic_y,elastic_z", "N", "rendered force before the relaxation function",
     [](Text& o, const Frame& f) { put(o, f.elastic); }, false, true},
    {"elastic_rx,elastic_ry,elastic_rz", "N", "force of the tight solve before the relaxation function",
     [](Text& o, const Frame& f) { put(o, f.judged.elastic_reference); }, false, true}};

using Dispatched = DispatchRecord;
constexpr RunColumn<Dispatched> dispatch_columns[] = {
    {"id", "", "number of the solve", [](Text& o, const Dispatched& d) { put(o, std::int64_t{d.id}); }},
    {"x,y,z", "m", "position of the state", [](Text& o, const Dispatched& d) { put(o, d.at); }},
    {"label", "", "coverage there when it was requested",
     [](Text& o, const Dispatched& d) { put(o, name(d.label)); }},
    {"priority", "1", "priority by the policy",
     [](Text& o, const Dispatched& d) { put(o, d.choice.priority); }},
    {"requested", "s", "time of the planner's decision",
     [](Text& o, const Dispatched& d) { put(o, d.requested); }},
    {"started", "s", "begin of the solve; empty: it never began",
     [](Text& o, const Dispatched& d) { put(o, d.started); }},
    {"finished", "s", "end of the solve", [](Text& o, const Dispatched& d) { put(o, d.finished); }},
    {"first_used", "s", "first frame with a model that uses the state; empty: none",
     [](Text& o, const Dispatched& d) { put(o, d.first_used); }},
    {"status", "", "running, waiting, solved, failed, arrived, preempted or withdrawn",
     [](Text& o, const Dispatched& d) { put(o, name(d.status)); }},
    {"worker", "", "number of the worker, from 0; -1: none",
     [](Text& o, const Dispatched& d) { put(o, std::int64_t{d.worker}); }},
    {"parent", "", "id of the solve whose state this one started from; -1: rest or a state known before",
     [](Text& o, const Dispatched& d) { put(o, d.parent); }},
    {"known", "s", "time at which the planner received the state",
     [](Text& o, const Dispatched& d) { put(o, d.known); }},
    {"audit", "", "1: solved where the tip had just been, to calibrate the error bars",
     [](Text& o, const Dispatched& d) { put(o, d.choice.audit); }}};

using Change = SwitchRecord;
constexpr RunColumn<Change> switch_columns[] = {
    {"t", "s", "time at which the loop took the model", [](Text& o, const Change& s) { put(o, s.t); }},
    {"model", "", "serial number of the model",
     [](Text& o, const Change& s) { put(o, std::int64_t{s.model}); }},
    {"cause", "",
     "guess (no state known), first (the first state), states (more came) or travel (the tip moved)",
     [](Text& o, const Change& s) { put(o, name(s.cause)); }},
    {"label", "", "coverage of the region that chose the model's states",
     [](Text& o, const Change& s) { put(o, name(s.label)); }},
    {"n", "", "states of the model", [](Text& o, const Change& s) { put(o, std::int64_t{s.n}); }},
    {"replaced", "", "of these, not in the model before",
     [](Text& o, const Change& s) { put(o, std::int64_t{s.replaced}); }},
    {"jump_undamped", "N", "difference of the two models at the tip",
     [](Text& o, const Change& s) { put(o, s.jump_undamped); }},
    {"fit_us", "us", "time to make the model", [](Text& o, const Change& s) { put(o, s.fit_us); }, true}};

template <class Record>
std::string header_of(std::span<const RunColumn<Record>> columns, const Circumstances& of) {
  std::string header;
  for (const RunColumn<Record>& column : columns)
    if (of.show(column)) header += (header.empty() ? "" : ",") + std::string(column.names);
  return header + '\n';
}

template <class Record>
Text rows_of(std::span<const Record> records, std::span<const RunColumn<Record>> columns,
             const Circumstances& of) {
  Text out;
  for (const Record& record : records) {
    for (const RunColumn<Record>& column : columns) {
      if (!of.show(column)) continue;
      if (&column != columns.data()) out.push_back(',');
      column.write(out, record);
    }
    out.push_back('\n');
  }
  return out;
}

// The parts of a long table are formatted in parallel.
template <class Record>
void write(const std::filesystem::path& file, std::span<const Record> records,
           std::span<const RunColumn<Record>> columns, const Circumstances& of) {
  const std::size_t n = records.size(), parts = n < 1000 ? 1 : 4;
  std::vector<std::future<Text>> texts;
  for (std::size_t part = 0; part < parts; ++part) {
    const std::size_t first = part * n / parts, last = (part + 1) * n / parts;
    texts.push_back(std::async(std::launch::async, [mine = records.subspan(first, last - first), columns,
                                                    of] { return rows_of(mine, columns, of); }));
  }
  OutputFile out(file);
  out.write(header_of(columns, of));
  for (std::future<Text>& text : texts) {
    const Text mine = text.get();
    out.write({mine.data(), mine.size()});
  }
  out.commit();
}

template <class Record>
std::vector<Declared> declared(std::span<const RunColumn<Record>> columns) {
  std::vector<Declared> rows;
  for (const RunColumn<Record>& column : columns)
    rows.push_back({std::string(column.names), std::string(column.unit), "",
                    std::string(column.meaning) + (column.real      ? "; real clock only"
                                                   : column.viscous ? "; viscous bodies only"
                                                                    : "")});
  return rows;
}

// Tries to write a file. Returns the error followed by "; ", or an empty text on success.
template <class Write>
std::string problem_of(Write write) {
  try {
    write();
    return {};
  } catch (const std::exception& problem) {
    return std::string(problem.what()) + "; ";
  }
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
  const Circumstances of_run{.real = options.clock.kind == Clock::real, .viscous = result.run.viscous};
  std::future<std::string> others = std::async(std::launch::async, [&] {
    return problem_of([&] {
             write<Dispatched>(folder / "dispatch.csv", result.dispatch, dispatch_columns, of_run);
           }) +
           problem_of(
               [&] { write<Change>(folder / "switches.csv", result.switches, switch_columns, of_run); });
  });
  std::string problems =
      problem_of([&] { write<Frame>(folder / "frames.csv", result.frames, frame_columns, of_run); });
  problems += others.get();
  if (problems.empty()) return;
  problems.resize(problems.size() - 2);
  throw InputError({.file = folder.string()}, "is incomplete: " + problems);
}

std::vector<DeclaredTable> declared_run_files() {
  return {{"frames.csv", "One row a frame, 1 kHz.", declared<Frame>(frame_columns)},
          {"dispatch.csv", "One row a solve that was requested.", declared<Dispatched>(dispatch_columns)},
          {"switches.csv", "One row a model that the loop took.", declared<Change>(switch_columns)}};
}

}  // namespace forefeel
