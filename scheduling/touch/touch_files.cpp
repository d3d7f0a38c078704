#include "scheduling/touch/touch_files.hpp"

#include "geometry/common/run_columns.hpp"

namespace forefeel {
namespace {

using TouchRow = TouchFrameRecord;

bool is_touching(const TouchRow& frame) {
  return frame.touch != TouchKind::none;
}

// Three empty cells without a touch.
void put_if(RowText& out, const TouchRow& frame, const Vec3& v) {
  put(out, is_touching(frame) ? v : Vec3::Constant(unknown));
}

constexpr RunColumn<TouchRow> touch_frame_columns[] = {
    {"t", "s", "time of the frame", [](RowText& o, const TouchRow& f) { put(o, f.t); }},
    {"x,y,z", "m", "the tip, in the axes of the mesh", [](RowText& o, const TouchRow& f) { put(o, f.tip); }},
    {"sx,sy,sz", "m", "its site on the surface at rest; empty: no touch",
     [](RowText& o, const TouchRow& f) { put_if(o, f, f.site.at); }},
    {"nx,ny,nz", "1", "mean normal under the pad there",
     [](RowText& o, const TouchRow& f) { put_if(o, f, f.normal); }},
    {"touch", "", "none, stick or slip", [](RowText& o, const TouchRow& f) { put(o, name(f.touch)); }},
    {"fx,fy,fz", "N", "force sent to the device: after the safety rules",
     [](RowText& o, const TouchRow& f) { put(o, f.force.sent); }},
    {"rendered_x,rendered_y,rendered_z", "N", "rendered force: after the switch, before the safety rules",
     [](RowText& o, const TouchRow& f) { put(o, f.force.rendered); }},
    {"ux,uy,uz", "N", "force of the newest model, as if models changed at once",
     [](RowText& o, const TouchRow& f) { put(o, f.force.undamped); }},
    {"elastic_x,elastic_y,elastic_z", "N", "rendered force before the relaxation function of a viscous body",
     [](RowText& o, const TouchRow& f) { put(o, f.force.elastic); }},
    {"energy", "J", "stored by body and pad", [](RowText& o, const TouchRow& f) { put(o, f.energy); }},
    {"lost", "J", "by sliding, and where a touch ends under force, in this frame",
     [](RowText& o, const TouchRow& f) { put(o, f.lost); }},
    {"slope", "1",
     "|g| / (f . n): a touch slides where it exceeds contact.friction, but not out of a kink of E on an edge",
     [](RowText& o, const TouchRow& f) { put(o, f.source.slope); }},
    {"label", "", "coverage at (site, tip - site): safe, sparse, gap or blank; empty: no touch",
     [](RowText& o, const TouchRow& f) { put(o, is_touching(f) ? name(f.label) : ""); }},
    {"trusted", "", "1: the model's own estimate of its error is within state_space.tolerance; else 0",
     [](RowText& o, const TouchRow& f) { put(o, f.source.bar.trusted); }},
    {"estimate", "N", "of that error", [](RowText& o, const TouchRow& f) { put(o, f.source.bar.scale); }},
    {"bar90,bar95,bar99", "N",
     "error bar: |elastic - reference| is at most this with 90, 95, 99 %; at least a tenth of the "
     "JND; empty: half as far again as states are placed, or farther",
     [](RowText& o, const TouchRow& f) {
       const auto& [at_90, at_95, at_99] = f.source.bar.half_width;
       put(o, Vec3(at_90, at_95, at_99));
     }},
    {"model", "", "serial number of the newest model",
     [](RowText& o, const TouchRow& f) { put(o, std::int64_t{f.source.model}); }},
    {"known", "", "number of solved states in it",
     [](RowText& o, const TouchRow& f) { put(o, std::int64_t{f.source.known}); }},
    {"took_model", "", "1: a newer model is rendered from this frame on",
     [](RowText& o, const TouchRow& f) { put(o, f.step.took_model); }},
    {"undamped_jump", "N", "difference of the two models where a newer one is taken",
     [](RowText& o, const TouchRow& f) { put(o, f.step.undamped_jump); }},
    {"switch_change", "N", "change of the rendered force by the switch in this frame",
     [](RowText& o, const TouchRow& f) { put(o, f.step.change); }},
    {"switch_bound", "N", "bound of the switch's rule on that change",
     [](RowText& o, const TouchRow& f) { put(o, f.step.bound); }},
    {"sampled", "", "1: compared with a tight solve, at equal distances along the path",
     [](RowText& o, const TouchRow& f) { put(o, f.judged.sampled); }},
    {"first_visit", "", "1: compared with a tight solve, as the first frame in its cell of tip and site",
     [](RowText& o, const TouchRow& f) { put(o, f.judged.first_visit); }},
    {"rx,ry,rz", "N", "reference: force of the tight solve",
     [](RowText& o, const TouchRow& f) { put(o, f.judged.reference); }},
    {"error", "1", "|elastic - reference| / max(|reference|, session.error_floor)",
     [](RowText& o, const TouchRow& f) { put(o, f.judged.error); }},
    {"approximation", "1", "part of the error: newest model against the reference",
     [](RowText& o, const TouchRow& f) { put(o, f.judged.approximation); }},
    {"switch", "1", "part of the error: rendered force against the newest model",
     [](RowText& o, const TouchRow& f) { put(o, f.judged.switching); }},
    {"cost_us", "us", "time to compute the frame",
     [](RowText& o, const TouchRow& f) { put(o, f.timing.cost_us); }, true},
    {"lateness_us", "us", "delay of the frame's start",
     [](RowText& o, const TouchRow& f) { put(o, f.timing.lateness_us); }, true}};

constexpr RunColumn<TouchDispatch> touch_dispatch_columns[] = {
    {"id", "", "number of the solve", [](RowText& o, const TouchDispatch& d) { put(o, std::int64_t{d.id}); }},
    {"sx,sy,sz", "m", "site of the state", [](RowText& o, const TouchDispatch& d) { put(o, d.site); }},
    {"x,y,z", "m", "its displacement; 0: a jet at rest",
     [](RowText& o, const TouchDispatch& d) { put(o, d.x); }},
    {"priority", "1", "priority by the policy; empty: a jet at rest, which comes first",
     [](RowText& o, const TouchDispatch& d) { put(o, d.priority); }},
    {"requested", "s", "time of the planner's decision",
     [](RowText& o, const TouchDispatch& d) { put(o, d.requested); }},
    {"started", "s", "begin of the solve", [](RowText& o, const TouchDispatch& d) { put(o, d.started); }},
    {"finished", "s", "end of the solve", [](RowText& o, const TouchDispatch& d) { put(o, d.finished); }},
    {"known", "s", "time at which the planner received the state",
     [](RowText& o, const TouchDispatch& d) { put(o, d.known); }},
    {"status", "", "running, solved, failed or preempted",
     [](RowText& o, const TouchDispatch& d) { put(o, name(d.status)); }},
    {"worker", "", "number of the worker, from 0",
     [](RowText& o, const TouchDispatch& d) { put(o, std::int64_t{d.worker}); }}};

}  // namespace

void write_touch_files(const std::filesystem::path& folder, const TouchSessionResult& result, bool real) {
  const Circumstances of_run{.real = real};
  write_rows<TouchRow>(folder / "frames.csv", result.frames, touch_frame_columns, of_run);
  write_rows<TouchDispatch>(folder / "dispatch.csv", result.dispatches, touch_dispatch_columns, of_run);
}

std::vector<DeclaredTable> declared_touch_files() {
  return {{"frames.csv, anywhere", "Of a session with contact.anywhere: one row a frame.",
           declared<TouchRow>(touch_frame_columns)},
          {"dispatch.csv, anywhere", "Of a session with contact.anywhere: one row a solve.",
           declared<TouchDispatch>(touch_dispatch_columns)}};
}

}  // namespace forefeel
