// Volumes of regions kept up to date while states come, and the policy that reads them, against labels made anew.

#include "geometry/coverage/regions.hpp"
#include "scheduling/motion/random.hpp"
#include "scheduling/policy/policy.hpp"
#include "scheduling/policy/region_shares.hpp"
#include "tests/support/test.hpp"

namespace {

constexpr double h = 0.006;

State somewhere(std::uint64_t key, const Box& box) {
  State state;
  for (int i = 0; i < 3; ++i)
    state.at[i] =
        box.low[i] + box.size()[i] * random::uniform(random::mix(key, static_cast<std::uint64_t>(i)));
  state.force = -100 * state.at;
  return state;
}

// In two clumps, so that all four labels occur.
State clumped(std::uint64_t key, const Box& box) {
  State state = somewhere(key, box);
  state.at.x() = (key % 2 == 0 ? 0.6 : -0.6) * box.high.x() + 0.3 * state.at.x();
  return state;
}

StateSpaceOptions options_of(const Box& box, double spacing) {
  return {.spacing = spacing, .box = box, .merge_distance = 0.01 * h / spacing};
}

}  // namespace

TEST_CASE("shares of the regions' volumes are those of regions made anew from all states") {
  const Box box{{-0.031, -0.02, -0.024}, {0.031, 0.023, 0.024}};  // not a multiple of the voxels' side
  const std::array parts{3, 2, 4};
  StateSpace space(options_of(box, h));
  std::vector<RegionShares> shares;
  for (const double H : {h, 2 * h, 4 * h}) shares.emplace_back(space, H, parts);
  CHECK(shares[0].share(0)[Label::blank] == 1);
  std::vector<Vec3> states;
  std::set<Label> seen;
  for (std::uint64_t batch = 1; batch <= 6; ++batch) {
    for (std::uint64_t i = 0; i < (batch == 6 ? 300 : 3 * batch * batch); ++i) {
      const std::uint64_t key = random::mix(batch, i);
      const State state = batch % 2 == 0 ? somewhere(key, box) : clumped(key, box);
      if (!space.insert(state).is_new) continue;
      states.push_back(state.at);
      for (RegionShares& share : shares) share.learn(state.at);
    }
    for (std::size_t s = 0; s < shares.size(); ++s) {
      CAPTURE(batch, s);
      shares[s].update();
      const double H = h * std::pow(2.0, static_cast<double>(s));
      const Regions anew(states, options_of(box, H));
      const VoxelGrid grid(box, H / 4);
      std::vector<ByLabel<double>> volume(24);
      ByLabel<double> all{};
      bool same = true;
      for (std::int32_t z = 0; z < grid.count[2]; ++z)
        for (std::int32_t y = 0; y < grid.count[1]; ++y)
          for (std::int32_t x = 0; x < grid.count[0]; ++x) {
            const Vec3 at = grid.centre({x, y, z});
            std::size_t part = 0;
            for (int i = 0; i < 3; ++i) {
              const int n = parts[static_cast<std::size_t>(i)];
              const double along = n * (at[i] - box.low[i]) / box.size()[i];
              part = part * static_cast<std::size_t>(n) + static_cast<std::size_t>(std::min(n - 1.0, along));
            }
            const Label label = anew.label_at(at);
            same = same && shares[s].label_at(at) == label;
            volume[part][label] += grid.cube({x, y, z}, 1).size().prod();
            all[label] += grid.cube({x, y, z}, 1).size().prod();
          }
      CHECK(same);
      const RegionSummary summary = anew.summary(false);
      for (const Label label : all_labels) {
        CHECK(all[label] == Approx(summary.volume[label]).margin(1e-15));
        if (all[label] > 0) seen.insert(label);
      }
      for (std::size_t part = 0; part < volume.size(); ++part) {
        double whole = 0;
        for (const Label label : all_labels) whole += volume[part][label];
        for (const Label label : all_labels)
          CHECK(shares[s].share(part)[label] == Approx(volume[part][label] / whole).margin(1e-12));
      }
    }
  }
  CHECK(seen.size() == 4);
}

// The box is one cube of the policy, and the hand has no path: the worth of a lone candidate is then the sum over the
// three spacings of prior x lack x (1 - d^2 / (2 H)^2), with the lack averaged over the volume.
TEST_CASE("coverage-regions: the worth of a state is that of the volumes of the regions") {
  const Box box{Vec3::Constant(-h), Vec3::Constant(h)};
  StateSpace space(options_of(box, h));
  for (const Vec3& at : {Vec3(-h, -h, -h), Vec3(h, -h, -h), Vec3(-h, h, -h), Vec3(-h, -h, 0)}) {
    State state;
    state.at = at;
    space.insert(state);
  }
  const auto policy = make_policy("coverage-regions");
  const PlannerView view{.space = space, .hip = {.velocity = Vec3::Zero()}, .predicted = {}, .pending = {}};
  policy->look(view);
  for (const Vec3& at : {Vec3(0, 0, 0), Vec3(h, h, h), Vec3(0, -h, 0.5 * h)}) {
    double worth = 0;
    const double priors[] = {0.9, 0.5,
                             0.15};  // of 4 h, 2 h and h with stiffness, before any state was missed
    for (std::size_t s = 0; s < 3; ++s) {
      const double H = h * std::pow(2.0, 2 - static_cast<double>(s));
      std::vector<Vec3> states;
      for (std::uint32_t i = 0; i < space.size(); ++i) states.push_back(space[StateId{i}].at);
      const Regions anew(states, options_of(box, H));
      const RegionSummary summary = anew.summary(false);
      const auto lack = [&](Label label) {
        return label == Label::blank             ? 1
               : label == Label::gap             ? 0.25
               : label == Label::sparse && s > 0 ? 0.1
                                                 : 0;
      };
      double mean = 0;
      for (const Label label : all_labels) mean += lack(label) * summary.volume[label] / box.size().prod();
      const double reached = std::max(0.0, 1 - at.squaredNorm() / (4 * H * H));
      worth += 0.25 * priors[s] * mean * reached;
    }
    const double got = policy->priority({.at = at}, view);
    CAPTURE(at.transpose(), got, worth);
    CHECK(got == Approx(worth).epsilon(1e-9));
  }
}
