#include "apps/evaluate/evaluate_json.hpp"

#include <nlohmann/json.hpp>
#include <utility>

#include "apps/console/json.hpp"
#include "apps/console/json_keys.hpp"
#include "apps/evaluate/offline_bars.hpp"

namespace forefeel {
namespace {

// The settings of the method; null if it has no such setting.
void describe(nlohmann::ordered_json& document, const Evaluation& result) {
  const ModelOptions& model = result.options.model;
  const bool moving = result.method == Method::rbf, offline = result.method == Method::offline_rbf,
             network = result.method == Method::rbf_network;
  const auto if_so = [&](const char* key, bool so, nlohmann::ordered_json value) {
    document[key] = so ? std::move(value) : nlohmann::ordered_json();
  };
  if_so("kernel", moving || offline || network, name(network ? Kernel::cubic : model.kernel));
  if_so("data", true, name(moving || offline ? model.data : Data::force));
  if_so("neighbours", moving, model.neighbours);
  if_so("centres", network, result.options.centres);
  if_so("select", moving, name(model.select));
  if_so("ridge", moving || offline, model.ridge);
}

// Describes the chosen model; null if none was chosen, or if there are too few states for a choice.
void describe_choice(nlohmann::ordered_json& document, const Evaluation& result) {
  document["chosen"] = nullptr;
  document["expected_error"] = nullptr;
  if (!result.chosen) return;
  const ModelOptions& model = result.options.model;
  document["chosen"] = {{"kernel", name(model.kernel)}, {"neighbours", model.neighbours},
                        {"ridge", model.ridge},         {"all_states", result.chosen->all},
                        {"select", name(model.select)}, {"data", name(model.data)}};
  document["expected_error"] = {{"p50", number(result.chosen->p50)},
                                {"p95", number(result.chosen->p95)},
                                {"positions", result.chosen->positions},
                                {"groups", result.chosen->groups},
                                {"beyond", result.chosen->beyond}};
}

}  // namespace

nlohmann::ordered_json to_json(const EvaluateResult& evaluated) {
  const Evaluation& result = evaluated.found;
  nlohmann::ordered_json document;
  document["forces"] = nlohmann::ordered_json::array();
  document["labels"] = nlohmann::ordered_json::array();
  for (const Vec3& f : result.made.forces) document["forces"].push_back(vector3(f));
  for (const Label label : result.made.labels) document["labels"].push_back(name(label));
  document["kernels"] = result.made.kernels;
  document["stepped_down"] = result.made.stepped_down;
  document["fit_us"] = number(result.fit_us);
  document["evaluate_ns"] = number(result.evaluate_ns);
  document["fitted"] = result.made.fitted;
  document["updated"] = result.made.updated;
  document["reused"] = result.made.reused;
  document["method"] = result.chosen ? "auto" : name(result.method);
  describe(document, result);
  describe_choice(document, result);
  if (result.bars) describe_bars(document, result.bars);
  add_to(document, evaluated.mesh.value_or(MeshError{.why = "no scene is given"}));
  document["spacing"] = number(result.options.spacing);
  document["averaged"] = result.repeated.averaged;
  document["largest_difference"] = result.repeated.largest_difference;
  document["belonging"] = nullptr;
  if (evaluated.belonging) document["belonging"] = name(*evaluated.belonging);
  for (const char* key : {"force_bounds", "tangent_from", "held_from"})
    document[key] = nlohmann::ordered_json::array();
  for (const Reach& reach : result.made.reach) {
    document["force_bounds"].push_back(number(reach.bound));
    document["tangent_from"].push_back(number(reach.tangent));
    document["held_from"].push_back(number(reach.held));
  }
  return document;
}

std::vector<Declared> declared_evaluate_json() {
  return {{"forces", "N", "", "list: approximated force of the body on the tip at each point"},
          {"labels", "", "", "list: coverage of each point"},
          {"kernels", "", "", "list: kernel of each point, after step-down"},
          {"stepped_down", "", "", "points whose states did not determine the wanted kernel"},
          {"fit_us", "us", "", "median time to make or change a model"},
          {"evaluate_ns", "ns", "", "median time of a force"},
          {"fitted", "", "", "points whose model was made anew"},
          {"updated", "", "", "points whose model was changed"},
          {"reused", "", "", "points whose model was kept"},
          {"method", "", "", "rbf, auto, or an older method"},
          {"kernel", "", "", "linear, cubic or quintic; null: the method has none"},
          {"data", "", "", "force or force+stiffness"},
          {"neighbours", "", "", "of each model; null: the method has none"},
          {"centres", "", "", "of rbf-network; else null"},
          {"select", "", "", "label or nearest; null: the method has none"},
          {"ridge", "1", "", "null: the method has none"},
          {"chosen", "", "", "null: nothing was chosen"},
          {"chosen.kernel,neighbours,ridge,select,data", "", "", "method auto: the model that was chosen"},
          {"chosen.all_states", "", "", "true: one model of all states"},
          {"expected_error", "", "", "null: no model was chosen"},
          {"expected_error.p50,p95", "N", "", "error of known forces left out in groups"},
          {"expected_error.positions,groups", "", "", "left out, and in how many groups"},
          {"expected_error.beyond", "", "", "points farther from the states than any force left out"},
          {"discretisation_error", "1", "",
           "with --scene: what the mesh itself gets wrong, relative; null: not measured"},
          {"discretisation_positions", "", "", "at which it was measured"},
          {"discretisation_by", "", "", "by what, or why not"},
          {"spacing", "m", "", "that counts as dense"},
          {"averaged", "", "", "states that contradicted another at their position"},
          {"largest_difference", "N", "", "between two of these"},
          {"belonging", "", "", "own or foreign states; null: not known"},
          {"force_bounds", "N", "", "list: no force of the point's model is larger"},
          {"tangent_from", "m", "",
           "list: distance outside the states from where on the tangent is used; null: never"},
          {"held_from", "m", "", "list: distance from where on the force is constant; null: never"}};
}

std::vector<Declared> declared_forces() {
  return {{"x,y,z", "m", "", "position"},
          {"fx,fy,fz", "N", "", "approximated force of the body on the tip"},
          {"label", "", "", "coverage there: safe, sparse, gap or blank"}};
}

}  // namespace forefeel
