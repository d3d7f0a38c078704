// Tables: states, points, traces, arrivals, and what a run has written.

#include <stdexcept>
#include <variant>

#include "apps/scene/spec_text.hpp"
#include "geometry/common/csv_rows.hpp"
#include "geometry/common/error.hpp"
#include "geometry/states/state_file.hpp"
#include "geometry/states/state_message.hpp"
#include "scheduling/common/dispatch_file.hpp"
#include "scheduling/motion/device.hpp"
#include "scheduling/motion/trace.hpp"
#include "scheduling/motion/trace_check.hpp"
#include "scheduling/motion/trace_file.hpp"
#include "scheduling/render/input_format.hpp"
#include "scheduling/session/arrivals.hpp"
#include "scheduling/session/input_replay.hpp"
#include "tests/fuzz/targets.hpp"

namespace forefeel::fuzz {
namespace {

void read_states_table(std::string_view input) {
  for (const State& state : load_states(file_of("s.csv", input)).states)
    if (!state.at.allFinite() || (state.usable() && !state.force.allFinite()))
      throw std::logic_error("a state that is not finite");
}

void read_points_table(std::string_view input) {
  for (const Vec3& point : read_points_csv(file_of("q.csv", input)))
    if (!point.allFinite()) throw std::logic_error("a point that is not finite");
}

void read_any_trace(std::string_view input) {
  const std::filesystem::path file = file_of("trace.csv", input);
  try {
    read_arrivals(file, 1);
  } catch (const InputError&) {
  }
  Trace trace = read_trace(file);
  for (std::size_t i = 1; i < trace.times.size(); ++i)
    if (!(trace.times[i] > trace.times[i - 1])) throw std::logic_error("times that do not grow");
  const double end = trace.times.back();
  const auto device = make_trace_device(std::move(trace));
  for (const double t : {-1.0, 0.0, 0.5 * end, end, 2 * end}) device->position(t, Vec3::Zero());
}

// A line with the specification of a trace behind its file, then the table: "columns=2/3/4,rate=100".
void read_any_table(std::string_view input) {
  const std::size_t line = std::min(input.find('\n'), input.size());
  const std::filesystem::path file = file_of("table.csv", input.substr(std::min(line + 1, input.size())));
  const DeviceSpec spec =
      device_from_text("trace:" + file.string() + "," + std::string(input.substr(0, line)));
  const auto* trace = std::get_if<TraceMotion>(&spec.motion());
  if (!trace || trace->file != file) return;
  const TraceRows rows = read_trace_rows(file, trace->format, MissingPositions::leave_out);
  if (rows.times.empty() || rows.times.size() != rows.positions.size())
    throw std::logic_error("rows without times");
  for (const Vec3& x : rows.positions)
    if (!x.allFinite()) throw std::logic_error("a position that is not finite");
  check_trace(rows, {});
}

// frames.csv, a line "---", dispatch.csv: the files of a run that is replayed.
void read_run(std::string_view input) {
  constexpr std::string_view rule = "---\n";
  const std::size_t cut = input.find(rule);
  const std::filesystem::path frames = file_of("frames.csv", input.substr(0, cut));
  file_of("dispatch.csv", cut == std::string_view::npos ? "" : input.substr(cut + rule.size()));
  try {
    CsvText::read(frames, "a file of a run");
  } catch (const InputError&) {
  }
  read_replay(frames.parent_path(), 1);
}

constexpr std::size_t replayed_frames = 20;

std::string as_text(Packer& packer) {
  const Bytes bytes = packer.take();
  return {bytes.begin(), bytes.end()};
}

template <class Value>
void add_record(Packer& out, InputKind kind, const Value& value) {
  Packer content;
  pack(content, value);
  pack_record(out, kind, content.take());
}

// The records of a run behind a header that is in order.
void replay_records(std::string_view input) {
  try {
    InputReader reader(file_of("raw.inputs", input));
  } catch (const InputError&) {
  }
  InputHeader header{.made_by = "fuzz", .real = true, .frames = replayed_frames, .spare = 4};
  header.space.box = {Vec3::Constant(-0.02), Vec3::Constant(0.02)};
  header.render.viscosity = {{0.3, 0.01}};
  Packer file;
  file.add_raw(inputs_magic);
  add_record(file, InputKind::header, header);
  file.add_raw(input);
  const ReplayReport report = replay_inputs(file_of("session.inputs", as_text(file)));
  if (report.equal > report.frames) throw std::logic_error("more equal frames than frames");
}

std::string recorded_run() {
  Packer records;
  for (const double x : {0.0, 0.006, -0.006}) {
    State state;
    state.at = Vec3(x, 0, 0);
    state.force = -100 * state.at;
    state.stiffness = 100 * Mat3::Identity();
    add_record(records, InputKind::state, state);
  }
  add_record(records, InputKind::model, ModelInput{.states = 3, .serial = 1, .published = true});
  for (std::uint32_t k = 0; k < replayed_frames; ++k)
    add_record(records, InputKind::frame,
               FrameInput{.frame = k,
                          .known = 3,
                          .model = k == 2 ? 1u : 0u,
                          .started = 1e-3 * k,
                          .now = 1e-3 * k,
                          .beat = 1e-3 * k,
                          .at = Vec3(1e-4 * k, 0, 0)});
  pack_record(records, InputKind::end, {});
  return as_text(records);
}

}  // namespace

std::vector<Target> table_targets() {
  using Seeds = std::vector<std::string>;
  return {
      {"states-csv", read_states_table,
       [] {
         return Seeds{"x,y,z,fx,fy,fz\n0,0,0,0,0,0\n0.01,0,0,-1,2e-3,.5\n",
                      "# measured\r\n fx ,fy,fz,x,y,z,h,energy,status\r\n1,2,3,4,5,6,0.1,,converged\r\n"
                      "1,2,nan,4,5,6,0.1,0.2,diverged\r\n",
                      "x,y,z,fx,fy,fz,k11,k12,k13,k21,k22,k23,k31,k32,k33,converged\n"
                      "0,0,0,1,1,1,9,8,7,6,5,4,3,2,1,true\n0,0,1,1,1,1,,,,,,,,,,0\n"};
       }},
      {"points-csv", read_points_table,
       [] {
         return Seeds{"x,y,z\n0.001,0,-2e-3\n", "1,2,3\n4,5,6\n", "\xef\xbb\xbfz,note,y,x\n1,\"a b\",2,3\n"};
       }},
      {"trace", read_any_trace,
       [] {
         return Seeds{"t,x,y,z\n0,0,0,0\n0.1,0.01,0,0\n0.3,0.02,1e-3,-0.01\n", "0,0,0,0\n1,0,0,0.02\n"};
       }},
      {"table", read_any_table,
       [] {
         return Seeds{
             "columns=5/4/3/2,unit=mm/ms\na 3 2 1  0\na 3 2 1.5  500\na 3 2 2  1000\n",
             "columns=time/px/py/pz,unit=mm/ms\n# "
             "log\ntime;qw;pz;py;px\nms;;mm;mm;mm\n0;1;3;2;1\n500;1;3;2;1,5\n",
             "rate=2,unit=mm\nx\ty\tz\n1\t2\t3\n1.5\t2\t3\n",
             "tool=pen,unit=mm/ms\nt,tool,x,y,z\n0,pen,1,2,3\n0,cup,9,9,9\n500,pen,1.5,2,3\n500,cup,9,9,9\n",
             "tool=right\nt,left_x,left_y,left_z,right_x,right_y,right_z\n0,9,9,9,1,2,3\n500,9,9,9,1.5,2,3\n",
             "columns=1/2/3/-\n1,2,3\n2,3,nan\n3,,\n4,0,0\n"};
       }},
      {"inputs", replay_records, [] { return Seeds{recorded_run()}; }},
      {"run", read_run, [] {
         return Seeds{
             "t,x,y,z,fx,fy,fz,label,model,known\n0,0,0,0,0,0,0,blank,0,0\n0.001,1e-5,0,0,0.1,0,0,safe,1,2\n"
             "---\nid,x,y,z,label,priority,requested,started,finished,first_used,status,worker,parent,known\n"
             "0,0.006,0,0,safe,1,0,0,0.01,0.02,solved,0,,0.01\n"};
       }}};
}

}  // namespace forefeel::fuzz
