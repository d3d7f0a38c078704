#pragma once
// The words by which scenes and the command line name the choices of a body, a model and a session.

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "geometry/coverage/design.hpp"
#include "scheduling/session/session_options.hpp"
#include "solver/body/body.hpp"

namespace forefeel {

template <class Choice>
using Words = std::vector<std::pair<std::string, Choice>>;

// The word of a value; empty where it has none.
template <class Choice>
std::string word_of(const Words<Choice>& words, Choice value) {
  const auto found = std::ranges::find(words, value, [](const auto& word) { return word.second; });
  return found == words.end() ? "" : found->first;
}

// "linear | quadratic"
inline std::string in_words(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& one : names) text += (text.empty() ? "" : " | ") + one;
  return text;
}
template <class Choice>
std::string in_words(const Words<Choice>& words) {
  std::vector<std::string> names;
  for (const auto& word : words) names.push_back(word.first);
  return in_words(names);
}

inline const Words<Element> element_words{{"linear", Element::linear}, {"quadratic", Element::quadratic}};
inline const Words<Law> law_words = [] {
  Words<Law> all;
  for (const Law law : all_laws()) all.emplace_back(name(law), law);
  return all;
}();
inline const Words<Axis> axis_words{{"x", Axis::x}, {"y", Axis::y}, {"z", Axis::z}};
inline const Words<Kernel> kernel_words{
    {"linear", Kernel::linear}, {"cubic", Kernel::cubic}, {"quintic", Kernel::quintic}};
inline const Words<Data> data_words{
    {"force", Data::force}, {"force+stiffness", Data::force_and_stiffness}, {"jet", Data::jet}};
inline const Words<Clock> clock_words{{"real", Clock::real}, {"virtual", Clock::virtual_time}};
inline const Words<SessionMethod> method_words{{"rbf", SessionMethod::rbf},
                                               {"trilinear", SessionMethod::trilinear},
                                               {"tricubic", SessionMethod::tricubic}};
inline const Words<Design> design_words = [] {
  Words<Design> words;
  for (std::size_t i = 0; i < design_names().size(); ++i)
    words.emplace_back(design_names()[i], static_cast<Design>(i));
  return words;
}();
inline const Words<Placement> placement_words{
    {"lattice", Placement::lattice}, {"adaptive", Placement::adaptive}, {"path", Placement::path}};
inline const Words<Select> select_words{{"label", Select::label}, {"nearest", Select::nearest}};
inline const Words<SwitchRule> switch_words{
    {"paper", SwitchRule::paper}, {"smooth", SwitchRule::smooth}, {"none", SwitchRule::none}};
inline const Words<Passivity> passivity_words{{"observe", Passivity::observe},
                                              {"control", Passivity::control}};

}  // namespace forefeel
