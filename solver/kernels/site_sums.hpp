#pragma once
// Sums over states that correct a field of sites (solver/jet/deep_states.hpp), several states at a time: the weights
// p_k and the corrections p_k C_k / c(s)^2 at one (s, x), with their derivatives. All is a function of u = B(s) x, of
// the normal n(s), and of s where it stands alone. A state's polynomial is one in z - z_k, z = Q_k u.

#include <cstdint>

#include "solver/kernels/kernels.hpp"

namespace forefeel {

inline constexpr double site_softening = 1e-12;  // q^2 at a state, where its weight would be infinite
inline constexpr int series_terms = 56;          // of a polynomial to degree 5

struct SiteRow {
  double at[3] = {}, normal[3] = {};  // s_k [m] and n_k
  double z[3] = {};                   // z_k; 0 of a jet at rest
  double metric[6] = {};              // |y|^2 = z^T M z: xx, xy, xz, yy, yz, zz
  double near = 0;                    // 1 / reach_k^2 [1/m^2]; 0 of a jet at rest
  double growth = 0;                  // 1 / |x_k|^2 [1/m^2]; 0 of a jet at rest
  double reach = 0;                   // 1 / reach^2 of delta [1/m^2]
  double unused[6] = {};              // rows are read eight numbers at a time
  double series[series_terms] = {};   // P_k / c_k^2
};

// Of eight states what is looked at first, side by side. The last of a list is filled up with none.
struct SitePack {
  double at[3][lane_count], normal[3][lane_count], reach[lane_count];
  double way[3][lane_count];  // over the surface, from a facet's corners to the site [m]
  const SiteRow* row[lane_count] = {};
  const SitePack* next = nullptr;
};

struct SiteQuestion {
  double at[3] = {}, normal[3] = {}, u[3] = {};
  double share[3] = {}, share_by[9] = {};  // barycentric in the facet, and the gradients [1/m]
  double root[9] = {};                     // B
  double square = 0;                       // L^2 of delta [m^2]
  double far = 0;                          // along the surface, from where on a state fades [m]
};

// A sum with its derivatives by u, n and s; bend: second ones by u, xx, xy, xz, yy, yz, zz.
struct SiteSum {
  double value = 0, by_u[3] = {}, by_normal[3] = {}, by_site[3] = {}, bend[6] = {};
};
struct SiteSums {
  SiteSum weights, values;
  double slope[3] = {};  // sum of p_k dC_k/du
  double square = 0;     // sum of p_k |B dC_k/du|^2
};

// What is kept of one place of a field over facets (solver/jet/field_patches.hpp).
inline constexpr int place_terms = 55;

struct SiteKernels {
  // Adds. The second has bend, too.
  void (*slopes)(const SitePack*, const SiteQuestion&, SiteSums&);
  void (*bends)(const SitePack*, const SiteQuestion&, SiteSums&);
  // out[j] = sum_k weight[k][j] row[k], of rows of place_terms numbers.
  void (*places)(const double* const* row, const double (*weight)[4], int count, double (*out)[place_terms]);
};
const SiteKernels& site_kernels();  // for instruction_set_in_use()

}  // namespace forefeel
