#include "apps/laboratory/speed_steps.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "apps/scene/option_names.hpp"

namespace forefeel {
namespace {

void use_papers_model(SpeedSettings& s) {
  s.options.model.fit.kernel = Kernel::cubic;
  s.options.model.fit.data = Data::force;
  s.options.model.fit.neighbours = 100;
}

void use_our_model(SpeedSettings& s) {
  s.options.model.fit.kernel = Kernel::quintic;
  s.options.model.fit.data = Data::force_and_stiffness;
  s.options.model.fit.neighbours = 25;
}

void be_predecessor(SpeedSettings& s) {
  s.options.planning.policy = "nearest";
  s.options.model.fit.select = Select::nearest;
  s.options.switching.rule = SwitchRule::none;
  s.options.planning.preempt = s.options.planning.rest_first = s.options.model.first_guess = false;
  use_papers_model(s);
  s.options.model.method = SessionMethod::trilinear;
  s.spacing = 0.012;  // its best: slower at 6 mm, never within 7 % at 18 mm
}

void be_seed_paper_with_our_start(SpeedSettings& s) {
  s.options.planning.rest_known = s.options.planning.preempt = false;
  s.options.planning.policy = "nearest";
  s.options.model.fit.select = Select::nearest;
  s.options.switching.rule = SwitchRule::paper;
  use_papers_model(s);
}

// As written in a scene, in quotes.
template <class Choice>
std::string word(const Words<Choice>& words, Choice choice) {
  return "\"" + word_of(words, choice) + "\"";
}

// A key without its section, as the short form allows.
std::string bare(const std::string& key) {
  return key.starts_with("session.") ? key.substr(8) : key == "model.select" ? "select" : key;
}

}  // namespace

const std::vector<SpeedStep>& speed_steps() {
  using Role = SpeedRole;
  using S = SpeedSettings;
  static const std::vector<SpeedStep> steps{
      {"predecessor, trilinear 12 mm", Role::predecessor, false, be_predecessor},
      {"predecessor, tricubic 12 mm", Role::predecessor, false,
       [](S& s) { s.options.model.method = SessionMethod::tricubic; }},
      // Never within 7 % at 24 mm.
      {"predecessor, tricubic 18 mm", Role::predecessor, false, [](S& s) { s.spacing = 0.018; }},
      {"seed paper on its best lattice: r3 n=100, 12 mm", Role::seed_paper_best, true,
       [](S& s) {
         s.options.model.method = SessionMethod::rbf;
         s.spacing = 0.012;
         s.options.switching.rule = SwitchRule::paper;
       }},
      {"seed paper: r3 n=100, 6 mm", Role::seed_paper, true, [](S& s) { s.spacing = 0.006; }},
      {"+ smooth switch", Role::other, false, [](S& s) { s.options.switching.rule = SwitchRule::smooth; }},
      {"+ neighbours by label", Role::other, false, [](S& s) { s.options.model.fit.select = Select::label; }},
      {"+ stiffness data, r5 n=25", Role::other, true, use_our_model},
      {"+ policy coverage", Role::other, false, [](S& s) { s.options.planning.policy = "coverage"; }},
      {"+ preemption", Role::other, false, [](S& s) { s.options.planning.preempt = true; }},
      {"+ rest first", Role::other, true, [](S& s) { s.options.planning.rest_first = true; }},
      {"+ first guess (default)", Role::ours, true, [](S& s) { s.options.model.first_guess = true; }},
      {"default, constant-velocity prediction", Role::other, false,
       [](S& s) { s.options.motion.predictor = "constant-velocity"; }},
      {"default, adaptive placement", Role::other, false,
       [](S& s) {
         s.options.motion.predictor = "kalman";
         s.options.planning.placement = Placement::adaptive;
       }},
      {"default, motion known (clairvoyant)", Role::other, true,
       [](S& s) {
         s.options.planning.placement = Placement::lattice;
         s.options.planning.policy = "clairvoyant-greedy";
       }},
      {"default without the damped switch", Role::other, true,
       [](S& s) {
         s.options.planning.policy = "coverage";
         s.options.switching.rule = SwitchRule::none;
       }},
      {"default, rest known before the start", Role::rest_known, true,
       [](S& s) {
         s.options.switching.rule = SwitchRule::smooth;
         s.options.planning.rest_known = true;
       }},
      // The older methods with our start: the first guess, and the state at rest first. Rest is their nearest
      // state anyway; here it costs one factorisation.
      {"seed paper, 6 mm + our start", Role::seed_paper_start, false, be_seed_paper_with_our_start},
      {"seed paper, 12 mm + our start", Role::seed_paper_best_start, false, [](S& s) { s.spacing = 0.012; }},
      {"predecessor, tricubic 12 mm + our start", Role::predecessor_start, false,
       [](S& s) {
         s.options.model.method = SessionMethod::tricubic;
         s.options.switching.rule = SwitchRule::none;
       }},
      {"predecessor, tricubic 18 mm + our start", Role::predecessor_start, false,
       [](S& s) { s.spacing = 0.018; }}};
  return steps;
}

std::vector<SpeedSettings> speed_settings(const SpeedSettings& begin) {
  std::vector<SpeedSettings> all;
  for (const SpeedStep& step : speed_steps()) {
    all.push_back(all.empty() ? begin : all.back());
    step.change(all.back());
  }
  return all;
}

std::vector<std::pair<std::string, std::string>> scene_keys(const SpeedSettings& settings) {
  const SessionOptions& s = settings.options;
  const auto quoted = [](std::string_view text) { return fmt::format("\"{}\"", text); };
  const auto yes_no = [](bool value) { return std::string(value ? "true" : "false"); };
  return {{"session.policy", quoted(to_text(s.planning.policy))},
          {"session.select", word(select_words, s.model.fit.select)},
          {"session.switch", word(switch_words, s.switching.rule)},
          {"session.preempt", yes_no(s.planning.preempt)},
          {"session.rest_first", yes_no(s.planning.rest_first)},
          {"session.first_guess", yes_no(s.model.first_guess)},
          {"session.rest_known", yes_no(s.planning.rest_known)},
          {"session.method", word(method_words, s.model.method)},
          {"session.predictor", quoted(to_text(s.motion.predictor))},
          {"session.placement", word(placement_words, s.planning.placement)},
          {"model.kernel", quoted(name(s.model.fit.kernel))},
          {"model.data", quoted(name(s.model.fit.data))},
          {"model.neighbours", fmt::format("{}", s.model.fit.neighbours)},
          {"state_space.spacing", fmt::format("{}", settings.spacing)}};
}

std::string step_that_changes(const std::string& key) {
  SpeedSettings before;
  use_our_model(before);
  const std::vector<SpeedSettings> all = speed_settings(before);
  for (std::size_t i = 0; i < all.size(); ++i) {
    const auto was = scene_keys(i == 0 ? before : all[i - 1]), is = scene_keys(all[i]);
    for (std::size_t k = 0; k < is.size(); ++k)
      if (bare(is[k].first) == bare(key) && is[k].second != was[k].second) return speed_steps()[i].name;
  }
  return {};
}

}  // namespace forefeel
