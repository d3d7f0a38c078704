// Evaluation and switch do not allocate or lock; updates do not allocate after construction.
// malloc and pthread_mutex_lock of this executable count their calls (not under a sanitizer, which brings its
// own).

#include "approx/error/error_scale.hpp"
#include "approx/model/rbf_fit.hpp"
#include "approx/switch/force_switch.hpp"
#include "geometry/states/energy_jet.hpp"
#include "tests/approx/sets.hpp"
#include "tests/support/test.hpp"

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define FOREFEEL_COUNTS 0
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define FOREFEEL_COUNTS 0
#endif
#endif
#ifndef FOREFEEL_COUNTS
#define FOREFEEL_COUNTS 1
#endif

namespace {
std::atomic<long> allocations{0}, locks{0};
}

#if FOREFEEL_COUNTS
#include <dlfcn.h>
#include <pthread.h>

extern "C" {
void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void* malloc(std::size_t size) {
  allocations.fetch_add(1, std::memory_order_relaxed);
  return __libc_malloc(size);
}
void* calloc(std::size_t count, std::size_t size) {
  allocations.fetch_add(1, std::memory_order_relaxed);
  return __libc_calloc(count, size);
}
void* realloc(void* old, std::size_t size) {
  allocations.fetch_add(1, std::memory_order_relaxed);
  return __libc_realloc(old, size);
}
int pthread_mutex_lock(pthread_mutex_t* mutex) noexcept {
  using Lock = int (*)(pthread_mutex_t*);
  static const Lock real = reinterpret_cast<Lock>(dlsym(RTLD_NEXT, "pthread_mutex_lock"));
  locks.fetch_add(1, std::memory_order_relaxed);
  return real(mutex);
}
}
#endif

namespace {

const std::vector<ModelOptions> kinds = {
    {.kernel = Kernel::linear, .neighbours = 60},
    {.kernel = Kernel::cubic, .neighbours = 60},
    {.kernel = Kernel::quintic, .neighbours = 60},
    {.kernel = Kernel::cubic, .data = Data::force_and_stiffness, .neighbours = 25},
    {.kernel = Kernel::quintic, .data = Data::force_and_stiffness, .neighbours = 25}};

bool counting_works() {
  const long before = allocations;
  delete new std::vector<double>(10);
  return allocations > before;
}

}  // namespace

TEST_CASE("Evaluation and switch allocate nothing and lock nothing", "[realtime]") {
  if (!counting_works()) return skip("allocations are not counted in this build");
  for (const ModelOptions& options : kinds)
    for (const SwitchRule rule : {SwitchRule::paper, SwitchRule::smooth, SwitchRule::none}) {
      const auto states = states_at(hard_set("lattice", options.neighbours, 1));
      const Model a = fit_model(states, options, Vec3::Zero());
      const Model b = fit_model({states.data(), states.size() / 2}, options, Vec3::Zero());
      ForceSwitch damped({.rule = rule});
      Vec3 sum = Vec3::Zero(), force;
      Mat3 jacobian;
      const long allocated = allocations, locked = locks;
      for (int frame = 0; frame < 500; ++frame) {
        const double reach = frame % 3 == 0 ? 0.02 : frame % 3 == 1 ? 0.09 : 1.0;  // inside, between, held
        const Vec3 x(reach * 0.7, 0.3 * reach, -0.1 * reach);
        sum += damped.step(frame % 100 == 0 ? &a : frame % 100 == 50 ? &b : nullptr, x).force;
        a.evaluate(x, force, jacobian);
        sum += force + jacobian.col(0);
      }
      const long allocated_after = allocations, locked_after = locks;
      CHECK(allocated_after == allocated);
      CHECK(locked_after == locked);
      CHECK(sum.allFinite());
    }
}

TEST_CASE("A model of jets and what it says of itself allocate nothing and lock nothing", "[realtime]") {
  if (!counting_works()) return;
  auto states = states_at(hard_set("lattice", 20, 1));
  for (State& s : states) {
    s.energy = 0.1;
    s.jet = std::make_shared<const EnergyJet>(EnergyJet{.order = 4, .limit = 0.02});
  }
  const ModelOptions options{.data = Data::jet, .neighbours = 20};
  const Model a = fit_model(states, options, Vec3::Zero());
  REQUIRE(a.has_jets());
  const long allocated = allocations, locked = locks;
  Vec3 sum = Vec3::Zero(), force;
  Mat3 jacobian;
  double errors = 0;
  for (int frame = 0; frame < 500; ++frame) {
    const Vec3 x(1e-4 * frame, -5e-5 * frame, 2e-5 * frame);
    a.evaluate(x, force, jacobian);
    sum += force + jacobian.col(0);
    errors += a.at({x}).error;
  }
  const long allocated_after = allocations, locked_after = locks;
  CHECK(allocated_after == allocated);
  CHECK(locked_after == locked);
  CHECK((sum.allFinite() && errors > 0));
}

TEST_CASE("The scale of an error bar allocates nothing and locks nothing", "[realtime]") {
  if (!counting_works()) return;
  const auto states = states_at(hard_set("lattice", 40, 1));
  const ErrorScale scale(states, 0.006);
  const Vec3 force(0.1, -0.2, 0.3);
  const long allocated = allocations, locked = locks;
  ErrorScale copied;  // as the loop takes it
  double sum = 0;
  for (int frame = 0; frame < 500; ++frame) {
    copied = scale;
    sum += copied.at(Vec3(1e-5 * frame, 0, -2e-5 * frame), force);
  }
  const long allocated_after = allocations, locked_after = locks;
  CHECK(allocated_after == allocated);
  CHECK(locked_after == locked);
  CHECK((std::isfinite(sum) && sum > 0));
}

TEST_CASE("Fits and updates allocate nothing after construction", "[realtime]") {
  if (!counting_works()) return;
  for (const ModelOptions& options : kinds) {
    CAPTURE(name(options.kernel), name(options.data));
    const std::size_t n = options.neighbours;
    const auto states = states_at(hard_set("lattice", 2 * n, 2));
    std::vector<Sample> samples;
    for (std::size_t i = 0; i < states.size(); ++i)
      samples.push_back(
          {{static_cast<std::uint32_t>(i)}, states[i].at, states[i].force, states[i].stiffness});
    RbfFit fit(options, n);
    ModelDraft draft;
    draft.reserve(options);
    Model model;
    model.reserve(options);
    std::vector<StateId> removed(n);
    std::vector<Sample> added(n, samples[0]);
    const long before = allocations;
    fit.refit({samples.data(), n});
    for (std::size_t round = 0; round < 60; ++round) {
      const std::size_t k = 1 + round % 7;
      const auto swap_in = [&](std::size_t out_of, std::size_t into) {  // k from one half for k of the other
        for (std::size_t i = 0; i < k; ++i) {
          removed[i] = samples[(7 * round + i) % n + out_of].id;
          added[i] = samples[(7 * round + i) % n + into];
        }
        std::sort(removed.begin(), removed.begin() + static_cast<std::ptrdiff_t>(k));
        fit.replace({removed.data(), k}, {added.data(), k});
        fit.write(draft, Vec3::Zero());
        model.assign(draft, round + 1);
      };
      swap_in(0, n);
      swap_in(n, 0);
    }
    const long after = allocations;
    CHECK(after == before);
  }
}
