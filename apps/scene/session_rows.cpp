// The keys of [session], [session.jnd] and [session.limits].

#include <fmt/format.h>

#include "apps/scene/scene_declared.hpp"
#include "apps/scene/scene_rows.hpp"
#include "apps/scene/session_rows.hpp"
#include "scheduling/workers/generator.hpp"

namespace forefeel {
namespace {

namespace fs = std::filesystem;
using S = SessionOptions;

template <class... Members>
auto in_session(Members... members) {
  return path(&Scene::session, members...);
}

const SceneRows<SwitchOptions>& jnd_rows() {
  using J = SwitchOptions;
  static const auto rows =
      SceneRows<J>("session.jnd", "The just noticeable difference: max(share |F|, floor).")
          .number("share", "1", share(), "of the force", &J::jnd_share)
          .number("floor", "N", positive(), "for small forces", &J::jnd_floor);
  return rows;
}

const SceneRows<SafetyOptions>& limit_rows() {
  using L = SafetyOptions;
  static const auto rows =
      SceneRows<L>("session.limits", "Safety rules between the rendered force and the device.")
          .number("force", "N", positive(), "largest force sent; a device's lower limit prevails",
                  &L::force_limit)
          .number("slew", "N/s", positive(), "fastest change of the force sent", &L::slew_limit)
          .number("ramp", "s", not_negative(), "fade-in at the start", &L::ramp_seconds)
          .number("stale", "s", positive(), "silence of the planner after which the force fades out",
                  &L::stale_seconds)
          .number("coupling", "N/m", positive(), "with passivity = \"control\": largest stiffness rendered",
                  &L::coupling)
          .standard("0.95 of the loop's boundary");
  return rows;
}

void read_arrivals(const SceneTable& session, const std::string& key, Scene& scene) {
  const fs::path file = scene.source.file.parent_path() / *session.text(key);
  if (!fs::exists(file))
    throw InputError(session.where(key), fmt::format("no such file '{}'", file.string()));
  scene.session.planning.arrivals = file;
  scene.written.arrivals_place = session.where(key);
}

const SceneRows<PlanningOptions>& planning_rows() {
  using P = PlanningOptions;
  static const auto rows =
      SceneRows<P>("session", "")
          .word("placement", placement_words, ": where states may be placed", &P::placement)
          .only_solving()
          .flag("preempt", "cancel a running solve where another is worth far more", &P::preempt)
          .only_solving()
          .flag("rest_first", "where no state is known, solve the state at rest first", &P::rest_first)
          .only_solving()
          .flag("rest_known", "the state at rest is known from the start", &P::rest_known)
          .whole("batch", 0, 8, "states solved with one factorisation, 1 to 8; 0: the default", &P::batch)
          .standard("8 in real time, 1 under the virtual clock")
          .only_solving()
          .number("audit", "1", {.low = 0, .high = 0.5, .text = "from 0 to 0.5"},
                  "share of the solves made where the tip has just been, to calibrate the error bars",
                  &P::audit);
  return rows;
}

const SceneRows<WorkerOptions>& worker_rows() {
  using W = WorkerOptions;
  static const auto rows =
      SceneRows<W>("session", "")
          .number("latency", "s", not_negative(), "virtual clock: time of a message to or from a worker",
                  &W::latency)
          .only_solving()
          .number(
              "batch_share", "1", positive(),
              "virtual clock: cost of a state solved with another's factorisation, divided by that state's",
              &W::batch_share)
          .only_solving();
  return rows;
}

const SceneRows<JudgingOptions>& judging_rows() {
  using J = JudgingOptions;
  static const auto rows =
      SceneRows<J>("session", "")
          .number("error_floor", "N", positive(), "errors are relative to at least this force",
                  &J::error_floor)
          .number("reference_step", "m", positive(), "travel between samples compared with a tight solve",
                  &J::reference_step)
          .number("visit_cell", "m", not_negative(),
                  "side of the cells whose first visits are compared; 0: the spacing", &J::visit_cell)
          .standard("the spacing")
          .whole("visit_stride", 1, 1'000'000, "every n-th first visit is compared", &J::visit_stride)
          .flag(
              "discretisation_error",
              "measure once per body what the mesh itself gets wrong; also for generate, evaluate and study",
              &J::discretisation_error);
  return rows;
}

const SceneRows<ShapeOptions>& shape_rows() {
  using P = ShapeOptions;
  static const auto rows =
      SceneRows<P>("session", "")
          .number(
              "shape_rate", "Hz", {.low = 0, .high = 200, .text = "from 0 to 200 Hz"},
              "shapes of the body per second, in RUN/shape.pvd; 0: none. Above 0, states keep displacements",
              &P::rate)
          .flag("shape_surface", "true: the surface alone; false: the whole body", &P::surface)
          .whole("shape_checks", 0, 10'000, "shapes compared with tight solves after the run", &P::checks);
  return rows;
}

// The motion, and how it is rendered.
SceneRows<Scene> run_rows() {
  using M = SessionModelOptions;
  return SceneRows<Scene>("session", "How the scene is touched and solved. Options of the command prevail.")
      .text("device", "motion of the hand: see forefeel help devices",
            path(&Scene::written, &SceneWritten::device))
      .standard(to_text(S().motion.device))
      .word("clock", clock_words, "", in_session(&S::clock, &ClockOptions::kind))
      .number("seconds", "s", positive(), "length; a motion that ends earlier ends the session",
              in_session(&S::clock, &ClockOptions::seconds))
      .whole("seed", 0, INT64_MAX, "of everything random: device, policy, cost", in_session(&S::seed))
      .flag("record",
            "keep all that comes in, in session.inputs, 7 MB a minute: forefeel replay RUN renders it again",
            in_session(&S::record))
      .word("switch", switch_words, ": how the force changes from one model to the next",
            in_session(&S::switching, &SwitchOptions::rule))
      .word("select", select_words, ": the same as model.select", path(&Scene::model, &ModelOptions::select))
      .standard("that of model")
      .word("method", method_words, ": kind of the models", in_session(&S::model, &M::method))
      .number("update_travel", "spacings", positive(), "travel of the tip after which a model is made anew",
              in_session(&S::model, &M::update_travel))
      .flag("first_guess", "while no state is known, render the body's stiffness at rest",
            in_session(&S::model, &M::first_guess))
      .only_solving()
      .word("passivity", passivity_words, ": control holds back force that would generate energy",
            in_session(&S::safety, &SafetyOptions::passivity))
      .table("jnd", "table: the just noticeable difference", jnd_rows(), in_session(&S::switching))
      .table("limits", "table: the safety rules", limit_rows(), in_session(&S::safety));
}

const SceneRows<Scene>& rows_of_session() {
  static const auto rows =
      run_rows()
          .part("policy", policy_names, ": what is solved next",
                in_session(&S::planning, &PlanningOptions::policy))
          .only_solving()
          .part("predictor", predictor_names, ": where the hand will be",
                in_session(&S::motion, &MotionOptions::predictor))
          .only_solving()
          .rows(planning_rows(), in_session(&S::planning))
          .row({"arrivals", "", "", "file t,x,y,z: states become known at these times and nothing is solved"},
               read_arrivals)
          .whole("workers", 1, 100'000, "workers that solve", in_session(&S::workers, &WorkerOptions::count))
          .only_solving()
          .part("workers_kind", workers_names, "", in_session(&S::workers, &WorkerOptions::kind))
          .only_solving()
          .text("cost", "virtual clock: time of a solve, see forefeel help devices",
                path(&Scene::written, &SceneWritten::cost))
          .standard(to_text(S().workers.cost))
          .only_solving()
          .rows(worker_rows(), in_session(&S::workers))
          .rows(judging_rows(), in_session(&S::judging))
          .rows(shape_rows(), path(&Scene::shape));
  return rows;
}

}  // namespace

const SceneRowList& session_rows() {
  return rows_of_session();
}

void read_session(const SceneTable& table, Scene& scene) {
  rows_of_session().read(table, scene);
  const SessionOptions& session = scene.session;
  if (session.model.method != SessionMethod::rbf && session.planning.placement != Placement::lattice)
    throw table.wrong("placement",
                      fmt::format("lattice with method = \"{}\", which interpolates between lattice states",
                                  *table.text("method")));
  scene.written.device_place = table.where("device");
  scene.written.cost_place = table.where("cost");
  for (const std::string& key : session_rows().of_solving())
    if (table.has(key)) scene.written.scheduling.emplace_back("session." + key, table.where(key));
}

}  // namespace forefeel
