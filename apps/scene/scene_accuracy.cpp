#include "apps/scene/scene_accuracy.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <array>
#include <chrono>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <numbers>

#include "apps/console/interrupt.hpp"
#include "apps/console/json.hpp"
#include "apps/scene/cache_folder.hpp"
#include "geometry/common/counted.hpp"
#include "geometry/common/error.hpp"
#include "geometry/common/sha256.hpp"
#include "solver/body/contact_stiffness.hpp"
#include "solver/equilibrium/mesh_error.hpp"
#include "solver/equilibrium/solver.hpp"
#include "solver/kernels/revision.hpp"

namespace forefeel {
namespace {

using Json = nlohmann::ordered_json;
using SteadyClock = std::chrono::steady_clock;

constexpr double margin = 1.5;  // quadratic elements: what is left over what splitting in eight changes
constexpr std::int64_t most_solved_nodes = 100'000;

double seconds_since_start(SteadyClock::time_point start) {
  return std::chrono::duration<double>(SteadyClock::now() - start).count();
}

// One radius of the contact inward and to two sides.
std::vector<Vec3> probed(const Body& body, const Vec3& inward) {
  const double area = contact_area(body);
  const double radius = body.pad   ? body.pad->radius
                        : area > 0 ? std::sqrt(area / std::numbers::pi)
                                   : 0.05 * longest_side(body.mesh);
  const Vec3 n = inward.normalized(), t = n.unitOrthogonal();
  return {radius * n, radius * t, radius * n.cross(t)};
}

// Fills in what the body of a trial is like.
void judge(Body made, const Vec3& inward, AccuracyChoice& choice) {
  const auto body = std::make_shared<const Body>(std::move(made));
  const std::vector<Vec3> at = probed(*body, inward);
  const double step = at.front().norm() / 3;
  Solver solver(body);
  solver.rest();
  const auto start = SteadyClock::now();
  for (const Vec3& x : at) solver.reference(x, step);
  choice.ms_per_state = 1e3 * seconds_since_start(start) / static_cast<double>(at.size());
  const MeshError error = mesh_error(body, at, {.spacing = step, .most_for_equilibria = most_solved_nodes});
  const bool all = error.positions == at.size() && error.method != MeshErrorMethod::rest;
  choice.error = all ? error.error : unknown;
  choice.high = all ? (body->fine ? error.high : margin * error.error) : unknown;
  choice.reached = choice.high <= choice.wanted;
}

std::filesystem::path file_of(double wanted, std::span<const AccuracyTrial> trials,
                              const std::string& about) {
  const std::filesystem::path folder = cache_folder();
  if (folder.empty()) return {};
  Sha256 hash;
  hash.add(std::string_view("accuracy, linear elements of one size"))
      .add(solver_revision())
      .add(about)
      .add(wanted);
  for (const AccuracyTrial& t : trials)
    hash.add(static_cast<std::int64_t>(t.element))
        .add(static_cast<std::int64_t>(t.elements))
        .add(static_cast<std::int64_t>(t.fine));
  return folder / (hash.hex().substr(0, 32) + ".accuracy.json");
}

std::optional<AccuracyChoice> choice_in(const Json& kept, AccuracyChoice choice) {
  try {
    const auto figure = [&](const char* key) {
      return kept.at(key).is_null() ? unknown : kept.at(key).get<double>();
    };
    choice.taken.element = kept.at("element") == name(Element::linear) ? Element::linear : Element::quadratic;
    choice.taken.elements = kept.at("elements").get<std::size_t>();
    choice.taken.fine = kept.at("fine").get<std::size_t>();
    choice.error = figure("error"), choice.high = figure("high");
    choice.seconds = figure("seconds"), choice.ms_per_state = figure("ms_per_state");
    choice.reached = kept.at("reached").get<bool>();
    return choice;
  } catch (const Json::exception&) {
    return {};
  }
}

Json to_file(const AccuracyChoice& c) {
  return {{"element", name(c.taken.element)}, {"elements", c.taken.elements}, {"fine", c.taken.fine},
          {"error", number(c.error)},         {"high", number(c.high)},       {"seconds", c.seconds},
          {"ms_per_state", c.ms_per_state},   {"reached", c.reached}};
}

bool better(const AccuracyChoice& a, const AccuracyChoice& b) {
  return std::isfinite(a.high) && !(a.high >= b.high);
}

}  // namespace

std::vector<AccuracyTrial> accuracy_trials(const AccuracyGiven& given) {
  constexpr std::size_t most = 80'000;
  constexpr std::array<std::size_t, 5> fine_counts{1'800, 3'500, 7'000, 14'000, 28'000};
  constexpr std::array<std::size_t, 3> counts_alone{1'800, 3'500, 7'000};
  std::vector<AccuracyTrial> trials;
  if (given.mesh_tets > 0) {  // each level of subdivision once
    std::size_t fine = given.mesh_tets;
    do trials.push_back({given.element.value_or(Element::linear), 0, fine *= 8});
    while (8 * fine < most);
    return trials;
  }
  for (const Element element : {Element::linear, Element::quadratic}) {
    if (given.element && *given.element != element) continue;
    const std::size_t usual = element == Element::linear ? 1'800 : 900;
    const std::size_t own = given.elements.value_or(usual);
    if (given.fine) {
      trials.push_back({element, own, *given.fine});
      continue;
    }
    for (const std::size_t fine : fine_counts) trials.push_back({element, own, fine});
  }
  if (given.fine || given.elements || given.element == Element::linear) return trials;
  for (const std::size_t elements : counts_alone) trials.push_back({Element::quadratic, elements, 0});
  return trials;
}

AccuracyChoice choose_accuracy(double wanted, std::span<const AccuracyTrial> trials, const std::string& about,
                               const BodyMaker& maker) {
  AccuracyChoice best{.wanted = wanted, .taken = trials.front()};
  const std::filesystem::path file = file_of(wanted, trials, about);
  if (const std::optional<Json> kept = read_kept(file))
    if (const std::optional<AccuracyChoice> known = choice_in(*kept, best)) return *known;
  const auto start = SteadyClock::now();
  for (const AccuracyTrial& trial : trials) {
    end_if_interrupted("body.accuracy was met");
    AccuracyChoice choice{.wanted = wanted, .taken = trial};
    try {
      Body made = maker.make(trial);
      const Vec3 inward = maker.inward(made);
      judge(std::move(made), inward, choice);
    } catch (const InputError&) {  // so few or so many elements cannot be made
      if (&trial == &trials.back() && !std::isfinite(best.high)) throw;
      continue;
    }
    if (choice.reached || better(choice, best) || best.ms_per_state == 0) best = choice;
    if (choice.reached) break;
  }
  best.seconds = seconds_since_start(start);
  keep(file, to_file(best));
  return best;
}

std::string in_words(const AccuracyTrial& t) {
  return (t.elements ? fmt::format("{} {} elements", t.elements, name(t.element))
                     : fmt::format("{} elements of the given mesh", name(t.element))) +
         (t.fine ? fmt::format(" with a fine body of {}", t.fine) : "");
}

std::string in_words(const AccuracyChoice& c) {
  const std::string error = std::isfinite(c.error)
                                ? fmt::format("error {}, at most {}", in_percent(c.error), in_percent(c.high))
                                : "no error can be said";
  return fmt::format("{}: {}{}; a solve takes {:.2g} ms, the search took {:.2g} s once", in_words(c.taken),
                     error, c.reached ? "" : fmt::format(", not the {:g} % wanted", 100 * c.wanted),
                     c.ms_per_state, c.seconds);
}

}  // namespace forefeel
