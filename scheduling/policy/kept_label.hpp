#pragma once
// The label of a place, kept up to date while states come. Labels never get worse, so a new state needs to be looked at
// only where it may change the label.

#include "geometry/coverage/coverage_query.hpp"
#include "geometry/coverage/state_space.hpp"

namespace forefeel {

struct KeptLabel {
  Label label = Label::blank;
  // Axis of an empty cone that proves the place blank; zero: unknown.
  Vec3 axis = Vec3::Zero();
};

// At another spacing than that of the space, whose triangulation serves all.
// nearest: the nearest state, searched within the sparse distance of these limits or of wider ones.
KeptLabel label_at(const StateSpace& space, const Vec3& q, const Thresholds& limits,
                   const PointOctree::Neighbour& nearest);
KeptLabel label_at(const StateSpace& space, const Vec3& q, const Thresholds& limits);

// Whether a state at p may change the label of q at spacing H. Where it is sparse or a gap: p is within 2 H. Where it
// is blank: p is near enough to make it sparse, or within 8 H and inside the empty cone.
bool may_change(const KeptLabel& kept, const Vec3& q, const Vec3& p, double H, const Thresholds& limits);

}  // namespace forefeel
