#include "scheduling/motion/predictor.hpp"

#include <algorithm>
#include <iterator>
#include <map>

#include "geometry/common/declared.hpp"
#include "scheduling/common/registry.hpp"
#include "scheduling/motion/predictors.hpp"

namespace forefeel {
namespace {

struct BuiltIn {
  const char* name;
  std::unique_ptr<Predictor> (*make)(FactoryContext&);
  const char* meaning;
};

constexpr BuiltIn built_in[] = {
    {"kalman", make_kalman,
     "position, velocity and a fading acceleration; learns how long the hand keeps its direction"},
    {"constant-velocity", make_constant_velocity, "the hand keeps its velocity"}};

Registry<PredictorFactory>& registry() {
  static Registry<PredictorFactory> predictors("predictor", [] {
    std::map<std::string, PredictorFactory> factories;
    for (const BuiltIn& one : built_in) factories.emplace(one.name, one.make);
    return factories;
  }());
  return predictors;
}

}  // namespace

void register_predictor(const std::string& name, PredictorFactory factory) {
  registry().add(name, std::move(factory));
}

std::vector<std::string> predictor_names() {
  return registry().names();
}

std::vector<Declared> declared_predictors() {
  std::vector<Declared> rows;
  for (const BuiltIn& one : built_in) rows.push_back({one.name, "", "", one.meaning});
  for (const std::string& name : predictor_names())
    if (std::ranges::find(built_in, name, &BuiltIn::name) == std::end(built_in))
      rows.push_back({name, "", "", "registered by this program"});
  return rows;
}

std::unique_ptr<Predictor> make_predictor(const PredictorSpec& predictor, const FactoryContext& context) {
  return make_registered(registry().at(predictor.name), "predictor", predictor, context);
}

}  // namespace forefeel
