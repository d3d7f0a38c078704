#include "apps/session/session_states.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <optional>
#include <span>
#include <system_error>
#include <utility>
#include <vector>

#include "approx/methods/field_states.hpp"
#include "apps/scene/given_states.hpp"
#include "apps/scene/scene_session.hpp"
#include "geometry/common/error.hpp"
#include "geometry/common/output_file.hpp"
#include "geometry/states/heaps.hpp"
#include "geometry/states/state_file.hpp"
#include "scheduling/session/session_setup.hpp"

namespace forefeel {
namespace {

namespace fs = std::filesystem;

// Loads the states of a file and prepares it so that new states are appended. The file is made if it is missing.
SessionPlan extend_states(const fs::path& file, const Globals& globals, SessionPlan plan) {
  plan = with_state_file(std::move(plan), file);
  if (!fs::exists(file)) {
    check_writable(file);
    warn(globals, fmt::format("{}: no such file yet; it is made, and the session starts with no known states",
                              file.string()));
    return plan;
  }
  StateFileHeader header = states_header(plan.input.touched);
  StateFile states = StateFile::open_or_create(file, header);
  std::vector<State> known = states.read_all();
  if (plan.input.touched.anywhere) known = states_for_touch(plan.input, std::move(known));
  plan = with_known(std::move(plan), std::move(known));
  if (states.damaged() > 0) warn(globals, damage_in_words(file.string(), states.damaged(), true));
  states.drop_damaged();
  return plan;
}

// Measured forces have noise, and no stiffness: the states of their field, which a model renders. None: no field.
std::vector<State> field_of_measured(const Scene& scene, std::span<const State> measured,
                                     const std::string& file, const Globals& globals) {
  std::vector<State> usable;
  std::ranges::copy_if(measured, std::back_inserter(usable), &State::usable);
  std::optional<FieldStates> field;
  {
    Progress progress(globals, "the field of the measured forces");
    field = field_states(usable, scene.space.spacing, [&](double share) { progress.show(share, ""); });
  }
  if (!field) return {};
  say(globals, fmt::format("{}: forces without stiffness: their field (Gaussian process, noise {:.2g} N) is "
                           "rendered, with its stiffness at {} of {} places{}",
                           file, field->law.noise, field->states.size(), usable.size(),
                           field->states.size() < usable.size()
                               ? ", a quarter of the spacing apart: between closer ones noise would be slope"
                               : ""));
  return std::move(field->states);
}

}  // namespace

SessionPlan take_states(const Scene& scene, const SessionArguments& given, const Globals& globals,
                        SessionPlan plan) {
  const KnownStatesArguments& states = given.states;
  if (states.file.empty() && (states.extend || states.foreign))
    throw InputError(states.extend ? "--extend" : "--foreign",
                     "is about the file of --states, expected both");
  const fs::path own = fs::path(given.output) / "session.states";
  if (states.file.empty()) return with_state_file(std::move(plan), own);
  if (states.extend) return extend_states(states.file, globals, std::move(plan));
  std::error_code error;
  if (fs::equivalent(states.file, own, error))
    throw InputError("--states " + states.file,
                     "is where this run keeps what it solves, expected --extend to append to it, or another "
                     "folder for -o");
  GivenStates known = given_states(globals, scene, states.file, states.foreign);
  if (!plan.input.touched.anywhere && std::ranges::any_of(known.loaded.states, &State::has_site))
    throw InputError(states.file, "holds states with sites, expected a scene with contact.anywhere = true");
  if (known.belonging == Belonging::foreign) {
    if (std::ranges::none_of(known.loaded.states, &State::usable))
      throw InputError(states.file, "holds no usable state, expected some to render");
    std::vector<State>& given_forces = known.loaded.states;
    if (plan.input.touched.anywhere) {
      given_forces = states_for_touch(plan.input, std::move(given_forces));
      if (given_forces.empty())
        throw InputError(states.file,
                         "holds no state with a site, expected some to render with contact.anywhere");
      return with_foreign(std::move(plan), std::move(given_forces));
    }
    if (std::ranges::any_of(given_forces, &State::has_stiffness))
      return with_foreign(std::move(plan), std::move(given_forces));
    plan = with_foreign(std::move(plan), {});  // refused before the work
    JoinedHeaps joined = join_heaps(std::move(given_forces));
    if (joined.heaps > 0)
      say(globals, fmt::format("{}: {} rows about one place count as one", states.file, joined.rows));
    given_forces = std::move(joined.states);
    std::vector<State> field = field_of_measured(scene, given_forces, given.states.file, globals);
    if (field.empty()) return with_known(std::move(plan), std::move(given_forces));
    plan = with_known(std::move(plan), std::move(field));
    plan.input.measured = std::move(given_forces);
    return plan;
  }
  std::vector<State>& states_known = known.loaded.states;
  if (plan.input.touched.anywhere) states_known = states_for_touch(plan.input, std::move(states_known));
  return with_known(with_state_file(std::move(plan), own), std::move(states_known));
}

}  // namespace forefeel
