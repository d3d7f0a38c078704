#pragma once
// The times that solves took [s], and what the next one is expected to take. One thread owns them.

#include <algorithm>
#include <utility>
#include <vector>

#include "geometry/common/quantiles.hpp"

namespace forefeel {

class SolveTimes {
 public:
  explicit SolveTimes(double expected) : expected_(std::max(expected, least)) {}

  void note(double seconds) {
    constexpr std::size_t newest = 31;
    all_.push_back(seconds);
    const auto first = all_.end() - static_cast<std::ptrdiff_t>(std::min(newest, all_.size()));
    expected_ = std::max(median(std::vector<double>(first, all_.end())), least);
  }
  double expected() const { return expected_; }  // median of the newest; before the first, as given
  std::vector<double> take() { return std::move(all_); }

 private:
  static constexpr double least = 1e-6;
  double expected_;
  std::vector<double> all_;
};

}  // namespace forefeel
