#include "solver/body/law.hpp"

#include <cstddef>

#include "geometry/common/instruction_set.hpp"
#include "solver/body/material.hpp"
#include "solver/kernels/kernels.hpp"

namespace forefeel {

LawConstants law_constants(const Material& material) {
  const double young = material.young, poisson = material.poisson;
  const double mu = young / (2 * (1 + poisson));
  const double lambda = young * poisson / ((1 + poisson) * (1 - 2 * poisson));
  return portable_law_entry(material.law).constants(mu, lambda);
}

bool needs_positive_jacobian(Law law) {
  return law_entry(law).needs_positive_j;
}

LawValue evaluate_law(Law law, const LawConstants& constants, const Mat3& f) {
  double rows[9], stress[9], tangent[81];
  for (int i = 0; i < 9; ++i) rows[i] = f(i / 3, i % 3);
  const LawEntry& entry = portable_law_entry(law);
  LawValue value;
  value.energy = entry.evaluate(constants, rows, stress, tangent);
  for (int i = 0; i < 9; ++i) {
    value.stress(i / 3, i % 3) = stress[i];
    for (int column = 0; column < 9; ++column) value.tangent(i, column) = tangent[9 * column + i];
  }
  return value;
}

#define FOREFEEL_LAW_DECLARED(law) extern const LawEntry law;
#define FOREFEEL_LAW_ADDRESS(law) &law,
FOREFEEL_IN_EACH_SET(FOREFEEL_LAWS(FOREFEEL_LAW_DECLARED) static constexpr const LawEntry* entries[] = {
                         FOREFEEL_LAWS(FOREFEEL_LAW_ADDRESS)};)

const LawEntry& law_entry(Law law) {
  return *FOREFEEL_CHOSEN(entries)[static_cast<std::size_t>(law)];
}

const LawEntry& portable_law_entry(Law law) {
  return *portable::entries[static_cast<std::size_t>(law)];
}

std::string_view name(Law law) {
  return portable_law_entry(law).name;
}

std::string_view form(Law law) {
  return portable_law_entry(law).form;
}

std::vector<Law> all_laws() {
#define FOREFEEL_LAW_VALUE(law) Law::law,
  return {FOREFEEL_LAWS(FOREFEEL_LAW_VALUE)};
#undef FOREFEEL_LAW_VALUE
}

}  // namespace forefeel
