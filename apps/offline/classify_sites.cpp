#include "apps/offline/classify_sites.hpp"

#include <fmt/format.h>
#include <omp.h>

#include <algorithm>
#include <cmath>

#include "apps/console/document_keys.hpp"
#include "apps/console/json.hpp"
#include "apps/console/outputs.hpp"
#include "apps/scene/field_check.hpp"
#include "apps/scene/given_states.hpp"
#include "apps/scene/scene_anywhere.hpp"
#include "apps/scene/scene_field.hpp"
#include "geometry/common/counted.hpp"
#include "geometry/common/error.hpp"
#include "geometry/common/field.hpp"
#include "geometry/common/output_file.hpp"
#include "geometry/coverage/sited_labels.hpp"

namespace forefeel {
namespace {

constexpr std::size_t sampled_places = 1000;

struct LabelledPlace {
  SitedPlace place;
  Label label = Label::blank;
  std::size_t near = 0;  // states that the label comes from
  double estimate = unknown;
  bool trusted = false;
};

struct ClassifiedSites {
  std::vector<LabelledPlace> places;
  std::size_t sites = 0, states = 0, unusable = 0;
  double site_spacing = unknown, depth = unknown, spacing = unknown;
  double seconds = 0;

  double share_of(Label label) const {
    return mean([&](const LabelledPlace& p) { return p.label == label; });
  }
  double trusted() const { return mean(&LabelledPlace::trusted); }
  double trusted_in(Label label) const {
    std::size_t all = 0, good = 0;
    for (const LabelledPlace& p : places)
      if (p.label == label) ++all, good += p.trusted;
    return all > 0 ? static_cast<double>(good) / static_cast<double>(all) : unknown;
  }

