#include "apps/scene/option_names.hpp"

namespace forefeel {

const Words<Clock>& clock_words() {
  static const Words<Clock> words{{"real", Clock::real}, {"virtual", Clock::virtual_time}};
  return words;
}

const Words<SessionMethod>& method_words() {
  static const Words<SessionMethod> words{{"rbf", SessionMethod::rbf},
                                          {"trilinear", SessionMethod::trilinear},
                                          {"tricubic", SessionMethod::tricubic}};
  return words;
}

const Words<Placement>& placement_words() {
  static const Words<Placement> words{
      {"lattice", Placement::lattice}, {"adaptive", Placement::adaptive}, {"path", Placement::path}};
  return words;
}

const Words<Select>& select_words() {
  static const Words<Select> words{{"label", Select::label}, {"nearest", Select::nearest}};
  return words;
}

const Words<SwitchRule>& switch_words() {
  static const Words<SwitchRule> words{
      {"paper", SwitchRule::paper}, {"smooth", SwitchRule::smooth}, {"none", SwitchRule::none}};
  return words;
}

const Words<Passivity>& passivity_words() {
  static const Words<Passivity> words{{"observe", Passivity::observe}, {"control", Passivity::control}};
  return words;
}

}  // namespace forefeel
