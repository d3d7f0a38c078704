#include "solver/body/law.hpp"

namespace forefeel {

#define FOREFEEL_LAW_DECLARED(law) extern const LawEntry law;
#define FOREFEEL_LAW_ADDRESS(law) &law,

namespace portable {
FOREFEEL_LAWS(FOREFEEL_LAW_DECLARED)
static constexpr const LawEntry* entries[] = {FOREFEEL_LAWS(FOREFEEL_LAW_ADDRESS)};
}  // namespace portable
#ifdef FOREFEEL_MULTIVERSION
namespace avx2 {
FOREFEEL_LAWS(FOREFEEL_LAW_DECLARED)
static constexpr const LawEntry* entries[] = {FOREFEEL_LAWS(FOREFEEL_LAW_ADDRESS)};
}  // namespace avx2
namespace avx512 {
FOREFEEL_LAWS(FOREFEEL_LAW_DECLARED)
static constexpr const LawEntry* entries[] = {FOREFEEL_LAWS(FOREFEEL_LAW_ADDRESS)};
}  // namespace avx512
#endif

const LawEntry& law_entry(Law law) {
  const auto number = static_cast<std::size_t>(law);
#ifdef FOREFEEL_MULTIVERSION
  if (kernel_isa() == KernelIsa::avx512) return *avx512::entries[number];
  if (kernel_isa() == KernelIsa::avx2) return *avx2::entries[number];
#endif
  return *portable::entries[number];
}

LawConstants law_constants(const Material& material) {
  const double young = material.young, poisson = material.poisson;
  const double mu = young / (2 * (1 + poisson));
  const double lambda = young * poisson / ((1 + poisson) * (1 - 2 * poisson));
  return portable::entries[static_cast<std::size_t>(material.law)]->constants(mu, lambda);
}

bool needs_positive_jacobian(Law law) {
  return law_entry(law).needs_positive_j;
}

LawValue evaluate_law(Law law, const LawConstants& constants, const Mat3& f) {
  double rows[9], stress[9], tangent[81];
  for (int i = 0; i < 9; ++i) rows[i] = f(i / 3, i % 3);
  const LawEntry& entry = *portable::entries[static_cast<std::size_t>(law)];
  LawValue value;
  value.energy = entry.evaluate(constants, rows, stress, tangent);
  for (int i = 0; i < 9; ++i) {
    value.stress(i / 3, i % 3) = stress[i];
    for (int column = 0; column < 9; ++column) value.tangent(i, column) = tangent[9 * column + i];
  }
  return value;
}

}  // namespace forefeel
