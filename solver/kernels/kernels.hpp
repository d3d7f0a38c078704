#pragma once
// The loops that take most of the time: element gradients and Hessians, and the multifrontal factorisation.
// They are compiled once per instruction set (SSE2, AVX2, AVX-512) and chosen at run time. This header and the kernel
// files include no header with inline functions: the linker might else use an inline function compiled for a newer
// processor everywhere.
//
// Shapes. Local nodes are numbered 0 .. n-1 free (in elimination order), n the contact (all contact nodes
// move as one), n+1 the clamp. A vector is (n+2) x 3; eight vectors side by side ("lanes") are (n+2) x 3 x 8.
// Elements come in groups of eight; the last group is padded with elements of no volume.

#include <cstdint>

namespace forefeel {

inline constexpr int lane_count = 8;

// Constants of a law: Lamé's mu and lambda [Pa], and up to four that the law derives from them.
struct LawConstants {
  double mu = 0, lambda = 0;
  double own[4] = {};
};

struct ElementView {
  std::int64_t groups = 0;
  int nodes_per_element = 4;           // 4 linear, 10 quadratic
  const std::int32_t* node = nullptr;  // groups x nodes x 8, local node numbers
  // Where they are added to: rows of r or y; -1 - t: row t of the tail, as other threads may add to their row.
  const std::int32_t* row = nullptr;
  const double* gradient = nullptr;  // groups x 12 x 8: gradients of the four barycentric coordinates [1/m]
  const double* volume = nullptr;    // groups x 8 [m^3]
  // groups x pairs x 8: block of the pair (a <= b), or the dummy block; -1 - t: block t of the tail
  const std::int32_t* block = nullptr;
  const std::int8_t* block_kind = nullptr;  // 0 plain, 1 transposed, 2 both (a pair within the contact)
  double* tail = nullptr;
  std::int64_t tail_stride = 0;  // of product: between the tails of the three directions
  LawConstants constants;
};

struct FieldSummary {
  double energy = 0;        // sum V psi [J]
  double min_jacobian = 0;  // least det F
};

struct ElementKernels {
  // r += dW/du; energy and least det F.
  FieldSummary (*gradient)(const ElementView&, const double* u, double* r);
  // blocks (3 x 3, row-major) += d2W/du2.
  void (*hessian)(const ElementView&, const double* u, double* blocks);
  // r += dW/du for eight displacement fields at once; energy and min_jacobian are [8].
  void (*gradient_lanes)(const ElementView&, const double* u, double* r, double* energy,
                         double* min_jacobian);
  // y_c += (d2W/du2)(u) d_c for three directions, c = 0..2; d_c and y_c are `stride` apart.
  void (*product)(const ElementView&, std::int64_t stride, const double* u, const double* d, double* y);
  // The same for each of eight fields.
  void (*product_lanes)(const ElementView&, std::int64_t stride, const double* u, const double* d, double* y);
};

// Loops for energy jets; the formulas are in law_forms.hpp.
inline constexpr int most_directions = 21;
struct JetDirections {
  int count = 0;                    // at most most_directions
  const double* ways = nullptr;     // count x 3: d
  const double* lengths = nullptr;  // count: |d|
  double* reached = nullptr;  // in and out, or null: the material limit found so far [m] (jet_maker.hpp)
  // Of each group of elements, or null: out of curvature, in of path. A bound of |G_1|^2 / |d|^2 over the square of the
  // change of F that cannot reach the limit: U alone does not reach it below 1 / sqrt of this [m].
  double* hardness = nullptr;
};
// Coefficients of the forms of degree 4 (15) and 5 (21) in d, in the order of EnergyJet.
inline constexpr int path_terms = 36;
// Numbers of a node in `fields`: u and the three fields of U, and nothing.
inline constexpr int jet_row = 16;
struct JetKernels {
  // q += second Taylor coefficient of dW/du along U d. fields: (n+2) x 16. q: (n+2) x 3 x 8, six fields side by side:
  // of d_1^2, d_1 d_2, d_1 d_3, d_2^2, d_2 d_3, d_3^2.
  void (*curvature)(const ElementView&, const double* fields, double* q, const JetDirections&);
  // out += the forms E_4(d), the coefficient of t^4 of W along u + t U d, and E_5(d), that of t^5 along u + t U d +
  // t^2 V[d, d]. v: V, as q above, or null for E_4 alone.
  void (*path)(const ElementView&, const double* fields, const double* v, double* out, const JetDirections&);
};

// What one law's file defines, once per instruction set.
struct LawEntry {
  const char* name;       // in scenes: "neo-hookean"
  const char* form;       // which of several forms of the law; "" for the only one
  bool linear;            // f = -K x exactly
  bool needs_positive_j;  // psi grows without bound as J = det F -> 0
  bool softens;           // loses stiffness in compression
  double least_stretch;   // principal stretch below which a jet is not trusted (material limit)
  LawConstants (*constants)(double mu, double lambda);
  // psi(F) - psi(I) [J/m^3], P = dpsi/dF [Pa] and dP_ij/dF_kl at (3 i + j) + 9 (3 k + l); F and P row by row.
  double (*evaluate)(const LawConstants&, const double* f, double* stress, double* tangent);
  ElementKernels kernels;
  JetKernels jets;
};

// Multifrontal Cholesky H = U^T U in 3 x 3 blocks, by Duff and Reid 1983: the free nodes fall into supernodes
// (fronts); front s eliminates `pivots` consecutive nodes from `first` on and updates `rest` later ones, the
// contact last among them. Its panel is row-major, (3 pivots) x ld, and holds the rows of U, with 1/U_pp on
// the diagonal.
struct Part {  // entries of an array, from `first` on
  std::int64_t first = 0, count = 0;
};
struct Front {
  std::int32_t first = 0, pivots = 0, rest = 0;
  std::int32_t parent = -1;                // -1: the update matrix is added to the contact's corner, K
  std::int64_t panel = 0, ld = 0;          // offset and row length in the panel store
  std::int64_t rows = 0;                   // offset of the `rest` local nodes in FrontTree::rows
  std::int64_t update = 0, update_ld = 0;  // offset and row length of the update matrix in the stack
  Part runs, children;                     // of FrontTree: extend-add into the parent; the fronts below
};
// `length` nodes that are consecutive in a front's rest and in its parent.
struct ExtendRun {
  std::int32_t from = 0, to = 0, length = 0;
};
struct FrontTree {
  std::int64_t free_nodes = 0;
  const Front* fronts = nullptr;  // in elimination order
  const std::int32_t* rows = nullptr;
  const std::int32_t* children = nullptr;
  const ExtendRun* runs = nullptr;
  const std::int64_t* row_start = nullptr;  // blocks of H, as in BlockPattern
  const std::int32_t* place = nullptr;      // per block: node position of its column in the row's front
};

// Real: type of the factor and of the vectors that are solved with it. A factor in single precision takes half the time
// and memory; it is for uses that correct its errors, such as a preconditioner.
template <class Real>
struct FactorKernels {
  // Fronts one after another. False if a pivot is not positive.
  bool (*factor)(const FrontTree&, Part fronts, const double* blocks, Real* panels, Real* stack);
  // A large front in steps whose parts threads may share, to the same values: assemble() all its rows (multiples of
  // three); then, for each block of at most block_rows pivots, its diagonal, the columns to the right of it (from and
  // to multiples of row_padding), and the update of all later rows of the panel and the update matrix.
  void (*assemble)(const FrontTree&, const Front&, Part rows, const double* blocks, Real* panels,
                   Real* stack);
  bool (*eliminate_diagonal)(const Front&, Part block, Real* panel);
  void (*eliminate_columns)(const Front&, Part block, Part columns, Real* panel);
  void (*update)(const Front&, Part block, Part rows, Real* panel, Real* update);
  std::int64_t block_rows;
  // For some fronts: U^T y = b, upwards, then U x = y - U_c x_c, downwards, where x_c is the row of the contact (0: a
  // plain solve); lanes: (n+1) x 3 x 8.
  void (*forward)(const FrontTree&, Part fronts, const Real* panels, Real* b, Real* work);
  void (*backward)(const FrontTree&, Part fronts, const Real* panels, Real* b, Real* work);
  void (*forward_lanes)(const FrontTree&, Part fronts, const Real* panels, Real* b, Real* work);
  void (*backward_lanes)(const FrontTree&, Part fronts, const Real* panels, Real* b, Real* work);
};
// Numbers of a vector register; rows of panels and update matrices are padded to a multiple of it.
template <class Real>
inline constexpr int row_padding = 64 / int(sizeof(Real));

struct FrontKernels {
  FactorKernels<double> exact;
  FactorKernels<float> single;
  // Eight vectors of `rows` entries side by side: out = a . b, and y += factor x, each lane with its own
  // factor.
  void (*dot_lanes)(std::int64_t rows, const double* a, const double* b, double* out);
  void (*add_lanes)(std::int64_t rows, const double* factor, const double* x, double* y);
  // out (3 x 8) = products of three vectors with eight side by side, b; entry i of vector c is a[i row_step + c
  // field_step].
  void (*cross_lanes)(std::int64_t rows, const double* a, std::int64_t row_step, std::int64_t field_step,
                      const double* b, double* out);
};

const FrontKernels& front_kernels();  // for instruction_set_in_use()
const char* instruction_set();        // its name: "portable", "AVX2", "AVX-512"

}  // namespace forefeel
