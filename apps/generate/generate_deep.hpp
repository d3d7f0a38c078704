#pragma once
// generate --error with contact.anywhere: where the field errs by more than is asked, jets at rest of more sites, or
// states where the estimate is worst, in rounds, until fresh random places are within it.
//
// A rerun goes through the same rounds: what the file holds is not solved again.

#include <functional>
#include <memory>
#include <span>
#include <stop_token>
#include <vector>

#include "apps/scene/field_check.hpp"

namespace forefeel {

struct DeepWork {
  std::shared_ptr<const SiteField> field;
  // Fresh random places, and as many others for the next states; one seed a round.
  std::function<std::vector<SitedPlace>(std::size_t count, unsigned seed)> places;
  // What the file holds of these, or solves; failed ones too.
  std::function<std::vector<State>(std::span<const SitedPlace>)> solve;
  // Jets at rest of these places, kept.
  std::function<std::vector<State>(std::span<const SurfacePlace>)> jets;
  std::function<void(int round, double p95)> tell;
  double error = 0.02, floor = 0;  // p95 that is wanted [1]; [N]
  int threads = 1;
  std::stop_token stop;
};

struct DeepRounds {
  std::shared_ptr<const DeepStates> known;
  FieldErrors error;  // at the last fresh places that count (field_check.hpp)
  int rounds = 0;     // that added something
};
DeepRounds refine_to(const DeepWork& work);

}  // namespace forefeel
