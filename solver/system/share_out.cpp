#include "solver/system/share_out.hpp"

#include <utility>

namespace forefeel {
namespace {

thread_local Crew* crew_of_this_thread = nullptr;

}  // namespace

WithCrew::WithCrew(Crew* crew) : before_(std::exchange(crew_of_this_thread, crew)) {}
WithCrew::~WithCrew() {
  crew_of_this_thread = before_;
}

void share_out(std::size_t count, const std::function<void(std::size_t)>& part) {
  if (crew_of_this_thread && count > 1) return crew_of_this_thread->share(count, part);
  for (std::size_t i = 0; i < count; ++i) part(i);
}

}  // namespace forefeel
