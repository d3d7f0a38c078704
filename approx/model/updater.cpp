#include "approx/model/updater.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "approx/model/jet_set.hpp"
#include "approx/model/model_options.hpp"
#include "approx/model/neighbours.hpp"
#include "approx/model/polynomial.hpp"
#include "approx/model/rbf_fit.hpp"
#include "geometry/common/error.hpp"

namespace forefeel {
using namespace detail;

namespace {

void check(const ModelOptions& options) {
  if (options.kernel == Kernel::linear && options.data != Data::force)
    throw InputError("model.data",
                     "kernel linear takes no stiffness, expected cubic or quintic with force+stiffness");
  if (options.neighbours == 0) throw InputError("model.neighbours", "is 0, expected at least 1");
  if (!(options.ridge >= 0) || !std::isfinite(options.ridge))
    throw InputError("model.ridge", "is negative or not finite, expected a number >= 0");
}

Sample sample_of(StateId id, const State& state) {
  Sample sample{.id = id, .at = state.at, .force = state.force, .stiffness = state.stiffness};
  if (!sample.stiffness.allFinite()) sample.stiffness.setConstant(unknown);
  return sample;
}

// Outside the radius of all jets, so many states are needed for an RBF model in their place.
constexpr std::size_t least_for_rbf = 8;

// Of states without jets, and outside the radius of every jet.
ModelOptions of_rbf(ModelOptions options) {
  if (options.data == Data::jet) {
    options.data = Data::force_and_stiffness;
    options.neighbours = std::max(options.neighbours, usual_neighbours(options.data));
  }
  return options;
}

// Adds the auxiliary places of affine_places(), at the anchors of a polynomial of degree 2. Their forces are
// those of the affine fit of the samples.
void add_affine_places(std::vector<Sample>& samples, double h) {
  constexpr double weight = 0.001;
  double total = 0;
  const Vec3 origin = samples.front().at;
  Vec3 mean = Vec3::Zero(), force = Vec3::Zero();
  for (const Sample& s : samples) {
    total += s.weight;
    mean += s.weight * (s.at - origin);
    force += s.weight * s.force;
  }
  mean = origin + mean / total;
  force /= total;
  Mat3 spread = Mat3::Zero(), cross = Mat3::Zero(), stiffness = Mat3::Zero();
  double known = 0;
  for (const Sample& s : samples) {
    const Vec3 x = s.at - mean;
    spread += s.weight / total * x * x.transpose();
    cross += s.weight / total * (s.force - force) * x.transpose();
    if (!s.stiffness.allFinite()) continue;
    known += s.weight;
    stiffness += s.weight * s.stiffness;
  }
  const double radius = std::max(std::sqrt(spread.trace()), least_size * h);
  const Mat3 slope =
      known > 0 ? Mat3(-stiffness / known)
                : Mat3(cross * (spread + 1e-3 * (h * h + spread.trace()) * Mat3::Identity()).inverse());
  for (std::uint32_t j = 0; j < max_terms; ++j) {
    const auto a = anchor(j);
    const Vec3 x = radius * Vec3(a[0], a[1], a[2]);
    samples.push_back({.id = {0xffffff00u + j},
                       .at = mean + x,
                       .force = force + slope * x,
                       .stiffness = Mat3::Constant(unknown),
                       .weight = weight,
                       .reach = std::max(1.0, radius / h),
                       .near = 0,
                       .weighted = true,
                       .state = false});
  }
}

}  // namespace

struct ModelUpdater::Impl {
  // From the last set of states to the next.
  struct Change {
    std::vector<StateId> wanted, removed, missing;
    std::vector<Sample> added;
  };
  const StateSpace& space;
  ModelOptions options;
  RbfFit fit;
  NeighbourSelector selector;
  std::vector<Neighbour> chosen, last_weighted;  // the second is empty if the last set had no weights
  Change change;
  ModelDraft draft;
  std::uint64_t serial = 0;
  JetSet jets;
  std::vector<StateId> chosen_jets;
  bool fresh = true;          // the next model must not depend on earlier ones
  bool from_scratch = false;  // the fit is a refit of exactly its set, in order of ids

  bool update_jets(const Vec3& hip, Model& out, UpdateReport* report, const UpdateTag& tag);

