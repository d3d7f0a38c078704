// The command forefeel with a policy of your own. In its sessions and studies, --policy ahead and the name
// "ahead" in a file select it; all else is as in `forefeel`. Usage: command_policy session SCENE --policy
// ahead …

#include <forefeel/command.hpp>
#include <forefeel/forefeel.hpp>

using namespace forefeel;

// 1. The policy gives every place where a state could be solved a priority; the largest is solved next. Here,
// what lies ahead of the hand, within 60 degrees, comes first.
struct Ahead final : Policy {
  std::string_view name() const override { return "ahead"; }
  bool reads_regions() const override { return false; }  // Candidate::region is not used
  double priority(const Candidate& candidate, const PlannerView& view) const override {
    const double h = view.space.options().spacing;
    const Vec3 way = candidate.at - view.hip.at;
    const bool ahead = way.dot(view.hip.velocity) > 0.5 * way.norm() * view.hip.velocity.norm();
    return (ahead ? 1.0 : 0.1) * h / (h + way.norm());  // finite, not negative
  }
};

int main(int argc, char** argv) {
  // 2. The name, known to the command from here on.
  register_policy("ahead", [](FactoryContext&) { return std::make_unique<Ahead>(); });

  // 3. The command.
  return command_main(argc, argv);
}
