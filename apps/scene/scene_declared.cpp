#include "apps/scene/scene_declared.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include "apps/scene/option_names.hpp"
#include "apps/scene/scene_hand.hpp"
#include "apps/scene/scene_keys.hpp"
#include "geometry/meshing/phantom.hpp"
#include "scheduling/motion/predictor.hpp"
#include "scheduling/session/session.hpp"
#include "scheduling/shape/shape_options.hpp"
#include "scheduling/workers/cost_spec.hpp"
#include "scheduling/workers/generator.hpp"
#include "solver/body/body.hpp"
#include "solver/body/law_table.hpp"

namespace forefeel {
namespace {

constexpr const char* needed = "required";

std::string with_mesh(const std::string& of_phantoms) {
  return "required; with a phantom " + of_phantoms;
}

std::string shown(double value) {
  return fmt::format("{}", value);
}
std::string shown(bool value) {
  return value ? "true" : "false";
}
template <class Choice>
std::string words_of(const Words<Choice>& words) {
  std::string text;
  for (const auto& word : words) text += (text.empty() ? "" : " | ") + word.first;
  return text;
}
template <class Choice>
std::string word_of(const Words<Choice>& words, Choice value) {
  const auto found = std::ranges::find(words, value, [](const auto& word) { return word.second; });
  return found == words.end() ? "" : found->first;
}
std::string any_of(const std::vector<std::string>& names) {
  return fmt::format("{}", fmt::join(names, " | "));
}

DeclaredTable body_table() {
  return {"body",
          "What is pressed. One of mesh and phantom.",
          {{"mesh", "", "",
            "volume mesh (.msh .vtk .vtu .mesh), or a surface (.obj .off .stl .ply) with elements"},
           {"phantom", "", "", "built-in body: " + any_of(phantom_names())},
           {"elements", "", "the phantom's own", "tetrahedra to make of a surface or a phantom, within 5 %"},
           {"length", "m", "as in the file", "longest side to scale the body to"},
           {"element", "", "linear", "linear | quadratic tetrahedra"}}};
}

DeclaredTable material_table() {
  std::vector<std::string> laws;
  for (const Law law : all_laws()) laws.emplace_back(name(law));
  const Material soft;
  return {
      "material",
      "The law of the tissue. For several tissues: [[material]] tables, each with a group, and one without.",
      {{"group", "", "", "name of a group of tetrahedra of the mesh; without it, the table is for the rest"},
       {"law", "", with_mesh(std::string(name(soft.law))), any_of(laws)},
       {"young", "Pa", with_mesh(shown(soft.young)), "Young's modulus at small strain"},
       {"poisson", "1", with_mesh(shown(soft.poisson)), "Poisson's ratio, between -1 and 0.5"},
       {"viscosity", "", "",
        "[[material.viscosity]] tables: the tissue relaxes; the same for all materials"}}};
}

DeclaredTable viscosity_table() {
  return {
      "material.viscosity",
      "[[material.viscosity]]: a branch of a generalised Maxwell material. The law gives the force of a fast "
      "press; while the tip is held, it relaxes to (1 - sum of the shares) times that force.",
      {{"share", "1", needed, "share of the force that relaxes, between 0 and 1; their sum is below 1"},
       {"time", "s", needed, "relaxation time, in which that share falls to 37 %"}}};
}

std::vector<DeclaredTable> boundary_tables() {
  return {{"clamp",
           "The nodes that do not move. One of nodes, group and below.",
           {{"nodes", "", "", "node numbers from 0, in the order of the file"},
            {"group", "", "clamp, with a phantom", "name of a node group of the mesh"},
            {"below", "", "", "table: the part of the body at the low end of an axis"}}},
          {"clamp.below",
           "The part of the body that is clamped: clamp.below = { axis = \"z\", share = 0.15 }",
           {{"axis", "", needed, "x | y | z"},
            {"share", "1", needed, "of the body's extent along the axis, between 0 and 1"}}},
          {"contact",
           "The patch that moves with the tip. One of node, nodes, nearest and group.",
           {{"node", "", "", "a node number, from 0"},
            {"nodes", "", "", "node numbers, from 0"},
            {"nearest", "m", "", "[x, y, z]: the surface node nearest to this place of the mesh"},
            {"group", "", "contact, with a phantom", "name of a node group of the mesh"},
            {"radius", "m", "only the nodes named", "also all surface nodes within this distance of them"}}}};
}

DeclaredTable space_table() {
  return {
      "state_space",
      "Where states are placed.",
      {{"spacing", "m", "required; 0.006 with a phantom",
        "side of the lattice of states; \"auto\": measured, so that safe means an error below tolerance"},
       {"box", "m", "required; made of the body with a phantom",
        "[[x0, y0, z0], [x1, y1, z1]] of tip positions, low corner first; rest is [0, 0, 0]"},
       {"displacements", "", "false", "true: states keep the displacements of all nodes"},
       {"tolerance", "1", shown(usual_tolerance),
        "error that spacing = \"auto\" allows where safe, and within which session and classify --bars say "
        "the force is known: a share of the force, or \"0.07 N\""}}};
}

DeclaredTable model_table() {
  const ModelOptions model;
  return {"model",
          "The interpolation of the force between states.",
          {{"kernel", "", "quintic", "linear | cubic | quintic: radial basis function of order 1, 3, 5"},
           {"data", "", "force+stiffness; force with the linear kernel",
            "force | force+stiffness: what is fitted"},
           {"neighbours", "", "25; 100 with data = \"force\"", "states of a model"},
           {"select", "", word_of(select_words(), model.select),
            words_of(select_words()) + ": rule that chooses the neighbours"},
           {"ridge", "1", shown(model.ridge),
            "smoothing for noisy states, added to the kernel's diagonal; 0: none"}}};
}

std::vector<Declared> run_keys(const SessionOptions& s) {
  return {{"device", "", to_text(s.motion.device), "motion of the hand: see forefeel help devices"},
          {"clock", "", word_of(clock_words(), s.clock.kind), words_of(clock_words())},
          {"seconds", "s", shown(s.clock.seconds), "length; a motion that ends earlier ends the session"},
          {"seed", "", "0", "of everything random: device, policy, cost"},
          {"record", "", shown(s.record),
           "keep all that comes in, in session.inputs, 7 MB a minute: forefeel replay RUN renders it again"},
          {"switch", "", word_of(switch_words(), s.switching.rule),
           words_of(switch_words()) + ": how the force changes from one model to the next"},
          {"select", "", "that of model", words_of(select_words()) + ": the same as model.select"},
          {"method", "", word_of(method_words(), s.model.method),
           words_of(method_words()) + ": kind of the models"},
          {"update_travel", "spacings", shown(s.model.update_travel),
           "travel of the tip after which a model is made anew"},
          {"first_guess", "", shown(s.model.first_guess),
           "while no state is known, render the body's stiffness at rest"},
          {"passivity", "", word_of(passivity_words(), s.safety.passivity),
           words_of(passivity_words()) + ": control holds back force that would generate energy"},
          {"jnd", "", "", "table: the just noticeable difference"},
          {"limits", "", "", "table: the safety rules"}};
}

std::vector<Declared> work_keys(const SessionOptions& s) {
  return {
      {"policy", "", s.planning.policy.name, any_of(policy_names()) + ": what is solved next"},
      {"predictor", "", s.motion.predictor.name, any_of(predictor_names()) + ": where the hand will be"},
      {"placement", "", word_of(placement_words(), s.planning.placement),
       words_of(placement_words()) + ": where states may be placed"},
      {"preempt", "", shown(s.planning.preempt), "cancel a running solve where another is worth far more"},
      {"rest_first", "", shown(s.planning.rest_first),
       "where no state is known, solve the state at rest first"},
      {"rest_known", "", shown(s.planning.rest_known), "the state at rest is known from the start"},
      {"batch", "", "8 in real time, 1 under the virtual clock",
       "states solved with one factorisation, 1 to 8; 0: the default"},
      {"audit", "1", shown(s.planning.audit),
       "share of the solves made where the tip has just been, to calibrate the error bars"},
      {"arrivals", "", "", "file t,x,y,z: states become known at these times and nothing is solved"},
      {"workers", "", fmt::format("{}", s.workers.count), "workers that solve"},
      {"workers_kind", "", s.workers.kind.name, any_of(workers_names())},
      {"cost", "", to_text(s.workers.cost), "virtual clock: time of a solve, see forefeel help devices"},
      {"latency", "s", shown(s.workers.latency), "virtual clock: time of a message to or from a worker"},
      {"batch_share", "1", shown(s.workers.batch_share),
       "virtual clock: cost of a state solved with another's factorisation, divided by that state's"}};
}

std::vector<Declared> judging_keys(const SessionOptions& s) {
  return {
      {"error_floor", "N", shown(s.judging.error_floor), "errors are relative to at least this force"},
      {"reference_step", "m", shown(s.judging.reference_step),
       "travel between samples compared with a tight solve"},
      {"visit_cell", "m", "the spacing", "side of the cells whose first visits are compared; 0: the spacing"},
      {"visit_stride", "", fmt::format("{}", s.judging.visit_stride), "every n-th first visit is compared"},
      {"discretisation_error", "", shown(s.judging.discretisation_error),
       "measure once per body what the mesh itself gets wrong; also for generate, evaluate and study"}};
}

std::vector<Declared> shape_keys() {
  const ShapeOptions s;
  return {
      {"shape_rate", "Hz", shown(s.rate),
       "shapes of the body per second, in RUN/shape.pvd; 0: none. Above 0, states keep displacements"},
      {"shape_surface", "", shown(s.surface), "true: the surface alone; false: the whole body"},
      {"shape_checks", "", fmt::format("{}", s.checks), "shapes compared with tight solves after the run"}};
}

std::vector<DeclaredTable> session_tables() {
  const SessionOptions s;
  DeclaredTable session{"session", "How the scene is touched and solved. Options of the command prevail.",
                        run_keys(s)};
  for (const auto& keys : {work_keys(s), judging_keys(s), shape_keys()})
    session.rows.insert(session.rows.end(), keys.begin(), keys.end());
  return {
      session,
      {"session.jnd",
       "The just noticeable difference: max(share |F|, floor).",
       {{"share", "1", shown(s.switching.jnd_share), "of the force"},
        {"floor", "N", shown(s.switching.jnd_floor), "for small forces"}}},
      {"session.limits",
       "Safety rules between the rendered force and the device.",
       {{"force", "N", shown(s.safety.force_limit), "largest force sent; a device's lower limit prevails"},
        {"slew", "N/s", shown(s.safety.slew_limit), "fastest change of the force sent"},
        {"ramp", "s", shown(s.safety.ramp_seconds), "fade-in at the start"},
        {"stale", "s", shown(s.safety.stale_seconds),
         "silence of the planner after which the force fades out"},
        {"coupling", "N/m", "0.95 of the loop's boundary",
         "with passivity = \"control\": largest stiffness rendered"}}}};
}

std::vector<DeclaredTable> all_tables() {
  std::vector<DeclaredTable> tables{body_table(), material_table(), viscosity_table()};
  for (DeclaredTable& table : boundary_tables()) tables.push_back(std::move(table));
  tables.push_back(space_table());
  tables.push_back(model_table());
  for (DeclaredTable& table : session_tables()) tables.push_back(std::move(table));
  tables.push_back({"hand", "The same as session.device = \"hand:PROFILE,…\", in place of it.", hand_keys()});
  return tables;
}

}  // namespace

const std::vector<DeclaredTable>& scene_tables() {
  static const std::vector<DeclaredTable> tables = all_tables();
  return tables;
}

std::vector<std::string> keys_of(const std::string& table) {
  std::vector<std::string> keys;
  for (const DeclaredTable& one : scene_tables()) {
    if (one.name == table) return names_of(one.rows);
    if (table.empty() && one.name.find('.') == std::string::npos) keys.push_back(one.name);
  }
  if (!table.empty()) throw std::logic_error("no declared table of the scene: " + table);
  return keys;
}

}  // namespace forefeel
