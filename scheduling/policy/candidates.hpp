#pragma once
// The positions that a policy ranks: those where a state may be solved next. They are neither known nor being
// solved.
//   LatticeCandidates   of one place of contact
//   SiteCandidates      of a body that may be touched anywhere (touch/site_candidates.hpp)

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

#include "geometry/index/adaptive_lattice.hpp"
#include "scheduling/policy/policy.hpp"

namespace forefeel {

class Candidates {
 public:
  virtual ~Candidates() = default;

  virtual std::span<const Candidate> open() const = 0;
  bool empty() const { return open().empty(); }
  virtual bool may_grow() const = 0;  // by follow()
  // Takes out the i-th open candidate, to be solved. Indices of the others change.
  virtual Candidate take(std::size_t i) = 0;
  // Takes out the candidate at rest; nullopt if that state was taken or is known.
  virtual std::optional<Candidate> take_rest() = 0;
  virtual bool wants_rest() const { return false; }  // a state at rest is missing where the hand will be
  virtual std::optional<std::size_t> index_of(const Candidate& candidate) const = 0;  // among the open ones
  virtual void put_back(Candidate candidate) = 0;     // its solve was cancelled: open again
  virtual void fail(const Candidate& candidate) = 0;  // its solve failed: never open again
  virtual void learn(
      const Candidate& known) = 0;  // a state became known: removes its candidate, updates distances
  virtual void request_near(const Vec3&, double) {}  // sets Candidate::requested of those within 2.5 spacings
  // Sets the path ahead, along which new candidates may be placed. hip: now.
  virtual void follow(std::span<const Prediction> path, const HipSample& hip, double now) = 0;
  virtual void refresh_regions() = 0;                          // updates the labels from the space
  virtual Candidate refreshed(Candidate candidate) const = 0;  // with its present label and distance
  // PlannerView::estimate, where the candidates are chosen by one; else empty.
  virtual std::function<double(const Vec3&)> estimate() const { return {}; }
};

// Of one place of contact: lattice, adaptive or path.
class LatticeCandidates final : public Candidates {
 public:
  // Positions of known and of failed states are left out. The space must outlive this.
  LatticeCandidates(const StateSpace& space, std::span<const State> failed,
                    Placement placement = Placement::lattice);

  std::span<const Candidate> open() const override { return open_; }
  bool may_grow() const override { return placement_ != Placement::lattice; }
  // Under `path`, candidates within h / 2 of it are held back. They return if put_back() or fail() reports that it will
  // not become known.
  Candidate take(std::size_t i) override;
  std::optional<Candidate> take_rest() override;  // under any placement
  std::optional<std::size_t> index_of(const Candidate& candidate) const override;
  void put_back(Candidate candidate) override;
  void fail(const Candidate& candidate) override;
  void learn(const Candidate& known) override;
  void request_near(const Vec3& hip, double now) override;
  void follow(std::span<const Prediction> path, const HipSample& hip, double now) override;
  void refresh_regions() override;  // labels never get worse, so safe candidates are skipped
  Candidate refreshed(Candidate candidate) const override;

 private:
  std::uint64_t key(const Vec3& x) const;
  void add(const Vec3& x, bool passing);
  void open_one(const Candidate& candidate);
  Candidate remove(std::size_t i);  // the last one takes its place
  bool too_near(const Vec3& x, std::span<const Vec3> places) const;
  void hold_back(const Vec3& at);
  void release();
  void split_leaves(std::span<const Prediction> path);
  bool corners_are_taken(const LatticeLeaf& leaf) const;

  const StateSpace& space_;
  Placement placement_;
  std::vector<Candidate> open_;
  std::unordered_map<std::uint64_t, std::uint32_t> place_;  // position -> index in open_
  std::unordered_map<std::uint64_t, bool> gone_;            // known at the start, failed, or seen before
  std::vector<Vec3> under_way_, failed_;                    // under `path`: being solved; failed
  std::vector<Candidate> held_;  // under `path`: within h / 2 of one that is being solved
  std::unique_ptr<AdaptiveLattice> leaves_;
  std::uint32_t order_ = 0;
  bool changed_ = true;
};

}  // namespace forefeel
