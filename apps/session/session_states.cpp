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
#include "geometry/common/counted.hpp"
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
std::optional<FieldStates> field_of_measured(const Scene& scene, std::span<const State> measured,
                                             const std::string& file, const Globals& globals) {
  std::vector<State> usable;
  std::ranges::copy_if(measured, std::back_inserter(usable), &State::usable);
  std::optional<FieldStates> field;
  {
    Progress progress(globals, "the field of the measured forces");
    progress.show("its law");
    field = field_states(usable, scene.space.spacing, [&](double share) { progress.show(share, ""); });
  }
  if (!field) return {};
  say(globals,
      fmt::format("{}: forces without stiffness: their field (Gaussian process, noise {:.2g} N) is "
                  "rendered, with its stiffness at {} of {}{}",
                  file, field->field.law.noise, field->states.size(), counted(usable.size(), "place"),
                  field->states.size() < usable.size()
                      ? ", a quarter of the spacing apart: between closer ones noise would be slope"
                      : ""));
  return field;
}

SessionPlan with_file(SessionPlan plan, const fs::path& own) {
  return own.empty() ? std::move(plan) : with_state_file(std::move(plan), own);
}

}  // namespace

SessionPlan take_foreign(const Scene& scene, const std::string& name, std::vector<State> given,
                         const Globals& globals, SessionPlan plan) {
  if (std::ranges::none_of(given, &State::usable))
    throw InputError(name, "holds no usable state, expected some to render");
  if (plan.input.touched.anywhere) {
    given = states_for_touch(plan.input, std::move(given));
    if (given.empty())
      throw InputError(name, "holds no state with a site, expected some to render with contact.anywhere");
    return with_foreign(std::move(plan), std::move(given));
  }
  if (std::ranges::any_of(given, &State::has_stiffness))
    return with_foreign(std::move(plan), std::move(given));
  plan = with_foreign(std::move(plan), {});  // refused before the work
  JoinedHeaps joined = join_heaps(std::move(given));
  if (joined.heaps > 0)
    say(globals, fmt::format("{}: {} about one place count as one", name, counted(joined.rows, "row")));
  std::optional<FieldStates> field = field_of_measured(scene, joined.states, name, globals);
  if (!field || field->states.empty()) return with_known(std::move(plan), std::move(joined.states));
  plan = with_known(std::move(plan), std::move(field->states));
  plan.input.measured = std::move(joined.states);
  plan.input.measured_field = field->field;
  return plan;
}

SessionPlan take_states(const Scene& scene, const KnownStatesArguments& states, const fs::path& own,
                        const Globals& globals, SessionPlan plan) {
  if (states.file.empty() && (states.extend || states.foreign))
    throw InputError(states.extend ? "--extend" : "--foreign",
                     "is about the file of --states, expected both");
  if (states.file.empty()) return with_file(std::move(plan), own);
  if (states.extend) return extend_states(states.file, globals, std::move(plan));
  std::error_code error;
  if (fs::equivalent(states.file, own, error))
    throw InputError("--states " + states.file,
                     "is where this run keeps what it solves, expected --extend to append to it, or another "
                     "folder for -o");
  GivenStates known = given_states(globals, scene, states.file, states.foreign);
  std::vector<State>& states_known = known.loaded.states;
  if (!plan.input.touched.anywhere && std::ranges::any_of(states_known, &State::has_site))
    throw InputError(states.file, "holds states with sites, expected a scene with contact.anywhere = true");
  if (known.belonging == Belonging::foreign)
    return take_foreign(scene, states.file, std::move(states_known), globals, std::move(plan));
  if (plan.input.touched.anywhere) states_known = states_for_touch(plan.input, std::move(states_known));
  return with_known(with_file(std::move(plan), own), std::move(states_known));
}

}  // namespace forefeel
