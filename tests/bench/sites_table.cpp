// How well a body's jets at rest, at sites of its surface, answer for a touch anywhere:
//   sites_table [SCENE.toml] [FILE.states]... [PLACES] [SPACING]...
// SCENE: its body; the contact becomes a pad of 1000 N/m and 2 cm (default: the built-in liver). PLACES random (s, x):
// s uniform by area over the unclamped surface, depth 2 to 25 mm, sideways up to half of that (default 500). SPACING of
// the sites [m] (default 0.010). Relative errors of the force against tight solves; none is left out: places whose pad
// reaches over the clamp, and solves that fail, are counted apart. FILE.states: of generate with --error; a row for
// field and states, over the field of the last SPACING.
#include <omp.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <functional>
#include <numbers>
#include <string>

#include "apps/scene/field_check.hpp"
#include "apps/scene/scene.hpp"
#include "apps/scene/scene_anywhere.hpp"
#include "geometry/common/error.hpp"
#include "geometry/states/state_file.hpp"
#include "solver/equilibrium/solver.hpp"
#include "solver/jet/site_field.hpp"

namespace {

using namespace forefeel;

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

struct Place {
  SurfacePlace site;
  Vec3 x = Vec3::Zero(), force = Vec3::Zero();
  double depth = 0, clamped_share = 0;
  bool solved = false;
};

std::vector<Place> draw(const RestSites& sites, int count) {
  std::mt19937_64 random(20241);  // not the places that generate solves
  std::uniform_real_distribution<double> share(0, 1);
  std::vector<Place> places(static_cast<std::size_t>(count));
  for (Place& place : places) {
    place.site = sites.map().random(random);
    const SiteRest rest = sites.at(place.site, false);
    const Vec3 n = rest.normal, e = n.unitOrthogonal(), b = n.cross(e);
    place.depth = 0.002 + 0.023 * share(random);
    const double far = 0.5 * place.depth * std::sqrt(share(random)),
                 turn = 2 * std::numbers::pi * share(random);
    place.x = -place.depth * n + far * (std::cos(turn) * e + std::sin(turn) * b);
    place.clamped_share = rest.clamped_share;
  }
  return places;
}

void solve(const Body& body, std::vector<Place>& places) {
#pragma omp parallel for schedule(dynamic)
  for (std::size_t i = 0; i < places.size(); ++i) {
    Body there = body;
    there.pad->site = places[i].site.at;
    const State state = Solver(std::move(there)).reference(places[i].x, 0.006).state;
    places[i].solved = state.usable();
    places[i].force = state.force;
  }
}

void print_row(const std::string& name, std::vector<double> errors) {
  if (errors.empty()) return;
  std::ranges::sort(errors);
  const auto at = [&](double share) {
    return 100 * errors[std::min(errors.size() - 1,
                                 static_cast<std::size_t>(share * static_cast<double>(errors.size())))];
  };
  std::printf("  %-34s %4zu  %8.3f %8.3f %8.3f\n", name.c_str(), errors.size(), at(0.5), at(0.95), at(1));
}

void print_rows(const std::string& name, const std::vector<Place>& places,
                const std::function<Vec3(const Place&)>& force) {
  std::vector<double> near, far, clamped, free;
  for (const Place& place : places) {
    if (!place.solved) continue;
    const double error = (force(place) - place.force).norm() / place.force.norm();
    (place.clamped_share > 0 ? clamped : place.depth <= 0.015 ? near : far).push_back(error);
    if (!(place.clamped_share > 0)) free.push_back(error);
  }
  print_row(name + ", 2 to 25 mm", free);
  print_row(name + ", to 15 mm", near);
  print_row(name + ", 15 to 25 mm", far);
  print_row(name + ", over the clamp", clamped);
}

void print_states(const std::string& file, const std::shared_ptr<const SiteField>& field,
                  const std::vector<Place>& places) {
  const std::vector<State> states = load_states(file).states;
  const auto known = field_with(field, states, omp_get_max_threads());
  const auto deep =
      std::ranges::count_if(states, [](const State& s) { return s.usable() && !s.at.isZero(); });
  const auto failed = std::ranges::count_if(states, [](const State& s) { return !s.usable(); });
  std::printf("%s: %td states (%td failed), %zu jets beside the field's %zu\n", file.c_str(), deep, failed,
              known->size() - static_cast<std::size_t>(deep), field->size());
  std::size_t trusted = 0, wrong = 0, solved = 0;
  print_rows("field and states", places, [&](const Place& p) {
    const SiteModel model = field->at(p.site, false);
    const Vec3 force = known->at(model, p.site, p.x).force;
    const bool trust = known->trusted(model, p.site, p.x, 0.07, 0.01);
    ++solved, trusted += trust, wrong += trust && (force - p.force).norm() > 0.07 * p.force.norm();
    return force;
  });
  std::printf("  trusted to 7 %%: %zu of %zu, %zu of them wrongly\n", trusted, solved, wrong);
}

void print_table(const Body& body, int count, const std::vector<double>& spacings,
                 const std::vector<std::string>& files) {
  const auto begun = std::chrono::steady_clock::now();
  const auto sites = std::make_shared<const RestSites>(std::make_shared<Body>(body), omp_get_max_threads());
  std::printf("%zu elements, %.0f cm2 of free surface, factor and compliance %.3f s\n", body.mesh.tets.size(),
              1e4 * sites->map().free_area(), seconds_since(begun));
  std::vector<Place> places = draw(*sites, count);
  solve(body, places);
  const auto failed = std::ranges::count(places, false, &Place::solved);
  std::printf("%d places, %td of them not solved\n  %-34s %4s  %8s %8s %8s %%\n", count, failed, "", "n",
              "p50", "p95", "max");
  print_rows("K(s) alone", places,
             [&](const Place& p) { return Vec3(-(sites->at(p.site, false).stiffness * p.x)); });
  std::shared_ptr<const SiteField> field;
  for (const double spacing : spacings) {
    const auto start = std::chrono::steady_clock::now();
    field = std::make_shared<const SiteField>(
        sites, SiteFieldOptions{.spacing = spacing, .threads = omp_get_max_threads()});
    std::printf("spacing %g mm: %zu sites, %.2f s\n", 1e3 * spacing, field->size(), seconds_since(start));
    print_rows("field", places, [&](const Place& p) { return field->at(p.site, false).at(p.x).force; });
  }
  for (const std::string& file : files) print_states(file, field, places);
  SiteJets jets(*sites);
  const auto start = std::chrono::steady_clock::now();
  print_rows("a jet at each place", places, [&](const Place& p) {
    const RestJet jet = jets.at(p.site);
    return Vec3(-(jet.stiffness * p.x + jet_terms(jet.jet, p.x).gradient));
  });
  std::printf("a jet takes %.2f ms\n", 1e3 * seconds_since(start) / count);
}

Body body_of(const std::string& file) {
  if (!file.empty())
    if (const Scene scene = load_scene_with_sites(file, {}, {.spacing = false}); is_anywhere(scene)) {
      Body body = *scene.body;
      body.fine.reset();
      return body;
    }
  Body body = *(file.empty() ? built_in_scene() : load_scene(file, {}, nullptr, {.spacing = false})).body;
  body.contact.clear();
  body.pad = Pad{};
  body.fine.reset();
  return body;
}

}  // namespace

int main(int count, char** arguments) {
  std::string scene;
  std::vector<double> numbers;
  std::vector<std::string> files;
  try {
    for (int i = 1; i < count; ++i) {
      const std::string text = arguments[i];
      if (text.ends_with(".toml"))
        scene = text;
      else if (text.ends_with(".states"))
        files.push_back(text);
      else
        numbers.push_back(std::stod(text));
    }
    const int places = numbers.empty() ? 500 : static_cast<int>(numbers[0]);
    std::vector<double> spacings(numbers.begin() + (numbers.empty() ? 0 : 1), numbers.end());
    if (spacings.empty()) spacings = {SiteFieldOptions().spacing};
    print_table(body_of(scene), places, spacings, files);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "sites_table: %s\n", error.what());
    return 2;
  }
}
