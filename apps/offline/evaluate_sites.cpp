#include "apps/offline/evaluate_sites.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>

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
#include "geometry/states/state_file.hpp"

namespace forefeel {
namespace {

struct SitedForce {
  Vec3 site = Vec3::Zero(), at = Vec3::Zero();  // as given; the site on the surface [m]
  FieldForce found;
  double thickness = 0;  // of the body under the site [m]
  bool through = false;  // deeper than that
  bool trusted = false;  // never through the body
};

struct SitedForces {
  std::vector<SitedForce> all;
  std::size_t sites = 0, corrections = 0;
  double seconds = 0;
  FieldErrors error;
};

constexpr Field<SitedForce> sited_columns[] = {
    {"sx,sy,sz", "m", "site, on the surface of the body that is answered for",
     [](Cells& o, const SitedForce& f) { put(o, f.site); }},
    {"x,y,z", "m", "displacement of the tip there", [](Cells& o, const SitedForce& f) { put(o, f.at); }},
    {"fx,fy,fz", "N", "force of the body on the tip",
     [](Cells& o, const SitedForce& f) { put(o, f.found.force); }},
    {"estimate", "N", "of the force's error, from the last degrees of the jets and what states differ by",
     [](Cells& o, const SitedForce& f) { o.word(fmt::format("{:.6g}", f.found.estimate), no_word); }},
    {"thickness", "m", "of the body at rest under the site, against the normal",
     [](Cells& o, const SitedForce& f) { put(o, f.thickness); }},
    {"trusted", "", "1: three times the estimate is within state_space.tolerance, no deeper than thick",
     [](Cells& o, const SitedForce& f) { put(o, f.trusted); }}};

const JsonKeys<SitedForces>& sited_keys() {
  using S = SitedForces;
  static const JsonKeys<S> keys{
      {"points", "", "that were asked for", [](const S& s) { return s.all.size(); }},
      {"points_trusted", "", "of these, where three times the estimate is within state_space.tolerance",
       [](const S& s) { return std::ranges::count(s.all, true, &SitedForce::trusted); }},
      {"through", "", "points deeper than the body is thick there; they are not trusted",
       [](const S& s) { return std::ranges::count(s.all, true, &SitedForce::through); }},
      {"sites", "", "of the field", &S::sites},
      {"corrections", "",
       "jets at rest of other sites, and states, of the file, that correct the field near them",
       &S::corrections},
      {"seconds", "s", "that making or reading the field took", &S::seconds},
      {"states", "", "solved states of the file, against which the field alone is measured",
       [](const S& s) { return s.error.states; }},
      {"error.p50", "1", "median of the relative error of the field's force at the states; null: none",
       [](const S& s) { return s.error.p50; }},
      {"error.p95", "1", "95th percentile of that", [](const S& s) { return s.error.p95; }},
      {"error.max", "1", "largest of that", [](const S& s) { return s.error.max; }},
      {"site", "m", "list: place on the surface of each point"},
      {"at", "m", "list: displacement of the tip at each point"},
      {"forces", "N", "list: force of the body on the tip at each point"},
      {"estimate", "N", "list: estimate of the error of each force"},
      {"thickness", "m", "list: of the body at rest under the site; null: beside a sharp rim"},
      {"trusted", "", "list: three times the estimate is within state_space.tolerance"}};
  return keys;
}

SitedForce force_at(const Scene& scene, const DeepStates& known, const SitedPoint& point,
                    const std::string& file) {
  const SiteField& field = known.field();
  const SurfacePlace place = place_at(field.rest(), point.site, file);
  const SiteModel model = field.at(place, false);
  const Vec3& normal = model.rest().normal;
  SitedForce force{.site = place.at,
                   .at = point.at,
                   .found = field_force(known, model, place, point.at),
                   .thickness = field.rest().map().thickness(place, normal)};
  force.through = -point.at.dot(normal) > force.thickness;
  force.trusted = !force.through && 3 * force.found.estimate <=
                                        scene.spacing.tolerance * std::max(force.found.force.norm(),
                                                                           scene.session.judging.error_floor);
  return force;
}

void write_sited(const std::string& file, const std::vector<SitedForce>& forces) {
  OutputFile out(file);
  out.write(header_of<SitedForce>(sited_columns));
  for (const SitedForce& force : forces) out.write(csv_row<SitedForce>(sited_columns, force));
  out.commit();
}

void print_sited(const Globals& globals, const SitedForces& result, bool with_forces) {
  if (globals.json) {
    Json document = document_of(sited_keys(), result);
    for (const char* key : {"site", "at", "forces", "estimate", "thickness", "trusted"})
      document[key] = Json::array();
    for (const SitedForce& f : result.all) {
      document["site"].push_back(vector3(f.site));
      document["at"].push_back(vector3(f.at));
      document["forces"].push_back(vector3(f.found.force));
      document["estimate"].push_back(number(f.found.estimate));
      document["thickness"].push_back(number(f.thickness));
      document["trusted"].push_back(f.trusted);
    }
    print_json(document);
    return;
  }
  for (const SitedForce& f : result.all) {
    if (!with_forces) break;
    const Vec3 &s = f.site, &x = f.at, &force = f.found.force;
    answer(
        globals,
        fmt::format("s = ({:.6g}, {:.6g}, {:.6g}) m  x = ({:.6g}, {:.6g}, {:.6g}) m  f = ({:.6g}, "
                    "{:.6g}, {:.6g}) N +- {:.2g} N{}",
                    s[0], s[1], s[2], x[0], x[1], x[2], force[0], force[1], force[2], f.found.estimate,
                    f.through   ? fmt::format(", deeper than the body is thick: {:.3g} mm", 1e3 * f.thickness)
                    : f.trusted ? ""
                                : ", not trusted"));
  }
  say(globals, fmt::format("{} from a field of {} and {}", counted(result.all.size(), "point"),
                           counted(result.sites, "site"), counted(result.corrections, "correction")));
  if (result.error.states > 0)
    answer(globals, fmt::format("the field errs by p50 {}, p95 {}, max {} at {}",
                                in_percent(result.error.p50), in_percent(result.error.p95),
                                in_percent(result.error.max), counted(result.error.states, "solved state")));
}

}  // namespace

DeclaredTable evaluate_sites_output() {
  return {"evaluate_sites.json", "Of evaluate --json, with sites.", declared(sited_keys())};
}
DeclaredTable sited_forces_output() {
  return {"forces_sites.csv", "What evaluate writes with -o, with sites.",
          declared<SitedForce>(sited_columns)};
}

bool has_site_columns(const std::string& points) {
  std::ifstream in(points);
  for (std::string line; std::getline(in, line);)
    if (!line.empty() && line.front() != '#') return line.find("sx") != std::string::npos;
  return false;
}

int evaluate_sites(const Globals& globals, const EvaluateSites& wanted) {
  if (wanted.scene.empty())
    throw InputError("--scene",
                     "missing, expected the scene with contact.anywhere = true of points with sites");
  const std::vector<SitedPoint> points = read_sited_points_csv(wanted.points);
  const Scene scene = load_scene_with_sites(wanted.scene, globals.set, {.quiet = globals.quiet});
  if (!is_anywhere(scene))
    throw InputError(wanted.points,
                     "has sites, expected a scene with contact.anywhere = true, or points x,y,z");
  for (const std::string& warning : scene.source.warnings) warn(globals, warning);
  const LoadedStates loaded = load_states(wanted.states);
  if (loaded.damaged > 0) warn(globals, damage_in_words(wanted.states, loaded.damaged));
  belonging_of(globals, scene, wanted.states, loaded.header.identity, loaded.states, false, false);
  if (!wanted.output.empty()) check_writable(wanted.output, {wanted.states, wanted.points});
  const FieldFound found = find_field(scene, globals);
  SitedForces result{
      .all = {}, .sites = found.field->size(), .corrections = 0, .seconds = found.seconds, .error = {}};
  const auto known = field_with(found.field, loaded.states, std::max(1, globals.threads));
  result.corrections = known->size();
  for (const SitedPoint& point : points) result.all.push_back(force_at(scene, *known, point, wanted.points));
  result.error = field_errors(*found.field, loaded.states, scene.session.judging.error_floor);
  if (!wanted.output.empty()) write_sited(wanted.output, result.all);
  print_sited(globals, result, wanted.output.empty());
  if (!wanted.output.empty()) say(globals, fmt::format("forces at the points: {}", wanted.output));
  return 0;
}

}  // namespace forefeel
