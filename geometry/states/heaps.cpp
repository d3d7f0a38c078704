#include "geometry/states/heaps.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <utility>

namespace forefeel {
namespace {

constexpr double place_share = 0.01;     // of the extent
constexpr std::size_t usual_times = 10;  // of the median number of rows
constexpr int scales = 5;                // of places that are thinned: each of twice the size

struct HeapPlace {
  Vec3 first;                     // its first row's position
  std::vector<std::size_t> rows;  // their numbers
};

std::vector<HeapPlace> places_of(std::span<const State> rows, double reach) {
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

double extent_of(std::span<const State> rows) {
  if (rows.empty()) return 0;
  Box box{rows[0].at, rows[0].at};
  for (const State& row : rows) box = {box.low.cwiseMin(row.at), box.high.cwiseMax(row.at)};
  return box.size().maxCoeff();
}

std::size_t median_rows(const std::vector<HeapPlace>& places) {
  std::vector<std::size_t> counts;
  for (const HeapPlace& place : places) counts.push_back(place.rows.size());
  const auto middle = counts.begin() + static_cast<std::ptrdiff_t>(counts.size() / 2);
  std::ranges::nth_element(counts, middle);
  return *middle;
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
  const double extent = extent_of(rows);
  if (rows.size() > usual_times && extent > 0) {
    const std::vector<HeapPlace> places = places_of(rows, place_share * extent);
    const std::size_t usual = median_rows(places);
    std::vector<char> gone(rows.size(), 0);
    std::vector<std::pair<std::size_t, State>> means;
    for (const HeapPlace& place : places) {
      if (place.rows.size() <= usual_times * usual) continue;
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

std::vector<State> thinned_heaps(std::span<const State> rows) {
  std::vector<State> kept(rows.begin(), rows.end());
  const double extent = extent_of(rows);
  if (!(extent > 0)) return kept;
  double reach = place_share * extent;
  for (int scale = 0; scale < scales; ++scale, reach *= 2) {
    const std::vector<HeapPlace> places = places_of(kept, reach);
    if (places.size() <= usual_times) break;
    const std::size_t usual = median_rows(places), most = usual_times * usual;
    std::vector<std::size_t> stay;
    for (const HeapPlace& place : places) {
      const std::size_t own = place.rows.size(), count = own > most ? usual : own;
      for (std::size_t k = 0; k < count; ++k) stay.push_back(place.rows[k * own / count]);
    }
    if (stay.size() == kept.size()) continue;
    std::ranges::sort(stay);
    for (std::size_t k = 0; k < stay.size(); ++k)
      if (k != stay[k]) kept[k] = std::move(kept[stay[k]]);
    kept.resize(stay.size());
  }
  return kept;
}

}  // namespace forefeel
