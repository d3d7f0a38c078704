#include "apps/scene/option_names.hpp"

namespace forefeel {

const Words<Element>& element_words() {
  static const Words<Element> words{{"linear", Element::linear}, {"quadratic", Element::quadratic}};
  return words;
}

const Words<Law>& law_words() {
  static const Words<Law> words = [] {
    Words<Law> all;
    for (const Law law : all_laws()) all.emplace_back(name(law), law);
    return all;
  }();
  return words;
}

const Words<Axis>& axis_words() {
  static const Words<Axis> words{{"x", Axis::x}, {"y", Axis::y}, {"z", Axis::z}};
  return words;
}

const Words<Kernel>& kernel_words() {
  static const Words<Kernel> words{
      {"linear", Kernel::linear}, {"cubic", Kernel::cubic}, {"quintic", Kernel::quintic}};
  return words;
}

const Words<Data>& data_words() {
  static const Words<Data> words{{"force", Data::force}, {"force+stiffness", Data::force_and_stiffness}};
  return words;
}

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
