#pragma once
// The list of material laws. To add a law, add a file law_NAME.cpp to this folder and a line to this list; the word in
// scenes, the messages and the tests follow from them. See law_neo_hookean.cpp for a law in full.

#define FOREFEEL_LAWS(LAW) \
  LAW(linear)              \
  LAW(st_venant_kirchhoff) \
  LAW(neo_hookean)         \
  LAW(stable_neo_hookean)  \
  LAW(mooney_rivlin)

namespace forefeel {

#define FOREFEEL_LAW_VALUE(law) law,
enum class Law { FOREFEEL_LAWS(FOREFEEL_LAW_VALUE) };
#undef FOREFEEL_LAW_VALUE

}  // namespace forefeel
