#include "apps/bench/lu_refit.hpp"

#include <cmath>

#include "geometry/common/instruction_set.hpp"

namespace forefeel {

FOREFEEL_IN_EACH_SET(void* make_lu(long, bool); void free_lu(void*);
                     double refit_lu(void*, long, const double*, const double*);)

namespace {

struct Functions {
  void* (*make)(long, bool);
  void (*free)(void*);
  double (*refit)(void*, long, const double*, const double*);
};

const Functions& functions() {
  static const Functions chosen{FOREFEEL_CHOSEN(make_lu), FOREFEEL_CHOSEN(free_lu),
                                FOREFEEL_CHOSEN(refit_lu)};
  return chosen;
}

}  // namespace

LuRefit::LuRefit(std::size_t states, bool hermite_quintic)
    : work_(functions().make(static_cast<long>(states), hermite_quintic)),
      states_(states),
      hermite_(hermite_quintic) {
  positions_.resize(3 * states);
  values_.resize(3 * states * (hermite_ ? 4 : 1));
}
LuRefit::~LuRefit() {
  functions().free(work_);
}

double LuRefit::refit(std::span<const Sample> samples) {
  const std::size_t n = states_, rows = hermite_ ? 4 * n : n;
  Vec3 centre = Vec3::Zero();
  for (const Sample& s : samples) centre += s.at / double(n);
  double largest = 0;
  for (const Sample& s : samples) largest = std::max(largest, (s.at - centre).squaredNorm());
  const double scale = std::sqrt(largest);
  for (std::size_t i = 0; i < n; ++i) {
    const Vec3 y = (samples[i].at - centre) / scale;
    for (std::size_t d = 0; d < 3; ++d) positions_[d * n + i] = y[Eigen::Index(d)];
    for (std::size_t c = 0; c < 3; ++c) {
      double* to = values_.data() + c * rows + (hermite_ ? 4 : 1) * i;
      to[0] = samples[i].force[Eigen::Index(c)];
      for (std::size_t d = 0; hermite_ && d < 3; ++d)
        to[1 + d] = -scale * samples[i].stiffness(Eigen::Index(c), Eigen::Index(d));
    }
  }
  return functions().refit(work_, static_cast<long>(n), positions_.data(), values_.data());
}

}  // namespace forefeel
