#pragma once
// classify of states with sites, of a scene with contact.anywhere: where on the body, and how deep, is the force known?
// The region of states is sampled, s uniform by area over the unclamped surface, x as states are placed (depth, and
// sideways up to half of it). Labels: geometry/coverage/sited_labels.hpp; the field's jets at rest are states at x = 0.
// A share is of the samples, its standard error sqrt(p (1 - p) / n).

#include "apps/offline/classify.hpp"

namespace forefeel {

bool has_sites(const StatesInFrame& set);
// InputError without --scene, and for options that are about one place.
int classify_sites(const Globals& globals, const ClassifyArguments& arguments, const StatesInFrame& set);

}  // namespace forefeel
