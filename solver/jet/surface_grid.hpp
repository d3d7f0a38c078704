#pragma once
// A grid of cells over the rest surface, so that a moving tip learns in a microsecond whether it is inside and where
// it crosses. A facet of the smooth surface that is not flat is cut into 16 pieces, plane triangles with their corners
// on it. Each cell knows the pieces that it may hold, and whether its centre is inside. A point of the cell is inside
// as its centre is, but for the pieces that the way between them crosses. Where that way meets an edge, the solid
// angle decides. Nearer to a piece than the surface may be, its foot on the smooth surface decides. Queries allocate
// nothing and may come from any thread.

#include <cstdint>
#include <optional>
#include <vector>

#include "solver/jet/surface_map.hpp"

namespace forefeel {

class SurfaceGrid {
 public:
  explicit SurfaceGrid(const SurfaceMap& map);  // which must outlive this

  bool inside(const Vec3& point) const;
  // Where the way from `outside` to `inside` crosses the surface inwards first; none if it does not.
  std::optional<SurfacePlace> crossing(const Vec3& outside, const Vec3& inside) const;

 private:
  struct Piece {
    std::int32_t facet = -1;
    std::array<Vec3, 3> corner;  // [m]
    std::array<Vec3, 3> share;   // of the facet, barycentric
    Vec3 normal = Vec3::Zero();
  };
  void cut(std::int32_t facet);
  std::optional<SurfacePlace> first_crossing(const Vec3& outside, const Vec3& inside) const;
  std::optional<bool> inside_by_foot(const Vec3& point, std::size_t cell) const;
  SurfacePlace on_surface(const Piece& piece, const Vec3& at, const Vec3& way) const;
  bool inside_by_angle(const Vec3& point) const;
  struct Cells {  // of a box, each end included
    std::array<int, 3> low{}, high{};
    std::size_t count() const;
  };
  Cells cells_of(const Vec3& low, const Vec3& high) const;
  std::size_t number(int x, int y, int z) const;
  Vec3 centre(int x, int y, int z) const;
  // How often the way crosses these pieces; none where it meets an edge.
  std::optional<int> crossings(const Vec3& from, const Vec3& to, std::size_t cell) const;

  std::optional<int> crossings_between(std::size_t cell, std::size_t beside, const Vec3& from,
                                       const Vec3& to) const;

  const SurfaceMap& map_;
  std::vector<Piece> pieces_;
  double off_ = 0;  // how far the pieces may be from the smooth surface [m]
  Vec3 low_ = Vec3::Zero();
  double side_ = 1;  // of a cell [m]
  std::array<int, 3> cells_{1, 1, 1};
  std::vector<std::uint32_t> begin_;    // by cell, into reaching_
  std::vector<std::int32_t> reaching_;  // pieces that reach into each cell
  std::vector<char> centre_is_inside_;
};

}  // namespace forefeel