  Impl(const StateSpace& known, ModelOptions wished)
      : space(known),
        options(wished),
        fit(of_rbf(wished), most_neighbours(wished) + affine_places(wished)),
        selector(known, of_rbf(wished)),
        jets(known, wished) {
    const std::size_t most = most_neighbours(options);
    change.wanted.reserve(most);
    chosen.reserve(most);
    last_weighted.reserve(most);
    change.removed.reserve(most);
    change.missing.reserve(most);
    change.added.reserve(most + affine_places(options));
    draft.reserve(options);
  }
};

ModelUpdater::ModelUpdater(const StateSpace& space, ModelOptions options) {
  check(options);
  if (options.length == 0) options.length = space.options().spacing;
  impl_ = std::make_unique<Impl>(space, options);
}
ModelUpdater::~ModelUpdater() = default;
ModelUpdater::ModelUpdater(ModelUpdater&&) noexcept = default;

bool ModelUpdater::Impl::update_jets(const Vec3& hip, Model& out, UpdateReport* report,
                                     const UpdateTag& tag) {
  if (options.data != Data::jet) return false;
  jets.learn();
  if (jets.empty()) return false;
  jets.choose(hip, chosen_jets);
  if (jets.lost(hip, chosen_jets.front()) && space.size() >= least_for_rbf) return false;
  jets.write(chosen_jets, draft);
  if (tag.guess) draft.forget_states();
  ++serial;
  out.assign(draft, tag.serial > 0 ? tag.serial : serial);
  if (report != nullptr)
    *report = {
        .n = chosen_jets.size(), .replaced = chosen_jets.size(), .refit = true, .label = space.label(hip)};
  return true;
}

bool ModelUpdater::update(const Vec3& hip, Model& out, UpdateReport* report, const UpdateTag& tag) {
  Impl& m = *impl_;
  if (m.update_jets(hip, out, report, tag)) return true;
  const Label label = m.selector.select(hip, m.chosen);
  m.change.wanted.clear();
  for (const Neighbour& c : m.chosen) m.change.wanted.push_back(c.id);
  if (report != nullptr) *report = {.n = m.change.wanted.size(), .label = label};
  if (m.change.wanted.empty()) {
    m.draft.clear();
    out.assign(m.draft, 0);
    return false;
  }
  m.fit.difference(m.change.wanted, m.change.removed, m.change.missing);
  m.change.added.clear();
  for (const StateId id : m.change.missing) m.change.added.push_back(sample_of(id, m.space[id]));
  // Weights change with the HIP, and with them nearly all of the matrix.
  const bool weighted = m.selector.weighted();
  const bool same_set = m.change.removed.empty() && m.change.added.empty();
  const bool same_weights =
      weighted ? std::ranges::equal(m.chosen, m.last_weighted) : m.last_weighted.empty();
  bool refit = false;
  if (!same_weights || (m.fresh && !(same_set && m.from_scratch))) {
    m.change.added.clear();
    for (const Neighbour& c : m.chosen) {
      Sample& sample = m.change.added.emplace_back(sample_of(c.id, m.space[c.id]));
      sample.weight = c.weight;
      sample.near = c.near;
      sample.reach = c.reach;
      sample.weighted = weighted;
    }
    if (weighted && affine_places(m.options) > 0)
      add_affine_places(m.change.added, m.space.options().spacing);
    m.fit.refit(m.change.added);
    refit = m.from_scratch = true;
  } else if (!same_set) {
    refit = m.fit.replace(m.change.removed, m.change.added);
    m.from_scratch = false;
  }
  m.last_weighted.clear();
  if (weighted) m.last_weighted.assign(m.chosen.begin(), m.chosen.end());
  m.fresh = false;
  m.draft.reserve(m.options);
  m.fit.write(m.draft, hip, m.selector.bridge(), m.selector.radius());
  if (tag.guess) m.draft.forget_states();
  ++m.serial;
  out.assign(m.draft, tag.serial > 0 ? tag.serial : m.serial);
  if (report != nullptr) {
    report->replaced = m.change.added.size();
    report->refit = refit;
  }
  return true;
}

void ModelUpdater::forget() {
  impl_->fresh = true;
  impl_->selector.forget();
  impl_->jets.forget();
}

Model ModelUpdater::model_at(const Vec3& hip) {
  Model model;
  update(hip, model);
  return model;
}

Model fit_model(std::span<const State> states, const ModelOptions& options, const Vec3& centre) {
  check(options);
  if (options.data == Data::jet) {
    StateSpace space({.spacing = options.length > 0 ? options.length : 0.006});
    for (const State& state : states)
      if (state.usable()) space.insert(state);
    return ModelUpdater(space, options).model_at(centre);
  }
  std::vector<Sample> samples;
  samples.reserve(states.size());
  for (std::size_t i = 0; i < states.size(); ++i)
    if (states[i].usable()) samples.push_back(sample_of({static_cast<std::uint32_t>(i)}, states[i]));
  std::ranges::stable_sort(samples, {}, [&](const Sample& s) { return (s.at - centre).squaredNorm(); });
  RbfFit solver(options, samples.size());
  solver.refit(samples);
  ModelDraft draft;
  solver.write(draft, centre);
  Model model;
  model.assign(draft, 1);
  return model;
}

}  // namespace forefeel
