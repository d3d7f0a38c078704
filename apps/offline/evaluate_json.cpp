#include "apps/offline/evaluate_json.hpp"

#include <optional>

#include "apps/console/outputs.hpp"
#include "apps/offline/offline_bars.hpp"

namespace forefeel {
namespace {

using R = EvaluateResult;

const ModelOptions& model_of(const R& r) {
  return r.found.options.model;
}
bool is(const R& r, Method method) {
  return r.found.method == method;
}

// The settings of the method; null if it has no such setting.
template <class Value>
Json if_so(bool so, const Value& value) {
  return so ? Json(value) : Json();
}

JsonKeys<R> method_keys() {
  return {{"method", "", "rbf, auto, or an older method",
           [](const R& r) { return r.found.chosen ? "auto" : name(r.found.method); }},
          {"kernel", "",
           "linear, cubic or quintic; gaussian, matern52 or matern32: a Gaussian process; null: the method "
           "has none",
           [](const R& r) {
             const bool network = is(r, Method::rbf_network);
             if (r.found.chosen && r.found.chosen->field)
               return Json(name(r.found.chosen->field->law.smoothness));
             return if_so(is(r, Method::rbf) || is(r, Method::offline_rbf) || network,
                          name(network ? Kernel::cubic : model_of(r).kernel));
           }},
          {"data", "", "force, force+stiffness or jet",
           [](const R& r) {
             return name(is(r, Method::rbf) || is(r, Method::offline_rbf) ? model_of(r).data : Data::force);
           }},
          {"neighbours", "", "of each model; null: the method has none",
           [](const R& r) { return if_so(is(r, Method::rbf), model_of(r).neighbours); }},
          {"centres", "", "of rbf-network; else null",
           [](const R& r) { return if_so(is(r, Method::rbf_network), r.found.options.centres); }},
          {"select", "", "label or nearest; null: the method has none",
           [](const R& r) { return if_so(is(r, Method::rbf), name(model_of(r).select)); }},
          {"ridge", "1", "null: the method has none", [](const R& r) {
             return if_so(is(r, Method::rbf) || is(r, Method::offline_rbf), model_of(r).ridge);
           }}};
}

double ridge_of(const FieldLaw& law) {
  return law.noise * law.noise / (law.amplitude * law.amplitude);
}

JsonKeys<Evaluation> chosen_keys() {
  using E = Evaluation;
  return {{"kernel,neighbours,ridge", "",
           "method auto: the model that was chosen; kernel gaussian, matern52 or matern32: a Gaussian "
           "process, where "
           "it is unsure blended with a thin plate spline; its ridge is the variance of the noise over that "
           "of the "
           "field; with 120 neighbours its law is sought anew at each place",
           [](const E& e) {
             const ModelOptions& model = e.options.model;
             if (const auto& field = e.chosen->field)
               return Json{name(field->law.smoothness), model.neighbours, ridge_of(field->law)};
             return Json{name(model.kernel), model.neighbours, model.ridge};
           }},
          {"all_states", "", "true: one model of all states", [](const E& e) { return e.chosen->all; }},
          {"select,data", "", "of the chosen model", [](const E& e) {
             return Json{name(e.options.model.select), name(e.options.model.data)};
           }}};
}

JsonKeys<AutoModel> expected_error_keys() {
  using A = AutoModel;
  return {
      {"p50,p95", "N", "error of known forces left out in groups",
       [](const A& a) {
         return json_numbers({a.p50, a.p95});
       }},
      {"positions,groups", "", "left out, and in how many groups",
       [](const A& a) {
         return Json{a.positions, a.groups};
       }},
      {"beyond", "", "points farther from the states than any force left out", &A::beyond},
      {"alike", "", "what was left out lies as far from the rest as the points from the states", &A::alike},
      {"across", "", "p95 is that of points across the states: stiffness along them times the distance",
       &A::across}};
}

JsonKeys<FieldOptions> field_keys() {
  using F = FieldOptions;
  return {{"smoothness", "", "of the field: gaussian, matern52 or matern32",
           [](const F& f) { return name(f.law.smoothness); }},
          {"length", "m", "over which the force changes", [](const F& f) { return f.law.length; }},
          {"amplitude", "N", "of one component of the force about its mean",
           [](const F& f) { return f.law.amplitude; }},
          {"noise", "N", "deviation of one component of one measured force; given, or estimated",
           [](const F& f) { return f.law.noise; }},
          {"stiffest", "N/m", "largest stiffness seen along the states; given: a third of --stiffest",
           &F::stiffest}};
}

// A list with an entry for each of these.
template <class Values, class Get>
Json list_of(const Values& values, Get get) {
  Json list = Json::array();
  for (const auto& value : values) list.push_back(*json_value(std::invoke(get, value)));
  return list;
}

JsonKeys<R> point_keys() {
  return {
      {"forces", "N", "list: approximated force of the body on the tip at each point",
       [](const R& r) { return list_of(r.found.made.forces, [](const Vec3& f) { return f; }); }},
      {"values", "",
       "list: approximated value at each point, for states that tell one value each (also forces' first "
       "component); "
       "null: they tell forces",
       [](const R& r) {
         return r.value.empty() ? Json() : list_of(r.found.made.forces, [](const Vec3& f) { return f.x(); });
       }},
      {"labels", "", "list: coverage of each point",
       [](const R& r) { return list_of(r.found.made.labels, [](Label label) { return name(label); }); }},
      {"trusted", "", "list: whether the jets of each point are within their trust; null: --data is not jet",
       [](const R& r) {
         const std::vector<char>& trusted = r.found.made.trusted;
         return trusted.empty() ? Json() : list_of(trusted, [](char yes) { return yes != 0; });
       }},
      {"kernels", "", "list: kernel of each point, after step-down",
       [](const R& r) { return r.found.made.kernels; }},
      {"stepped_down", "", "points whose states did not determine the wanted kernel",
       [](const R& r) { return r.found.made.stepped_down; }},
      {"fit_us", "us", "median time to make or change a model", [](const R& r) { return r.found.fit_us; }},
      {"evaluate_ns", "ns", "median time of a force", [](const R& r) { return r.found.evaluate_ns; }},
      {"fitted", "", "points whose model was made anew", [](const R& r) { return r.found.made.fitted; }},
      {"updated", "", "points whose model was changed", [](const R& r) { return r.found.made.updated; }},
      {"reused", "", "points whose model was kept", [](const R& r) { return r.found.made.reused; }}};
}

JsonKeys<R> later_keys() {
  return {
      {"spacing", "m", "that counts as dense", [](const R& r) { return r.found.options.spacing; }},
      {"far_row_left_out", "",
       "true: a row far from all others and from all points has no part in the forces",
       [](const R& r) { return r.found.far_row_left_out; }},
      {"heaped", "", "rows of heaps, each counted as one place", [](const R& r) { return r.found.heaped; }},
      {"averaged", "", "states that contradicted another at their position",
       [](const R& r) { return r.found.repeated.averaged; }},
      {"largest_difference", "N", "between two of these",
       [](const R& r) { return r.found.repeated.largest_difference; }},
      {"rounding,courses", "N",
       "part of the expected error and of the bars: of forces rounded to steps, and of forces at one "
       "position that differ alike along the states, as in loading and unloading",
       [](const R& r) {
         return Json{r.found.shared.rounding, r.found.shared.courses};
       }},
      {"belonging", "", "own or foreign states; null: not known",
       [](const R& r) { return r.belonging ? Json(name(*r.belonging)) : Json(); }},
      {"force_bounds", "N", "list: no force of the point's model is larger",
       [](const R& r) { return list_of(r.found.made.reach, &Reach::bound); }},
      {"tangent_from", "m",
       "list: distance outside the states from where on the tangent is used; null: never",
       [](const R& r) { return list_of(r.found.made.reach, &Reach::tangent); }},
      {"held_from", "m", "list: distance from where on the force is constant; null: never",
       [](const R& r) { return list_of(r.found.made.reach, &Reach::held); }}};
}

const JsonKeys<R>& evaluate_keys() {
  static const JsonKeys<R> keys = [] {
    static const MeshError no_scene{.why = "no scene is given"};
    JsonKeys<R> all = point_keys();
    const auto add = [&](const JsonKeys<R>& more) { all.insert(all.end(), more.begin(), more.end()); };
    add(method_keys());
    add({json_object<R>("chosen", chosen_keys(), "null: nothing was chosen",
                        [](const R& r) { return r.found.chosen ? &r.found : nullptr; }),
         json_object<R>("expected_error", expected_error_keys(), "null: no model was chosen",
                        [](const R& r) { return r.found.chosen ? &*r.found.chosen : nullptr; }),
         {"groups", "",
          "number of independent groups that the expected error rests on; null: no model was chosen",
          [](const R& r) { return r.found.chosen ? Json(r.found.chosen->groups) : Json(); }},
         json_object<R>(
             "field", field_keys(),
             "of measured states, by a Gaussian process, for bars and for the choice of a model; null: no "
             "such states, or neither asked",
             [](const R& r) { return r.found.field ? &*r.found.field : nullptr; }),
         JsonKey<R>(declared(bar_keys()), [](Json& document, const R& r) {
           if (r.found.bars) add_to(document, bar_keys(), BarsShown{.bars = &*r.found.bars});
         }).last()});
    add({json_part<R>(mesh_error_keys(), [](const R& r) { return r.mesh ? &*r.mesh : &no_scene; })});
    all.back().rows.front().meaning.insert(0, "with --scene: ");
    add(later_keys());
    return all;
  }();
  return keys;
}

}  // namespace

Json to_json(const EvaluateResult& evaluated) {
  return document_of(evaluate_keys(), evaluated);
}

DeclaredTable evaluate_output() {
  return {"evaluate.json", "Of evaluate --json.", declared(evaluate_keys())};
}

}  // namespace forefeel
