#pragma once
// The words by which scenes and the command line name the choices of a body, a model and a session.

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

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

const Words<Element>& element_words();       // linear, quadratic
const Words<Law>& law_words();               // neo-hookean, …
const Words<Axis>& axis_words();             // x, y, z
const Words<Kernel>& kernel_words();         // linear, cubic, quintic
const Words<Data>& data_words();             // force, force+stiffness
const Words<Clock>& clock_words();           // real, virtual
const Words<SessionMethod>& method_words();  // rbf, trilinear, tricubic
const Words<Placement>& placement_words();   // lattice, adaptive, path
const Words<Select>& select_words();         // label, nearest
const Words<SwitchRule>& switch_words();     // paper, smooth, none
const Words<Passivity>& passivity_words();   // observe, control

}  // namespace forefeel
