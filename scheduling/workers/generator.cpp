#include "scheduling/workers/generator.hpp"

#include "scheduling/common/registry.hpp"
#include "scheduling/workers/built_in_workers.hpp"

namespace forefeel {
namespace {

Registry<WorkersKind>& workers_registry() {
  static Registry<WorkersKind> kinds(
      "workers", {{"threads", {.real = make_worker_threads, .simulated = make_simulated_workers}, ""}});
  return kinds;
}

template <class Factory>
void expect_some(const Factory& factory, const Registered& workers, const char* missing, const char* other) {
  if (!factory)
    throw InputError({.key = "workers", .value = to_text(workers)},
                     fmt::format("has no workers for the {} clock, expected --clock {}", missing, other));
}

const auto& real_of(const WorkersKind& kind, const Registered& workers) {
  expect_some(kind.real, workers, "real", "virtual");
  return kind.real;
}
const auto& simulated_of(const WorkersKind& kind, const Registered& workers) {
  expect_some(kind.simulated, workers, "virtual", "real");
  return kind.simulated;
}

}  // namespace

void register_workers(const std::string& name, WorkersKind kind) {
  if (!kind.real && !kind.simulated)
    throw InputError("register workers",
                     name + " makes no workers, expected at least one of the two factories");
  workers_registry().add(name, std::move(kind));
}

std::vector<std::string> workers_names() {
  return workers_registry().names();
}

std::unique_ptr<RealWorkers> make_real_workers(const Registered& workers, const RealWorkersContext& context) {
  const WorkersKind kind = workers_registry().at(workers.name);
  return make_registered(real_of(kind, workers), "workers", workers, context);
}

std::unique_ptr<VirtualWorkers> make_virtual_workers(const Registered& workers,
                                                     const VirtualWorkersContext& context) {
  const WorkersKind kind = workers_registry().at(workers.name);
  return make_registered(simulated_of(kind, workers), "workers", workers, context);
}

void check_workers(const Registered& workers, bool virtual_clock) {
  const WorkersKind kind = workers_registry().at(workers.name);
  if (virtual_clock)
    simulated_of(kind, workers);
  else
    real_of(kind, workers);
}

}  // namespace forefeel
