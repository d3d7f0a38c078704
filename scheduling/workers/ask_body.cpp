#include "scheduling/workers/ask_body.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <tuple>

namespace forefeel {
namespace {

constexpr std::size_t most_asked = 8, most_told = 2;
constexpr double agreement = 0.01;

auto place(const State& s) {
  return std::tuple(s.at.squaredNorm(), s.at.x(), s.at.y(), s.at.z());
}

// Divides the states into eight parts by distance from rest. Chooses one state of each part: the one farthest from
// those chosen before.
std::vector<const State*> choose(std::span<const State> states) {
  std::vector<const State*> all;
  for (const State& s : states)
    if (s.usable() && !s.solve.multivalued && s.at.allFinite() && s.force.allFinite()) all.push_back(&s);
  const auto pressed = [](const State* s) { return !s->at.isZero(0); };
  if (std::ranges::any_of(all, pressed)) std::erase_if(all, std::not_fn(pressed));  // rest fits any body
  std::ranges::sort(all, [](const State* a, const State* b) { return place(*a) < place(*b); });
  std::vector<const State*> chosen;
  const std::size_t n = all.size(), parts = std::min(n, most_asked);
  for (std::size_t part = 0; part < parts; ++part) {
    const State* best = nullptr;
    double best_away = -1;
    for (std::size_t i = part * n / parts; i < (part + 1) * n / parts; ++i) {
      double away = std::numeric_limits<double>::max();
      for (const State* other : chosen) away = std::min(away, (other->at - all[i]->at).squaredNorm());
      if (away > best_away) best = all[i], best_away = away;
    }
    chosen.push_back(best);
  }
  return chosen;
}

std::string vector_text(const Vec3& v) {
  return fmt::format("({:.4g}, {:.4g}, {:.4g})", v.x(), v.y(), v.z());
}

double difference(const AskedPosition& asked) {
  return asked.solved ? (*asked.solved - asked.given).norm() : 0;
}

}  // namespace

std::size_t BodyAnswer::fitting() const {
  return static_cast<std::size_t>(std::ranges::count_if(asked, &AskedPosition::fits));
}

bool BodyAnswer::fits() const {
  const auto unsolved = static_cast<std::size_t>(
      std::ranges::count_if(asked, [](const AskedPosition& a) { return !a.solved; }));
  return !too_far && fitting() + unsolved == asked.size() && 2 * unsolved <= asked.size();
}

BodyAnswer ask_body(std::span<const State> states, double farthest, const SolveStates& solve) {
  BodyAnswer answer;
  double strongest = 0;
  for (const State& s : states) {
    if (!s.usable()) continue;
    if (!(s.at.norm() <= farthest)) {
      answer.too_far = s.at;
      return answer;
    }
    strongest = std::max(strongest, s.force.norm());
  }
  const std::vector<const State*> chosen = choose(states);
  const std::vector<State> answers = solve(chosen);
  for (std::size_t i = 0; i < chosen.size(); ++i) {
    const State *s = chosen[i], &solved = answers.at(i);
    AskedPosition& asked = answer.asked.emplace_back(
        AskedPosition{.at = s->at, .given = s->force, .site = s->site, .solved = {}});
    if (!solved.usable()) continue;
    asked.solved = solved.force;
    const double scale = std::max({s->force.norm(), solved.force.norm(), 0.1 * strongest});
    asked.fits = (solved.force - s->force).norm() <= agreement * scale;
  }
  return answer;
}

std::string in_words(const BodyAnswer& answer) {
  if (answer.too_far)
    return fmt::format("a state is {:.4g} m from rest, farther than twice the body's length",
                       answer.too_far->norm());
  if (answer.fits()) return fmt::format("the forces agree at {} positions asked", answer.asked.size());
  std::vector<AskedPosition> differing = answer.asked;
  std::erase_if(differing, [](const AskedPosition& a) { return a.fits || !a.solved; });
  const std::size_t count = differing.size();
  if (count == 0)
    return fmt::format("the body has no equilibrium at most of the {} positions asked", answer.asked.size());
  std::ranges::stable_sort(differing, std::greater<>(), difference);
  differing.resize(std::min(count, most_told));
  std::string text = fmt::format("the forces differ at {} of {} positions asked", count, answer.asked.size());
  for (std::size_t i = 0; i < differing.size(); ++i)
    text += fmt::format(
        "{}at {} m{} they are {} N, those of the body {} N", i == 0 ? ": " : "; ",
        vector_text(differing[i].at),
        differing[i].site.allFinite() ? " of the site " + vector_text(differing[i].site) + " m" : "",
        vector_text(differing[i].given), vector_text(*differing[i].solved));
  return text;
}

}  // namespace forefeel
