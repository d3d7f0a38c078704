// Compiled once per instruction set.
#include "approx/loops/jet_sums.hpp"

#include "approx/loops/lanes.hpp"

namespace forefeel::FOREFEEL_ISA {
namespace {

using namespace jets;

// Places of the third derivatives: a falls, then b. At xx yy zz xy xz yz and one more axis.
constexpr std::size_t third_at[6][3] = {{0, 1, 2}, {3, 6, 7}, {5, 8, 9}, {1, 3, 4}, {2, 4, 5}, {4, 7, 8}};
constexpr std::size_t both_at[3][3] = {
    {0, 3, 4}, {3, 1, 5}, {4, 5, 2}};  // of a pair of axes in xx yy zz xy xz yz
constexpr int third_powers[10][3] = {{3, 0, 0}, {2, 1, 0}, {2, 0, 1}, {1, 2, 0}, {1, 1, 1},
                                     {1, 0, 2}, {0, 3, 0}, {0, 2, 1}, {0, 1, 2}, {0, 0, 3}};
constexpr int second_powers[6][3] = {{2, 0, 0}, {1, 1, 0}, {1, 0, 1}, {0, 2, 0}, {0, 1, 1}, {0, 0, 2}};

// Place of the coefficient a, b, c among those of its degree (geometry/states/energy_jet.hpp).
constexpr std::size_t place(int degree, int a, int c) {
  const auto below = static_cast<std::size_t>(degree - a);
  return below * (below + 1) / 2 + static_cast<std::size_t>(c);
}

struct Form {  // a homogeneous form and its derivatives at d
  Pack energy, gradient[3], hessian[6], third[10];
};

FOREFEEL_INLINE Pack at_row(const double* block, std::size_t row) {
  return load(block + row * lanes);
}

// From the third derivatives of a form of this degree.
FOREFEEL_INLINE void finish(Form& form, const Pack d[3], int degree) {
  const double of_hessian = 1.0 / (degree - 2), of_gradient = 1.0 / (degree - 1), of_energy = 1.0 / degree;
#pragma GCC unroll 6
  for (std::size_t p = 0; p < 6; ++p)
    form.hessian[p] = of_hessian * (form.third[third_at[p][0]] * d[0] + form.third[third_at[p][1]] * d[1] +
                                    form.third[third_at[p][2]] * d[2]);
#pragma GCC unroll 3
  for (std::size_t i = 0; i < 3; ++i)
    form.gradient[i] =
        of_gradient * (form.hessian[both_at[i][0]] * d[0] + form.hessian[both_at[i][1]] * d[1] +
                       form.hessian[both_at[i][2]] * d[2]);
  form.energy = of_energy * (form.gradient[0] * d[0] + form.gradient[1] * d[1] + form.gradient[2] * d[2]);
}

FOREFEEL_INLINE void set_forms(const double* block, const Pack d[3], Form forms[3]) {
#pragma GCC unroll 10
  for (std::size_t t = 0; t < 10; ++t) forms[0].third[t] = at_row(block, row_third + t);
#pragma GCC unroll 10
  for (std::size_t t = 0; t < 10; ++t) {
    const int* const p = third_powers[t];
    forms[1].third[t] = at_row(block, row_fourth + place(4, p[0] + 1, p[2])) * d[0] +
                        at_row(block, row_fourth + place(4, p[0], p[2])) * d[1] +
                        at_row(block, row_fourth + place(4, p[0], p[2] + 1)) * d[2];
  }
  const Pack products[6] = {0.5 * d[0] * d[0], d[0] * d[1], d[0] * d[2],
                            0.5 * d[1] * d[1], d[1] * d[2], 0.5 * d[2] * d[2]};
#pragma GCC unroll 10
  for (std::size_t t = 0; t < 10; ++t) {
    Pack sum{};
#pragma GCC unroll 6
    for (std::size_t m = 0; m < 6; ++m)
      sum += at_row(block, row_fifth + place(5, third_powers[t][0] + second_powers[m][0],
                                             third_powers[t][2] + second_powers[m][2])) *
             products[m];
    forms[2].third[t] = sum;
  }
  finish(forms[0], d, 3);
  finish(forms[1], d, 4);
  finish(forms[2], d, 5);
}

FOREFEEL_INLINE Pack root(Pack x) {
#if defined(__AVX512F__)
  return reinterpret_cast<Pack>(_mm512_sqrt_pd(reinterpret_cast<__m512d>(x)));
#elif defined(__AVX2__)
  return reinterpret_cast<Pack>(_mm256_sqrt_pd(reinterpret_cast<__m256d>(x)));
#else
  for (std::size_t i = 0; i < width; ++i) x[i] = __builtin_sqrt(x[i]);
  return x;
#endif
}

// S_k E_k in place of E_k, with gradient and Hessian, where |d| > R.
FOREFEEL_INLINE void slow_growth(Form& form, const Pack d[3], Pack squared, Pack radius, int degree) {
  const auto beyond = squared > radius * radius;
  const double k = degree;
  const Pack r = root(beyond ? squared : radius * radius + 1e-300), s = r - radius;
  const Pack rest = s < radius ? 1 - s / radius : Pack{}, rest2 = rest * rest;
  const Pack bend2 = rest2, bend1 = radius / 3 * (1 - rest2 * rest),
             bend0 = radius / 3 * s - radius * radius / 12 * (1 - rest2 * rest2);
  const Pack ratio = radius / r;
  Pack power = same(1);  // (R / r)^k
  for (int i = 0; i < degree; ++i) power *= ratio;
  const Pack h0 = power * (1 + k * s / radius + k * (k - 1) * bend0 / (radius * radius));
  const Pack h1 = power / radius * (k + k * (k - 1) * bend1 / radius);
  const Pack h2 = power / (radius * radius) * k * (k - 1) * bend2;
  const Pack zero{}, share = beyond ? h0 : same(1), share1 = beyond ? h1 - k * h0 / r : zero,
                     share2 = beyond ? h2 - 2 * k * h1 / r + k * (k + 1) * h0 / (r * r) : zero;
  const Pack unit[3] = {d[0] / r, d[1] / r, d[2] / r}, across = share1 / r;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = i; j < 3; ++j)
      form.hessian[both_at[i][j]] =
          share * form.hessian[both_at[i][j]] +
          share1 * (form.gradient[i] * unit[j] + unit[i] * form.gradient[j]) +
          form.energy * ((share2 - across) * unit[i] * unit[j] + (i == j ? across : zero));
  for (std::size_t i = 0; i < 3; ++i)
    form.gradient[i] = share * form.gradient[i] + share1 * form.energy * unit[i];
  form.energy *= share;
}

FOREFEEL_INLINE bool any(Lanes mask) {
  bool found = false;
  for (std::size_t i = 0; i < width; ++i) found |= mask[i] != 0;
  return found;
}

// A jet at x: E_i and Q_i with gradient and Hessian.
struct Terms {
  Pack energy, gradient[3], hessian[6];
  Pack squared, squared_gradient[3], squared_hessian[6];
  Pack own;        // q_i
  Pack confirmed;  // 1 where |d| <= t
};

FOREFEEL_INLINE void set_estimate(const double* block, const Pack d[3], const Form forms[3], Pack distance2,
                                  Terms& out) {
  Pack q = at_row(block, row_floor), first[3]{}, second[6]{};
#pragma GCC unroll 3
  for (std::size_t k = 0; k < 3; ++k) {
    const Pack share = at_row(block, row_shares + k);
    const Form& form = forms[k];
    const Pack* const g = form.gradient;
    q += share * (g[0] * g[0] + g[1] * g[1] + g[2] * g[2]);
#pragma GCC unroll 3
    for (std::size_t i = 0; i < 3; ++i)
      first[i] += share * (form.hessian[both_at[i][0]] * g[0] + form.hessian[both_at[i][1]] * g[1] +
                           form.hessian[both_at[i][2]] * g[2]);
#pragma GCC unroll 3
    for (std::size_t i = 0; i < 3; ++i)
#pragma GCC unroll 3
      for (std::size_t j = i; j < 3; ++j) {
        const std::size_t p = both_at[i][j];
        Pack sum = form.third[third_at[p][0]] * g[0] + form.third[third_at[p][1]] * g[1] +
                   form.third[third_at[p][2]] * g[2];
#pragma GCC unroll 3
        for (std::size_t m = 0; m < 3; ++m) sum += form.hessian[both_at[i][m]] * form.hessian[both_at[m][j]];
        second[p] += share * sum;
      }
  }
  const Pack inverse = at_row(block, row_trust), over = distance2 * inverse - 1;
  out.confirmed = over <= Pack{} ? same(1) : Pack{};
  const Pack beyond = over > Pack{} ? over : Pack{};
  const Pack distrust = at_row(block, row_growth);
  const Pack growth = 1 + distrust * beyond * beyond * beyond;
  const Pack slope = 6 * distrust * inverse * beyond * beyond;   // times d: the gradient of the growth
  const Pack bend = 24 * distrust * inverse * inverse * beyond;  // times d d^T
#pragma GCC unroll 3
  for (std::size_t i = 0; i < 3; ++i)
#pragma GCC unroll 3
    for (std::size_t j = i; j < 3; ++j)
      out.squared_hessian[both_at[i][j]] = 2 * growth * second[both_at[i][j]] +
                                           2 * slope * (first[i] * d[j] + d[i] * first[j]) +
                                           q * (bend * d[i] * d[j] + (i == j ? slope : Pack{}));
#pragma GCC unroll 3
  for (std::size_t i = 0; i < 3; ++i) out.squared_gradient[i] = 2 * growth * first[i] + q * slope * d[i];
  out.own = q;
  out.squared = q * growth;
}

FOREFEEL_INLINE void set_terms(const double* block, const double x[3], Terms& out) {
  Pack d[3];
  for (std::size_t i = 0; i < 3; ++i) d[i] = x[i] - at_row(block, row_at + i);
  const Pack distance2 = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
  Form forms[3];
  set_forms(block, d, forms);
  set_estimate(block, d, forms, distance2, out);
  const Pack radius = at_row(block, row_radius);
  if (any(distance2 > radius * radius))
    for (int k = 0; k < 3; ++k) slow_growth(forms[k], d, distance2, radius, k + 3);
  Pack bent[3];
#pragma GCC unroll 3
  for (std::size_t i = 0; i < 3; ++i) {
    bent[i] = at_row(block, row_bend + both_at[i][0]) * d[0] +
              at_row(block, row_bend + both_at[i][1]) * d[1] + at_row(block, row_bend + both_at[i][2]) * d[2];
    out.gradient[i] = at_row(block, row_slope + i) + bent[i] + forms[0].gradient[i] + forms[1].gradient[i] +
                      forms[2].gradient[i];
  }
  out.energy = at_row(block, row_energy) + forms[0].energy + forms[1].energy + forms[2].energy;
#pragma GCC unroll 3
  for (std::size_t i = 0; i < 3; ++i) out.energy += (at_row(block, row_slope + i) + 0.5 * bent[i]) * d[i];
#pragma GCC unroll 6
  for (std::size_t p = 0; p < 6; ++p)
    out.hessian[p] =
        at_row(block, row_bend + p) + forms[0].hessian[p] + forms[1].hessian[p] + forms[2].hessian[p];
}

constexpr std::size_t packs_in_block = lanes / width;

void blend(std::size_t blocks, const double* data, const double x[3], Blend& out) {
  Terms terms[most_blocks * packs_in_block];
  const std::size_t count = blocks * packs_in_block;
  Pack total{};
  for (std::size_t t = 0; t < count; ++t) {
    set_terms(data + (t / packs_in_block) * block_size + (t % packs_in_block) * width, x, terms[t]);
    total += 1 / (terms[t].squared * terms[t].squared);
  }
  const double scale = 1 / sum_of(total);
  Pack energy{}, gradient[3]{}, mixed[3]{}, pull[3]{}, estimate{}, confirmed{};
  Pack weights[most_blocks * packs_in_block];
  for (std::size_t t = 0; t < count; ++t) {
    const Terms& a = terms[t];
    const Pack w = weights[t] = scale / (a.squared * a.squared);
    energy += w * a.energy;
    estimate += w * a.squared;
    confirmed += w * a.confirmed;
    for (std::size_t i = 0; i < 3; ++i) gradient[i] += w * a.gradient[i];
  }
  out.energy = sum_of(energy);
  out.estimate = __builtin_sqrt(sum_of(estimate));
  out.confirmed = sum_of(confirmed);
  for (std::size_t t = 0; t < count; ++t) {
    const Terms& a = terms[t];
    const Pack steep = -2 * weights[t] / a.squared;  // times the gradient of Q: that of v, over sum v
    for (std::size_t i = 0; i < 3; ++i) {
      const Pack z = steep * a.squared_gradient[i];
      pull[i] += z;
      mixed[i] += (a.energy - out.energy) * z;
    }
  }
  double of_weights[3], mixing = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    out.gradient[i] = sum_of(gradient[i]) + sum_of(mixed[i]);
    mixing += sum_of(mixed[i]) * sum_of(mixed[i]);
    of_weights[i] = sum_of(pull[i]);
  }
  out.mixing = __builtin_sqrt(mixing);
  Pack hessian[6]{}, spread{};
  for (std::size_t t = 0; t < count; ++t) {
    const Terms& a = terms[t];
    const Pack w = weights[t], inverse = 1 / a.squared, ahead = w * (a.energy - out.energy);
    Pack n[3], apart[3];
    for (std::size_t i = 0; i < 3; ++i) {
      n[i] = inverse * a.squared_gradient[i];
      apart[i] = a.gradient[i] - out.gradient[i];
      spread += w * apart[i] * apart[i];
    }
#pragma GCC unroll 3
    for (std::size_t i = 0; i < 3; ++i)
#pragma GCC unroll 3
      for (std::size_t j = i; j < 3; ++j) {
        const std::size_t p = both_at[i][j];
        hessian[p] += w * (a.hessian[p] - 2 * (n[i] * a.gradient[j] + n[j] * a.gradient[i])) +
                      ahead * (6 * n[i] * n[j] - 2 * inverse * a.squared_hessian[p]);
      }
  }
  out.spread = __builtin_sqrt(sum_of(spread));
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = i; j < 3; ++j)
      out.hessian[both_at[i][j]] =
          sum_of(hessian[both_at[i][j]]) - of_weights[i] * out.gradient[j] - of_weights[j] * out.gradient[i];
}

void estimates(const double* block, const double x[3], double* out) {
  for (std::size_t t = 0; t < packs_in_block; ++t) {
    Terms terms;
    set_terms(block + t * width, x, terms);
    store(out + t * width, terms.own);
    store(out + lanes + t * width, terms.squared);
    for (std::size_t i = 0; i < 3; ++i) store(out + (2 + i) * lanes + t * width, -terms.gradient[i]);
    store(out + 5 * lanes + t * width, terms.energy);
  }
}

}  // namespace

extern const jets::Loops jet_loops;
const jets::Loops jet_loops = {blend, estimates};

}  // namespace forefeel::FOREFEEL_ISA
