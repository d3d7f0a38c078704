#include "apps/scene/scene_anywhere.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "apps/scene/scene_fine.hpp"
#include "apps/scene/scene_nodes.hpp"
#include "geometry/common/error.hpp"
#include "scheduling/touch/surface_models.hpp"
#include "solver/body/pad.hpp"
#include "solver/jet/surface_map.hpp"

namespace forefeel {
namespace {

constexpr const char* without_place = ", anywhere";

std::shared_ptr<const FineJet> fine_jet_at(const Scene& scene, const Body& body, bool quiet) {
  FineBodies fine = *scene.touch.anywhere->fine;
  fine.first.pad->site = nearest_site(fine.first.mesh, body.pad->site);
  fine.make = [make = fine.make, site = body.pad->site](std::size_t elements) {
    Body other = make(elements);
    other.pad->site = nearest_site(other.mesh, site);
    return other;
  };
  return fine_jet_of(body, std::move(fine), {.file = scene.source.file.string(), .key = "body.fine"}, quiet);
}

}  // namespace

bool is_anywhere(const Scene& scene) {
  return scene.touch.anywhere.has_value();
}

namespace {

// The least of how far a box reaches from rest along its axes.
double depth_of(const Box& box) {
  return (-box.low).cwiseMax(box.high).minCoeff();
}

}  // namespace

std::optional<AnywhereKeys> read_anywhere(const SceneTable& contact, const SceneTable& state_space,
                                          std::vector<std::string>& warnings) {
  if (!is_anywhere(contact)) {
    for (const char* key : {"friction", "bonded", "site_spacing"})
      if (contact.has(key))
        throw InputError(contact.where(key), "is for a pad that moves, expected contact.anywhere = true");
    if (state_space.has("depth"))
      throw InputError(state_space.where("depth"), "is for contact.anywhere = true, expected box");
    return {};
  }
  AnywhereKeys keys;
  keys.depth = state_space.number("depth", positive()).value_or(usual_depth);
  if (state_space.has("box") && !state_space.has("depth")) {
    const double depth = depth_of(*state_space.box("box"));
    if (depth > 0) keys.depth = depth;
    warnings.push_back(
        fmt::format("{}: of one place; with contact.anywhere states are placed to its depth, {:.3g} m",
                    state_space.where("box").text(), keys.depth));
  }
  keys.friction = contact.number("friction", not_negative());
  const bool bonded = contact.boolean("bonded").value_or(false);
  if (bonded && keys.friction)
    throw InputError(contact.where("bonded"),
                     "is true beside contact.friction, expected one of them: a bonded tip "
                     "never slides");
  if (!bonded && !keys.friction) keys.friction = usual_friction;
  keys.site_spacing = contact.number("site_spacing", positive());
  return keys;
}

std::string anywhere_in_words(const Pad& pad) {
  return fmt::format("pad of {} N/m, radius {} m{}", pad.stiffness, pad.radius, without_place);
}

Vec3 free_site(const Body& body, const InputPlace& where) {
  const SurfaceMap map(body);
  const auto free_area = [](const SurfaceMap::Facet& facet) { return facet.clamped ? 0.0 : facet.area; };
  const auto widest = std::ranges::max_element(map.facets(), {}, free_area);
  if (widest == map.facets().end() || !(free_area(*widest) > 0))
    throw InputError(where, "all of the surface is clamped, expected a part that can move");
  const auto [a, b, c] = map.corners(static_cast<std::int32_t>(widest - map.facets().begin()));
  return (a + b + c) / 3;
}

SitedBody put_at(const Scene& scene, const Vec3& wanted, bool quiet) {
  const SurfaceMap map(*scene.body);
  const SurfacePlace site = map.nearest(wanted);
  const auto in_words = [](const Vec3& x) {
    return fmt::format("({:.6g}, {:.6g}, {:.6g})", x[0], x[1], x[2]);
  };
  const double distance = (site.at - wanted).norm();
  if (!(distance <= longest_side(scene.body->mesh)))
    throw InputError("--site",
                     fmt::format("{} is {:.3g} m from the surface, farther than the body is long; expected "
                                 "a place near it, in metres",
                                 in_words(wanted), distance));
  if (map.facet(site).clamped)
    throw InputError("--site",
                     fmt::format("{} is on a clamped facet (nearest to {}), expected a place that can move",
                                 in_words(site.at), in_words(wanted)));
  auto body = std::make_shared<Body>(*scene.body);
  body->pad->site = site.at;
  const PadSurface under = pad_surface(body->mesh, *body->pad);
  SitedBody sited{.body = body,
                  .clamped_share = clamped_share(*body, under),
                  .thickness = map.thickness(site, under.normal),
                  .normal = under.normal,
                  .warnings = check(*body, scene.source.file.string())};
  if (scene.touch.anywhere->fine) body->fine = fine_jet_at(scene, *body, quiet);
  if (distance > 0.1 * body->pad->radius)
    sited.warnings.push_back(
        fmt::format("the site {} is {:.3g} mm from the surface; the place nearest to it, {}, is "
                    "taken",
                    in_words(wanted), 1e3 * distance, in_words(site.at)));
  if (sited.clamped_share > 0)
    sited.warnings.push_back(
        fmt::format("the pad at {} reaches over the clamp: {:.1f} % of its springs pull on clamped "
                    "nodes",
                    in_words(site.at), 100 * sited.clamped_share));
  return sited;
}

std::optional<std::string> SitedBody::beyond(const Vec3& x) const {
  const double depth = -x.dot(normal);
  if (!(depth > thickness)) return {};
  return fmt::format("({:.6g}, {:.6g}, {:.6g}) presses {:.3g} mm deep where the body is {:.3g} mm thick",
                     x[0], x[1], x[2], 1e3 * depth, 1e3 * thickness);
}

namespace {

// The words of a command as it was quoted for a shell.
std::vector<std::string> words_of(const std::string& command) {
  std::vector<std::string> words;
  bool quoted = false, open = false;
  for (std::size_t i = 0; i < command.size(); ++i) {
    const char c = command[i];
    if (!quoted && c == ' ') {
      open = false;
      continue;
    }
    if (!open) words.emplace_back();
    open = true;
    if (c == '\'')
      quoted = !quoted;
    else
      words.back() += !quoted && c == '\\' && i + 1 < command.size() ? command[++i] : c;
  }
  return words;
}

}  // namespace

MadeBy made_by(const std::string& provenance) {
  const nlohmann::json document = nlohmann::json::parse(provenance, nullptr, false);
  const auto text = [&](const char* key) {
    return document.is_object() && document.contains(key) && document[key].is_string()
               ? document[key].get<std::string>()
               : std::string();
  };
  return {.command = text("command"), .scene_hash = text("scene_hash")};
}

std::optional<Scene> scene_of(const MadeBy& made_by) {
  if (made_by.scene_hash.empty()) return {};
  const std::vector<std::string> words = words_of(made_by.command);
  std::vector<std::string> overrides, files;
  for (std::size_t i = 1; i < words.size(); ++i) {
    if (words[i] == "--set" && i + 1 < words.size())
      overrides.push_back(words[++i]);
    else if (words[i].starts_with("--set="))
      overrides.push_back(words[i].substr(6));
    else if (words[i].ends_with(".toml") && !words[i].starts_with("-"))
      files.push_back(words[i]);
  }
  for (const std::string& file : files) {
    std::error_code error;
    if (!std::filesystem::is_regular_file(file, error)) continue;
    try {
      Scene scene = load_scene_with_sites(file, overrides, {.spacing = false, .quiet = true});
      if (scene.source.hash == made_by.scene_hash) return scene;
    } catch (const InputError&) {  // no longer the scene that it was
    }
  }
  return {};
}

}  // namespace forefeel
