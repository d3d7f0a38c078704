#include "apps/scene/scene_session.hpp"

#include <fmt/format.h>

#include <chrono>
#include <filesystem>
#include <random>
#include <utility>
#include <variant>

#include "apps/console/console.hpp"
#include "apps/scene/cache_folder.hpp"
#include "apps/scene/field_check.hpp"
#include "apps/scene/scene_anywhere.hpp"
#include "apps/scene/scene_field.hpp"
#include "apps/scene/scene_fine.hpp"
#include "apps/scene/spec_text.hpp"
#include "geometry/common/error.hpp"
#include "scheduling/touch/session_surface.hpp"
#include "scheduling/touch/surface_models.hpp"

namespace forefeel {

SessionInput session_input(const Scene& scene) {
  return {.touched = {.body = scene.body,
                      .identity = scene.identity,
                      .space = scene.space,
                      .displacements = scene.kept.displacements,
                      .jet = scene.kept.jet,
                      .inward = scene.inward,
                      .viscosity = scene.touch.viscosity},
          .files = {.cache = cache_folder(),
                    .scene = std::filesystem::absolute(scene.source.file).parent_path()}};
}

SessionOptions session_options(const Scene& scene) {
  SessionOptions options = scene.session;
  options.motion.device = device_of(scene);
  options.workers.cost = cost_of(scene);
  palpate(scene, false, options);
  return options;
}

DeviceSpec device_of(const Scene& scene) {
  return scene.written.device ? device_from_text(*scene.written.device) : DeviceSpec();
}

CostSpec cost_of(const Scene& scene) {
  return scene.written.cost ? cost_from_text(*scene.written.cost) : CostSpec();
}

// ---- of a scene with contact.anywhere = true
namespace {

DrawPlaces draw_from(const RestSites& rest) {
  return [&rest](const std::string& text, std::size_t count, std::uint64_t seed) {
    constexpr int most_tries = 20'000;
    const SurfacePart part = surface_part(text, rest.body(), "device: where");
    std::mt19937_64 random(seed + 1);
    std::vector<SurfacePlace> places;
    for (int tries = 0; places.size() < count && tries < most_tries; ++tries) {
      const SurfacePlace place = rest.map().random(random);
      if (holds(part, rest.map(), place) && !(rest.at(place, false).clamped_share > 0))
        places.push_back(place);
    }
    if (places.size() < count)
      throw InputError(
          "device: where",
          fmt::format("is '{}', which holds no surface away from the clamp, expected some", text));
    return places;
  };
}

}  // namespace

std::optional<SessionField> touch_anywhere(const Scene& scene, const Globals& globals, SessionInput& input,
                                           const SessionInput* like) {
  if (!is_anywhere(scene)) return {};
  const TouchTask* same = like ? like->touched.anywhere.get() : nullptr;
  const FieldFound found = same ? FieldFound{.field = same->field, .kept = true} : find_field(scene, globals);
  const auto start = std::chrono::steady_clock::now();
  auto task = std::make_shared<TouchTask>();
  task->field = found.field;
  task->grid = same ? same->grid : std::make_shared<const SurfaceGrid>(found.field->rest().map());
  task->patches = same ? same->patches : find_patches(scene, found.field, globals);
  task->depth = scene.touch.anywhere->depth;
  task->friction = scene.touch.anywhere->friction;
  task->tolerance = scene.spacing.tolerance;
  task->floor = scene.session.judging.error_floor;
  const RestSites& rest = found.field->rest();
  task->surface = std::make_shared<const SessionSurface>(rest, *task->grid, task->depth, draw_from(rest));
  input.touched.body = std::shared_ptr<const Body>(found.field, &rest.body());
  input.touched.space.box = task->surface->box();
  input.touched.anywhere = task;
  return SessionField{.sites = found.field->size(),
                      .spacing = task->site_spacing(),
                      .depth = task->depth,
                      .seconds = found.seconds,
                      .patches = seconds_since(start),
                      .kept = found.kept,
                      .friction = task->friction};
}

void palpate(const Scene& scene, bool own_device, SessionOptions& options) {
  if (!is_anywhere(scene)) return;
  if (!own_device && !scene.written.device)
    options.motion.device = DeviceSpec(PathMotion{.path = PathName::palpation});
  if (const auto* hand = std::get_if<HandMotion>(&options.motion.device.motion());
      hand && hand->target.path == PathName::press) {
    HandMotion palpating = *hand;
    palpating.target.path = PathName::palpation;
    options.motion.device = DeviceSpec(palpating);
  }
}

std::vector<State> states_for_touch(const SessionInput& input, std::vector<State> states) {
  const SiteField& field = *input.touched.anywhere->field;
  const auto is_of_field = [&](const State& state) {
    if (!state.at.isZero(0)) return false;
    for (std::size_t i = 0; i < field.size(); ++i)
      if ((field.place(i).at - state.site).norm() < 1e-9) return true;
    return false;
  };
  std::erase_if(
      states, [&](const State& state) { return !state.usable() || !state.has_site() || is_of_field(state); });
  return states;
}

const JsonKeys<SessionField>& session_field_keys() {
  using N = SessionField;
  static const JsonKeys<N> keys{
      {"sites", "", "places whose jets at rest make the field; of a session with contact.anywhere",
       &N::sites},
      {"spacing", "m", "of these places", &N::spacing},
      {"depth", "m", "to which states are placed", &N::depth},
      {"friction", "1", "coefficient; null: bonded", [](const N& n) { return n.friction; }},
      {"seconds", "s", "that making or reading it took", &N::seconds},
      {"patches", "s", "that making or reading its polynomials over the facets took", &N::patches},
      {"kept", "", "true: it was read from the cache", &N::kept}};
  return keys;
}

}  // namespace forefeel
