#pragma once
// A liver phantom that may be touched anywhere, and options of a virtual session on it.

#include <memory>
#include <random>
#include <utility>

#include "geometry/meshing/phantom.hpp"
#include "scheduling/session/session.hpp"
#include "scheduling/touch/session_surface.hpp"
#include "scheduling/touch/surface_models.hpp"
#include "solver/body/pad.hpp"

namespace forefeel::test {

inline DrawPlaces draw_from(const RestSites& rest) {
  return [&rest](const std::string&, std::size_t count, std::uint64_t seed) {
    std::mt19937_64 random(seed + 1);
    std::vector<SurfacePlace> places;
    while (places.size() < count)
      if (const SurfacePlace place = rest.map().random(random); !(rest.at(place, false).clamped_share > 0))
        places.push_back(place);
    return places;
  };
}

inline SessionInput made_liver(Law law) {
  auto body = std::make_shared<Body>();
  body->mesh = phantom("liver", 600);
  body->material = {law, 5000, 0.4};
  body->clamp = body->mesh.groups.at("clamp");
  body->pad = Pad{};
  const auto field = std::make_shared<const SiteField>(std::make_shared<const RestSites>(body, 2),
                                                       SiteFieldOptions{.spacing = 0.015, .threads = 2});
  TouchTask task{.field = field,
                 .grid = std::make_shared<const SurfaceGrid>(field->rest().map()),
                 .patches = std::make_shared<const FieldPatches>(field),
                 .surface = nullptr,
                 .friction = {}};
  task.surface =
      std::make_shared<const SessionSurface>(field->rest(), *task.grid, task.depth, draw_from(field->rest()));
  SessionInput input;
  input.touched.body = body;
  input.touched.space.box = task.surface->box();
  input.touched.anywhere = std::make_shared<const TouchTask>(std::move(task));
  return input;
}

inline const SessionInput& liver() {
  static const SessionInput input = made_liver(Law::neo_hookean);
  return input;
}

inline const TouchTask& liver_task() {
  return *liver().touched.anywhere;
}

// The liver's session with another task.
template <class Change>
SessionInput liver_with(Change change) {
  SessionInput input = liver();
  TouchTask task = *input.touched.anywhere;
  change(task);
  input.touched.anywhere = std::make_shared<const TouchTask>(std::move(task));
  return input;
}

inline SessionOptions options_for(PathName path, double depth, double seconds) {
  SessionOptions options;
  options.clock = {.kind = Clock::virtual_time, .seconds = seconds};
  options.motion.device = DeviceSpec(PathMotion{.path = path, .depth = depth, .where = ""});
  options.workers.count = 2;
  options.seed = 3;
  options.judging.reference_step = 0.004;
  options.judging.visit_stride = 4;
  options.workers.threads = 2;
  return options;
}

}  // namespace forefeel::test
