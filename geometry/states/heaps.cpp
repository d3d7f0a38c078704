#include "geometry/states/heaps.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>

namespace forefeel {
namespace {

constexpr double place_share = 0.01;     // of the extent
constexpr std::size_t usual_times = 10;  // of the median number of rows

struct HeapPlace {
  Vec3 first;                     // its first row's position
  std::vector<std::size_t> rows;  // their numbers
};

std::vector<HeapPlace> places_of(const std::vector<State>& rows, double reach) {
  using Cell = std::array<std::int64_t, 3>;
  std::map<Cell, std::vector<std::size_t>> cells;  // places that begin there
  std::vector<HeapPlace> places;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const Vec3& x = rows[i].at;
    Cell cell;
    for (int a = 0; a < 3; ++a) cell[static_cast<std::size_t>(a)] = std::llround(std::floor(x[a] / reach));
    HeapPlace* mine = nullptr;
    for (int k = 0; k < 27 && !mine; ++k) {
      const auto found = cells.find({cell[0] + k % 3 - 1, cell[1] + k / 3 % 3 - 1, cell[2] + k / 9 - 1});
      if (found == cells.end()) continue;
      for (const std::size_t p : found->second)
        if ((places[p].first - x).squaredNorm() <= reach * reach) mine = &places[p];
    }
    if (!mine) {
      cells[cell].push_back(places.size());
      places.push_back({.first = x, .rows = {}});
      mine = &places.back();
    }
    mine->rows.push_back(i);
  }
  return places;
}

State mean_of(const std::vector<State>& rows, const HeapPlace& heap) {
  const auto n = static_cast<double>(heap.rows.size());
  State mean;
  mean.at.setZero();
  mean.force.setZero();
  for (const std::size_t i : heap.rows) {
    mean.at += rows[i].at / n;
    mean.force += rows[i].force / n;
  }
  return mean;
}

}  // namespace

JoinedHeaps join_heaps(std::vector<State> rows) {
  JoinedHeaps joined;
  Vec3 low = Vec3::Zero(), high = Vec3::Zero();
  for (std::size_t i = 0; i < rows.size(); ++i) {
    low = i == 0 ? rows[i].at : Vec3(low.cwiseMin(rows[i].at));
    high = i == 0 ? rows[i].at : Vec3(high.cwiseMax(rows[i].at));
  }
  const double extent = (high - low).maxCoeff();
  if (rows.size() > usual_times && extent > 0) {
    const std::vector<HeapPlace> places = places_of(rows, place_share * extent);
    std::vector<std::size_t> counts;
    for (const HeapPlace& place : places) counts.push_back(place.rows.size());
    const auto middle = counts.begin() + static_cast<std::ptrdiff_t>(counts.size() / 2);
    std::ranges::nth_element(counts, middle);
    std::vector<char> gone(rows.size(), 0);
    std::vector<std::pair<std::size_t, State>> means;
    for (const HeapPlace& place : places) {
      if (place.rows.size() <= usual_times * *middle) continue;
      means.emplace_back(place.rows.front(), mean_of(rows, place));
      for (const std::size_t i : place.rows) gone[i] = 1;
      ++joined.heaps;
      joined.rows += place.rows.size();
    }
    for (auto& [at, mean] : means) {
      rows[at] = std::move(mean);
      gone[at] = 0;
    }
    for (std::size_t i = 0; i < rows.size(); ++i)
      if (!gone[i]) joined.states.push_back(std::move(rows[i]));
    return joined;
  }
  joined.states = std::move(rows);
  return joined;
}

}  // namespace forefeel
