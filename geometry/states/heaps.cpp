#include "geometry/states/heaps.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <unordered_map>
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

// Cells of side `reach` over the rows and one cell about them, each with the places that begin there: a chain. Few rows
// of an extent of 1 / place_share cells do not fill them, so only their occupied cells are kept.
class PlaceCells {
 public:
  using Cell = std::array<std::int64_t, 3>;

  PlaceCells(std::span<const State> rows, double reach) : reach_(reach) {
    Box box{rows[0].at, rows[0].at};
    for (const State& row : rows) box = {box.low.cwiseMin(row.at), box.high.cwiseMax(row.at)};
    low_ = cell_of(box.low);
    const Cell high = cell_of(box.high);
    std::size_t all = 1;
    for (std::size_t a = 0; a < 3; ++a) {
      --low_[a];
      count_[a] = high[a] - low_[a] + 2;
      all *= static_cast<std::size_t>(count_[a]);
    }
    if (all <= most_empty * rows.size()) last_.assign(all, none);
  }
  Cell cell_of(const Vec3& x) const {
    Cell cell;
    for (int a = 0; a < 3; ++a) cell[static_cast<std::size_t>(a)] = std::llround(std::floor(x[a] / reach_));
    return cell;
  }
  // The last place that begins in this cell; before() gives the others.
  std::uint32_t last(const Cell& cell) const {
    const std::size_t at = index(cell);
    if (!last_.empty()) return last_[at];
    const auto found = sparse_.find(at);
    return found == sparse_.end() ? none : found->second;
  }
  std::uint32_t before(std::uint32_t place) const { return before_[place]; }
  // The next place begins here.
  void begin(const Cell& cell) {
    std::uint32_t& last =
        last_.empty() ? sparse_.try_emplace(index(cell), none).first->second : last_[index(cell)];
    before_.push_back(last);
    last = static_cast<std::uint32_t>(before_.size() - 1);
  }
  static constexpr std::uint32_t none = 0xffffffffu;

 private:
  static constexpr std::size_t most_empty = 100;  // cells to a row
  std::size_t index(const Cell& cell) const {
    return static_cast<std::size_t>(((cell[2] - low_[2]) * count_[1] + cell[1] - low_[1]) * count_[0] +
                                    cell[0] - low_[0]);
  }
  double reach_;
  Cell low_{}, count_{};
  std::vector<std::uint32_t> last_, before_;
  std::unordered_map<std::size_t, std::uint32_t> sparse_;
};

std::vector<HeapPlace> places_of(std::span<const State> rows, double reach) {
  std::vector<HeapPlace> places;
  if (rows.empty()) return places;
  PlaceCells cells(rows, reach);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const Vec3& x = rows[i].at;
    const PlaceCells::Cell cell = cells.cell_of(x);
    std::uint32_t mine = PlaceCells::none;
    for (int k = 0; k < 27 && mine == PlaceCells::none; ++k) {
      std::uint32_t p = cells.last({cell[0] + k % 3 - 1, cell[1] + k / 3 % 3 - 1, cell[2] + k / 9 - 1});
      while (p != PlaceCells::none && (places[p].first - x).squaredNorm() > reach * reach)
        p = cells.before(p);
      mine = p;
    }
    if (mine == PlaceCells::none) {
      cells.begin(cell);
      mine = static_cast<std::uint32_t>(places.size());
      places.push_back({.first = x, .rows = {}});
    }
    places[mine].rows.push_back(i);
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
