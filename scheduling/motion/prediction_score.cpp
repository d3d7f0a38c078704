#include "scheduling/motion/prediction_score.hpp"

#include <algorithm>
#include <cmath>

#include "scheduling/motion/predictor.hpp"

namespace forefeel {

PredictionScore::PredictionScore(Predictor& predictor, double step, std::span<const double> horizons,
                                 std::size_t stride)
    : predictor_(predictor), step_(step), stride_(stride) {
  for (const double horizon : horizons)
    ahead_.push_back({.horizon = horizon,
                      .steps = static_cast<std::size_t>(std::llround(horizon / step)),
                      .made = {},
                      .errors = {}});
}

void PredictionScore::add(const Vec3& at) {
  // the velocity of a session's frames (render_loop.cpp)
  predictor_.observe({.t = static_cast<double>(seen_) * step_,
                      .at = at,
                      .velocity = seen_ == 0 ? Vec3::Zero() : Vec3((at - before_) / step_)});
  before_ = at;
  for (Ahead& ahead : ahead_) {
    if (seen_ % stride_ == 0) ahead.made.push_back(predictor_.predict(ahead.horizon));
    if (seen_ < ahead.steps || (seen_ - ahead.steps) % stride_ != 0) continue;
    const Prediction& p = ahead.made.front();
    ahead.errors.push_back((p.at - at).norm());
    ahead.within += ((p.at - at).cwiseAbs().array() <= 2 * p.deviation).all();
    // Quantiles of the chi-square distribution with three degrees of freedom.
    constexpr double half = 2.365973884375338, most = 6.251388631170325;
    const double distance2 = (p.at - at).squaredNorm(), deviation2 = p.deviation * p.deviation;
    ahead.within_50 += distance2 <= half * deviation2;
    ahead.within_90 += distance2 <= most * deviation2;
    ahead.made.pop_front();
  }
  ++seen_;
}

std::vector<PredictionError> PredictionScore::report() const {
  std::vector<PredictionError> report;
  for (const Ahead& ahead : ahead_) {
    PredictionError e{.horizon = ahead.horizon};
    std::vector<double> errors = ahead.errors;
    if (!errors.empty()) {
      std::sort(errors.begin(), errors.end());
      e.p50 = errors[errors.size() / 2];
      e.p95 = errors[errors.size() * 95 / 100];
      const auto count = static_cast<double>(errors.size());
      e.within_deviation = static_cast<double>(ahead.within) / count;
      e.within_50 = static_cast<double>(ahead.within_50) / count;
      e.within_90 = static_cast<double>(ahead.within_90) / count;
    }
    report.push_back(e);
  }
  return report;
}

PredictorScores::PredictorScores(double step, const PredictorSpec& own, const FactoryContext& context)
    : names_(predictor_names()) {
  std::erase_if(names_, [&](const std::string& name) {  // network has no weights of its own
    return name != own.name && (name == "network" || !is_built_in_predictor(name));
  });
  for (std::string& name : names_) {
    const bool is_own = name == own.name;
    predictors_.push_back(is_own ? make_predictor(own, context) : make_predictor(name));
    scores_.emplace_back(*predictors_.back(), step);
    if (is_own) name = to_text(own);
  }
}

PredictorScores::~PredictorScores() = default;

void PredictorScores::add(const Vec3& at) {
  for (PredictionScore& score : scores_) score.add(at);
}

std::vector<PredictorErrors> PredictorScores::report() const {
  std::vector<PredictorErrors> report;
  for (std::size_t i = 0; i < scores_.size(); ++i) report.push_back({names_[i], scores_[i].report()});
  return report;
}

}  // namespace forefeel
