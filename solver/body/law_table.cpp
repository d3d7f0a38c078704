#include "solver/body/law_table.hpp"

#include <cstddef>

#include "solver/body/material.hpp"

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

const LawEntry& portable_law_entry(Law law) {
  return *portable::entries[static_cast<std::size_t>(law)];
}

std::string_view name(Law law) {
  return portable_law_entry(law).name;
}

std::vector<Law> all_laws() {
#define FOREFEEL_LAW_VALUE(law) Law::law,
  return {FOREFEEL_LAWS(FOREFEEL_LAW_VALUE)};
#undef FOREFEEL_LAW_VALUE
}

}  // namespace forefeel