 private:
  template <class Is>
  double mean(Is is) const {
    return static_cast<double>(std::ranges::count_if(places, is)) / static_cast<double>(places.size());
  }
};

constexpr Field<LabelledPlace> place_columns[] = {
    {"sx,sy,sz", "m", "site, on the surface of the body that is answered for",
     [](Cells& o, const LabelledPlace& p) { put(o, p.place.site.at); }},
    {"x,y,z", "m", "displacement of the tip there",
     [](Cells& o, const LabelledPlace& p) { put(o, p.place.x); }},
    {"label", "", "safe, sparse, gap or blank", [](Cells& o, const LabelledPlace& p) { put(o, p.label); }},
    {"near", "", "states near the site, that the label comes from",
     [](Cells& o, const LabelledPlace& p) { put(o, p.near); }},
    {"estimate", "N", "of the error of the force from field and states",
     [](Cells& o, const LabelledPlace& p) { put(o, p.estimate); }},
    {"trusted", "", "1: three times the estimate is within state_space.tolerance",
     [](Cells& o, const LabelledPlace& p) { put(o, p.trusted); }}};

const JsonKeys<ClassifiedSites>& classified_sites_keys() {
  using S = ClassifiedSites;
  static const JsonKeys<S> keys = [] {
    JsonKeys<S> all{{"places", "", "of --points, or drawn: sites by area, displacements as states are placed",
                     [](const S& s) { return s.places.size(); }},
                    {"sites", "", "of the field of jets at rest", &S::sites},
                    {"states", "", "usable, of the file, those of the field's sites included", &S::states},
                    {"unusable", "", "failed solves in the file", &S::unusable},
                    {"site_spacing", "m", "states whose sites are nearer label a place", &S::site_spacing},
                    {"depth", "m", "to which states are placed", &S::depth},
                    {"spacing", "m", "that counts as dense", &S::spacing},
                    {"trusted", "1",
                     "share of the places where three times the model's estimate is within "
                     "state_space.tolerance",
                     [](const S& s) { return s.trusted(); }},
                    {"seconds", "s", "of all", &S::seconds}};
    for (const Label label : all_labels) {
      const std::string label_name(name(label));
      all.push_back({"share." + label_name, "1", "of the places, by area and displacement",
                     [label](const S& s) { return s.share_of(label); }});
      all.push_back({"trusted_in." + label_name, "1", "of the places with this label; null: none",
                     [label](const S& s) { return s.trusted_in(label); }});
    }
    return all;
  }();
  return keys;
}

void check_site_arguments(const ClassifyArguments& arguments) {
  const auto refuse = [](bool given, const char* option) {
    if (given) throw InputError(option, "is for states of one place, expected states without sites");
  };
  refuse(arguments.space.index != "delaunay", "--index octree");
  refuse(!arguments.space.box.empty(), "--box");
  refuse(!arguments.places.line.empty(), "--line");
  refuse(arguments.places.grid.has_value(), "--grid");
  refuse(arguments.agreement, "--agreement");
  refuse(arguments.bars, "--bars");
  if (arguments.input.scene.empty())
    throw InputError("--scene",
                     "missing, expected the scene with contact.anywhere = true of states with sites");
  if (!arguments.output.empty() && !arguments.output.ends_with(".csv"))
    throw InputError(arguments.output,
                     "expected .csv for states with sites; a picture: forefeel show --trust");
}

std::vector<SitedPlace> wanted_places(const ClassifyArguments& arguments, const RestSites& rest, double depth,
                                      unsigned seed) {
  if (arguments.places.points.empty()) return random_places(rest, {}, depth, sampled_places, "--scene", seed);
  std::vector<SitedPlace> places;
  for (const SitedPoint& point : read_sited_points_csv(arguments.places.points))
    places.push_back({.site = place_at(rest, point.site, arguments.places.points), .x = point.at});
  return places;
}

SitedLabels labels_of(const SiteField& field, const StatesInFrame& set, const StateSpaceOptions& spaces,
                      double depth) {
  std::vector<SitedState> all;
  for (std::size_t i = 0; i < field.size(); ++i)
    all.push_back({field.place(i).at, field.rest().pad().normal(field.place(i)), Vec3::Zero()});
  for (const State& state : set.states)
    if (state.usable() && !state.at.isZero())
      all.push_back(
          {state.site, field.rest().pad().normal(field.rest().map().nearest(state.site)), state.at});
  return SitedLabels(std::move(all), spaces, depth, field.options().spacing);
}

void print_classified_sites(const Globals& globals, const ClassifiedSites& found, bool listed) {
  if (globals.json) {
    print_json(document_of(classified_sites_keys(), found));
    return;
  }
  for (const LabelledPlace& p : found.places) {
    if (!listed) break;
    const Vec3 &s = p.place.site.at, &x = p.place.x;
    answer(globals,
           fmt::format("s = ({:.6g}, {:.6g}, {:.6g}) m  x = ({:.6g}, {:.6g}, {:.6g}) m  {:<6}  {}", s[0],
                       s[1], s[2], x[0], x[1], x[2], name(p.label), p.trusted ? "trusted" : "not trusted"));
  }
  answer(globals,
         fmt::format("{} over a field of {}; {} {}", counted(found.states, "state"),
                     counted(found.sites, "site"), counted(found.places.size(), "place"),
                     listed ? "of --points" : "by area and displacement, to the depth of the states"));
  for (const Label label : all_labels) {
    const double share = found.share_of(label), trusted = found.trusted_in(label),
                 error = std::sqrt(share * (1 - share) / static_cast<double>(found.places.size()));
    answer(globals, fmt::format("  {:<6} {:5.1f} +- {:.1f} %{}", name(label), 100 * share, 100 * error,
                                std::isfinite(trusted)
                                    ? fmt::format(", the force trusted in {:.0f} % of it", 100 * trusted)
                                    : ""));
  }
}

}  // namespace

bool has_sites(const StatesInFrame& set) {
  return std::ranges::any_of(set.states, &State::has_site);
}

DeclaredTable classify_sites_output() {
  return {"classify_sites.json", "Of classify --json, for states with sites.",
          declared(classified_sites_keys())};
}
DeclaredTable labelled_sites_output() {
  return {"labels_sites.csv", "What classify writes with -o, for states with sites.",
          declared<LabelledPlace>(place_columns)};
}

int classify_sites(const Globals& globals, const ClassifyArguments& arguments, const StatesInFrame& set) {
  check_site_arguments(arguments);
  const auto start = std::chrono::steady_clock::now();
  const Scene scene = load_scene_with_sites(arguments.input.scene, globals.set, {.quiet = globals.quiet});
  if (!is_anywhere(scene))
    throw InputError(arguments.input.states, "has sites, expected a scene with contact.anywhere = true");
  for (const std::string& warning : scene.source.warnings) warn(globals, warning);
  belonging_of(globals, scene, arguments.input.states, set.own.identity, set.states, arguments.input.foreign);
  const FieldFound field = find_field(scene, globals);
  const int threads = globals.threads > 0 ? globals.threads : omp_get_max_threads();
  const auto known = field_with(field.field, set.states, threads);
  const double depth = scene.touch.anywhere->depth;
  StateSpaceOptions spaces;
  spaces.spacing = arguments.space.spacing.value_or(scene.space.spacing);
  spaces.coverage = arguments.space.coverage;
  ClassifiedSites found{.places = {},
                        .sites = field.field->size(),
                        .site_spacing = field.field->options().spacing,
                        .depth = depth,
                        .spacing = spaces.spacing};
  found.states = static_cast<std::size_t>(std::ranges::count_if(set.states, &State::usable));
  found.unusable = set.states.size() - found.states;
  for (const SitedPlace& place : wanted_places(arguments, field.field->rest(), depth, 7))
    found.places.push_back({.place = place});
  SitedLabels labels = labels_of(*field.field, set, spaces, depth);
  for (LabelledPlace& p : found.places) {
    p.label = labels.at({p.place.site.at, field.field->rest().pad().normal(p.place.site), p.place.x});
    p.near = labels.states_near();
  }
#pragma omp parallel for schedule(dynamic, 8) num_threads(threads)
  for (std::size_t i = 0; i < found.places.size(); ++i) {
    LabelledPlace& p = found.places[i];
    const SiteModel model = field.field->at(p.place.site, false);
    p.estimate = known->estimated_error(model, p.place.site, p.place.x);
    p.trusted = known->trusted(model, p.place.site, p.place.x, scene.spacing.tolerance,
                               scene.session.judging.error_floor);
  }
  found.seconds = seconds_since(start);
  if (!arguments.output.empty()) {
    OutputFile out(arguments.output);
    out.write(header_of<LabelledPlace>(place_columns));
    for (const LabelledPlace& p : found.places) out.write(csv_row<LabelledPlace>(place_columns, p));
    out.commit();
    say(globals, fmt::format("labels of the places: {}", arguments.output));
  }
  print_classified_sites(globals, found, !arguments.places.points.empty());
  return 0;
}

}  // namespace forefeel
