#pragma once
// The part of a summary that is about touches of a body that may be touched anywhere.

#include "scheduling/common/session_result.hpp"

namespace forefeel {

struct TouchTask;

// Jets at rest that were made at the hand's place; they are counted apart from states.
bool is_jet_at_rest(const DispatchRecord& dispatch);
std::size_t jets_at_rest(const SessionResult& result);  // solved ones

TouchNumbers touches_of(const SessionResult& result, const TouchTask& task);

}  // namespace forefeel
