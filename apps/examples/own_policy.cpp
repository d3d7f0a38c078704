// A policy of your own, registered under a name and compared with a built-in one.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <forefeel/forefeel.hpp>

using namespace forefeel;

// 1. The policy gives every place where a state could be solved a priority; the largest is solved next.
struct Ahead final : Policy {
  std::string_view name() const override { return "ahead"; }
  bool reads_regions() const override { return false; }  // saves the labels of all places
  double priority(const Candidate& candidate, const PlannerView& view) const override {
    double to_path = INFINITY;  // from the place to where the hand is expected [m]
    for (const Prediction& p : view.predicted) to_path = std::min(to_path, (candidate.at - p.at).norm());
    const double h = view.space.options().spacing;
    return h / (h + to_path);
  }
};

int main() {
  // 2. From here on its name is known like that of a built-in policy.
  register_policy("ahead", [](FactoryContext&) { return std::make_unique<Ahead>(); });

  // 3. The same session with each policy. The workers solve fewer states than the hand needs: it matters which.
  auto body = std::make_shared<Body>();
  body->mesh = phantom("liver", 1800);
  body->material = {.law = Law::st_venant_kirchhoff, .young = 5000, .poisson = 0.3};
  body->clamp = body->mesh.groups.at("clamp");
  body->contact = body->mesh.groups.at("contact");
  const Box reach{Vec3::Constant(-0.036), Vec3(0.036, 0.036, 0.024)};
  const SessionInput input{.touched = {.body = body, .space = {.spacing = 0.006, .box = reach}}};
  for (const char* policy : {"ahead", "nearest"}) {
    SessionOptions options;
    options.clock = {.kind = Clock::virtual_time, .seconds = 4};
    options.planning.policy = policy;
    options.motion.device = PathMotion{.path = PathName::lissajous, .speed = 0.06};  // [m/s]
    options.workers.cost = ConstantCost{.seconds = 0.2};
    const SessionSummary summary = summarise(run_session(input, options), input, options);
    fmt::print("{}: within the JND on {:.0f} % of the path\n", policy,
               100 * summary.error.samples.within_jnd);
  }
}
