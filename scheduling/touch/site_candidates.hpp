#pragma once
// The candidates of a body that may be touched anywhere. The predictor says where the tip will be; the touch, or the
// place where the predicted way enters the body, says at which site. Of each predicted (s, x) two kinds of states are
// wanted:
//   a jet at rest at s itself, if none is known within a quarter of the field's spacing; these come first (take_rest)
//   states at lattice points {k h} of the tip near s + x, where the model's own estimate of its error is above the
//   tolerance; the policy ranks them
// Policies, labels of candidates and pending states are in the space of the tip, p = s + x: the metric is |p - p'|.
// Sites that are no neighbours never share a tip unless a lobe is pressed through.

#include <array>
#include <map>
#include <memory>

#include "scheduling/policy/candidates.hpp"
#include "scheduling/touch/surface_models.hpp"

namespace forefeel {

class SiteCandidates final : public Candidates {
 public:
  // space: of tips; it and the models must outlive this.
  SiteCandidates(const StateSpace& space, SurfaceModels& models);

  std::span<const Candidate> open() const override { return open_; }
  bool may_grow() const override { return true; }
  Candidate take(std::size_t i) override;
  std::optional<Candidate> take_rest() override;
  bool wants_rest() const override { return missing_jet().has_value(); }
  std::optional<std::size_t> index_of(const Candidate& candidate) const override;
  void put_back(Candidate candidate) override;
  void fail(const Candidate&) override { changed_ = true; }  // stays taken
  void learn(const Candidate& known) override;
  // Chooses anew where something has changed, else every 10 ms: a choice costs milliseconds.
  void follow(std::span<const Prediction> path, const HipSample& hip, double now) override;
  void refresh_regions() override;
  Candidate refreshed(Candidate candidate) const override;

  // The model's estimate of its error where the tip is at a place, at the site of the nearest predicted one, over the
  // tolerance.
  std::function<double(const Vec3&)> estimate() const override {
    return [this](const Vec3& tip) { return estimated(tip); };
  }

 private:
  struct Visit {
    SurfacePlace site;
    Vec3 x = Vec3::Zero();
  };
  struct Asked {
    double requested = 0;  // when it was first wanted [s]
    std::uint32_t order = 0;
  };
  using Key = std::array<std::int32_t, 6>;  // cells of the tip and of the site

  Key key_of(const SurfacePlace& site, const Vec3& tip) const;
  void predict_visits(std::span<const Prediction> path, const HipSample& hip);
  std::optional<SurfacePlace> missing_jet() const;
  bool near_jet(const SurfacePlace& site) const;
  bool in_region(const Visit& visit, const Vec3& normal) const;
  double distance(const Vec3& tip) const;
  double estimated(const Vec3& tip) const;

  const StateSpace& space_;
  SurfaceModels& models_;
  FieldOfSites field_;
  std::vector<Candidate> open_;
  std::vector<Visit> visits_;       // where the tip will press
  std::vector<SurfacePlace> jets_;  // places with a jet at rest, known or being made
  std::map<Key, Asked> asked_;
  std::map<Key, bool> gone_;  // known, being solved or failed
  double chosen_ = -1;        // when [s]
  bool changed_ = true, with_regions_ = false;
};

}  // namespace forefeel
