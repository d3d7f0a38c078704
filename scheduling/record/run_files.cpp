#include "scheduling/record/run_files.hpp"

#include <cstdint>
#include <exception>
#include <future>
#include <string>
#include <vector>

#include "geometry/common/error.hpp"
#include "geometry/common/field.hpp"
#include "geometry/common/output_file.hpp"

namespace forefeel {
namespace {

const Vec3 nowhere = Vec3::Constant(unknown);  // three empty cells

using Frame = FrameRecord;
constexpr Field<Frame> of_frames[] = {
    {"t", "s", "time of the frame", [](Cells& o, const Frame& f) { put(o, f.t); }},
    {"x,y,z", "m",
     "position of the tip, from its rest position; of a body touched anywhere in the axes of the mesh",
     [](Cells& o, const Frame& f) { put(o, f.at); }, "at"},
    {"fx,fy,fz", "N", "force sent to the device: after the safety rules",
     [](Cells& o, const Frame& f) { put(o, f.sent); }, "sent"},
    {"label", "", "coverage at the tip: safe, sparse, gap or blank",
     [](Cells& o, const Frame& f) {
       if (f.touch.applies && f.touch.kind == TouchKind::none)
         o.word("", no_word);
       else
         put(o, f.label);
     }},
    {"model", "", "serial number of the model that is rendered; 0: none",
     [](Cells& o, const Frame& f) { o.whole(f.step.model); }},
    {"known", "", "number of known states", [](Cells& o, const Frame& f) { o.whole(f.known); }},
    {"ux,uy,uz", "N", "force of the newest model, as if models changed at once",
     [](Cells& o, const Frame& f) { put(o, f.undamped); }, "undamped"},
    {"rendered_x,rendered_y,rendered_z", "N", "rendered force: after the switch, before the safety rules",
     [](Cells& o, const Frame& f) { put(o, f.force); }, "rendered"},
    {"switch_change", "N", "change of the rendered force by the switch in this frame",
     [](Cells& o, const Frame& f) { put(o, f.step.change); }},
    {"switch_bound", "N", "bound of the switch's rule on that change",
     [](Cells& o, const Frame& f) { put(o, f.step.bound); }},
    {"motion_change", "N", "change of the rendered force by the motion",
     [](Cells& o, const Frame& f) { put(o, f.step.motion_change); }},
    {"took_model", "", "1: a newer model is rendered from this frame on",
     [](Cells& o, const Frame& f) { put(o, f.step.took_model); }},
    {"undamped_jump", "N", "difference of the two models where a newer one is taken",
     [](Cells& o, const Frame& f) { put(o, f.step.undamped_jump); }},
    {"sampled", "", "1: compared with a tight solve, at equal distances along the path",
     [](Cells& o, const Frame& f) { put(o, f.judged.sampled); }},
    {"first_visit", "", "1: compared with a tight solve, as the first frame in its lattice cell",
     [](Cells& o, const Frame& f) { put(o, f.judged.first_visit); }},
    {"rx,ry,rz", "N", "reference: force of the tight solve",
     [](Cells& o, const Frame& f) { put(o, f.judged.reference); }, "reference"},
    {"error", "1", "|rendered - reference| / max(|reference|, session.error_floor)",
     [](Cells& o, const Frame& f) { put(o, f.judged.error); }},
    {"approximation", "1", "part of the error: newest model against the reference",
     [](Cells& o, const Frame& f) { put(o, f.judged.approximation); }},
    {"switch", "1", "part of the error: rendered force against the newest model",
     [](Cells& o, const Frame& f) { put(o, f.judged.switching); }, "switching"},
    {"staleness", "1", "part of the error: newest model against one of all states known by then",
     [](Cells& o, const Frame& f) { put(o, f.judged.staleness); }},
    {"cost_us", "us", "time to compute the frame", [](Cells& o, const Frame& f) { put(o, f.timing.cost_us); },
     "", Only::real},
    {"lateness_us", "us", "delay of the frame's start",
     [](Cells& o, const Frame& f) { put(o, f.timing.lateness_us); }, "", Only::real},
    {"bar90,bar95,bar99", "N",
     "error bar: |rendered - reference| is at most this with 90, 95, 99 %; empty where nothing is known of "
     "it yet; at least a tenth of the just noticeable difference, unless the states were given and are "
     "exact; "
     "if the body is viscous, of its elastic force alone",
     [](Cells& o, const Frame& f) {
       const auto& [at_90, at_95, at_99] = f.bar.half_width;
       put(o, Vec3(at_90, at_95, at_99));
     },
     "bars"},
    {"bar_scale", "N", "scale of the newest model's error that the error bar is made of",
     [](Cells& o, const Frame& f) { put(o, f.bar.scale); }},
    {"trusted", "", "1: the force is that of energy jets within their trust and the tolerance; else 0",
     [](Cells& o, const Frame& f) { put(o, f.bar.trusted); }},
    {"sx,sy,sz", "m", "site of the touch on the surface at rest; empty: no touch, or one place of contact",
     [](Cells& o, const Frame& f) { put(o, f.touch.site.exists() ? f.touch.site.at : nowhere); }, "site"},
    {"touch", "", "none, stick or slip; empty: one place of contact",
     [](Cells& o, const Frame& f) { f.touch.applies ? put(o, f.touch.kind) : o.word("", no_word); }},
    {"nx,ny,nz", "1", "mean normal under the pad there",
     [](Cells& o, const Frame& f) { put(o, f.touch.site.exists() ? f.touch.normal : nowhere); }, "normal",
     Only::anywhere},
    {"energy", "J", "stored by body and pad", [](Cells& o, const Frame& f) { put(o, f.touch.energy); }, "",
     Only::anywhere},
    {"lost", "J", "by sliding, and where a touch ends under force, in this frame",
     [](Cells& o, const Frame& f) { put(o, f.touch.lost); }, "", Only::anywhere},
    {"slope", "1",
     "|g| / (f . n): a touch slides where it exceeds contact.friction, but not out of a kink of E on an edge",
     [](Cells& o, const Frame& f) { put(o, f.touch.slope); }, "", Only::anywhere},
    {"tip_change", "N",
     "change of the newest model's force by the way of the tip, were the site to stay: what the motion "
     "explains in felt_steps (motion_change holds the slide too); 0 while the site snaps",
     [](Cells& o, const Frame& f) { put(o, f.touch.tip_change); }, "", Only::anywhere},
    {"elastic_x,elastic_y,elastic_z", "N", "rendered force before the relaxation function",
     [](Cells& o, const Frame& f) { put(o, f.elastic); }, "elastic", Only::viscous},
    {"elastic_rx,elastic_ry,elastic_rz", "N", "force of the tight solve before the relaxation function",
     [](Cells& o, const Frame& f) { put(o, f.judged.elastic_reference); }, "elastic_reference",
     Only::viscous}};

using Dispatched = DispatchRecord;
constexpr Field<Dispatched> of_solves[] = {
    {"id", "", "number of the solve", [](Cells& o, const Dispatched& d) { o.whole(d.id); }},
    {"x,y,z", "m", "position of the state: displacement of the tip from rest, or from its site",
     [](Cells& o, const Dispatched& d) { put(o, d.displacement()); }, "at"},
    {"label", "", "coverage there when it was requested",
     [](Cells& o, const Dispatched& d) { put(o, d.label); }},
    {"priority", "1", "priority by the policy",
     [](Cells& o, const Dispatched& d) { put(o, d.choice.priority); }},
    {"requested", "s", "time of the planner's decision",
     [](Cells& o, const Dispatched& d) { put(o, d.requested); }},
    {"started", "s", "begin of the solve; empty: it never began",
     [](Cells& o, const Dispatched& d) { put(o, d.started); }},
    {"finished", "s", "end of the solve", [](Cells& o, const Dispatched& d) { put(o, d.finished); }},
    {"first_used", "s", "first frame with a model that uses the state; empty: none",
     [](Cells& o, const Dispatched& d) { put(o, d.first_used); }},
    {"status", "", "running, waiting, solved, failed, arrived, preempted or withdrawn",
     [](Cells& o, const Dispatched& d) { put(o, d.status); }},
    {"worker", "", "number of the worker, from 0; -1: none",
     [](Cells& o, const Dispatched& d) { o.whole(d.worker); }},
    {"parent", "", "id of the solve whose state this one started from; -1: rest or a state known before",
     [](Cells& o, const Dispatched& d) { o.whole(d.parent); }},
    {"known", "s", "time at which the planner received the state",
     [](Cells& o, const Dispatched& d) { put(o, d.known); }},
    {"audit", "", "1: solved where the tip had just been, to calibrate the error bars",
     [](Cells& o, const Dispatched& d) { put(o, d.choice.audit); }},
    {"sx,sy,sz", "m", "site of the state; empty: one place of contact",
     [](Cells& o, const Dispatched& d) { put(o, d.choice.site); }, "site"}};

using Change = SwitchRecord;
constexpr Field<Change> of_changes[] = {
    {"t", "s", "time at which the loop took the model", [](Cells& o, const Change& s) { put(o, s.t); }},
    {"model", "", "serial number of the model", [](Cells& o, const Change& s) { o.whole(s.model); }},
    {"cause", "",
     "guess (no state known), first (the first state), states (more came) or travel (the tip moved)",
     [](Cells& o, const Change& s) { put(o, s.cause); }},
    {"label", "", "coverage of the region that chose the model's states",
     [](Cells& o, const Change& s) { put(o, s.label); }},
    {"n", "", "states of the model", [](Cells& o, const Change& s) { o.whole(s.n); }},
    {"replaced", "", "of these, not in the model before",
     [](Cells& o, const Change& s) { o.whole(s.replaced); }},
    {"jump_undamped", "N", "difference of the two models at the tip",
     [](Cells& o, const Change& s) { put(o, s.jump_undamped); }},
    {"fit_us", "us", "time to make the model", [](Cells& o, const Change& s) { put(o, s.fit_us); }, "",
     Only::real}};

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
  const Circumstances of_run{.real = options.clock.kind == Clock::real,
                             .viscous = result.run.viscous,
                             .anywhere = !result.frames.empty() && result.frames.front().touch.applies};
  std::future<std::string> others = std::async(std::launch::async, [&] {
    return problem_of(
               [&] { write_rows<Dispatched>(folder / "dispatch.csv", result.dispatch, of_solves, of_run); }) +
           problem_of(
               [&] { write_rows<Change>(folder / "switches.csv", result.switches, of_changes, of_run); });
  });
  std::string problems =
      problem_of([&] { write_rows<Frame>(folder / "frames.csv", result.frames, of_frames, of_run); });
  problems += others.get();
  if (problems.empty()) return;
  problems.resize(problems.size() - 2);
  throw InputError({.file = folder.string()}, "is incomplete: " + problems);
}

std::span<const Field<FrameRecord>> frame_columns() {
  return of_frames;
}
std::span<const Field<DispatchRecord>> dispatch_columns() {
  return of_solves;
}
std::span<const Field<SwitchRecord>> switch_columns() {
  return of_changes;
}

std::vector<DeclaredTable> declared_run_files() {
  return {{"frames.csv", "One row a frame, 1 kHz.", declared<Frame>(of_frames)},
          {"dispatch.csv", "One row a solve that was requested.", declared<Dispatched>(of_solves)},
          {"switches.csv", "One row a model that the loop took.", declared<Change>(of_changes)}};
}

}  // namespace forefeel
