#include "solver/body/law_table.hpp"

#include <cstddef>

#include "geometry/common/instruction_set.hpp"
#include "solver/body/material.hpp"

namespace forefeel {

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
