// A loop of one's own, a thousand times a second: a thread solves states where the hand goes, another keeps a model of
// them up to date, and the loop renders it through the damped switch.
// Usage: own_loop SCENE.toml [KEY=VALUE …]

#include <fmt/format.h>

#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <forefeel/forefeel.hpp>
#include <forefeel/scene.hpp>
#include <thread>

using namespace forefeel;

// Where the hand is at the time t: pressing 1 cm in and out, and drifting sideways [m].
Vec3 hand(double t) {
  return {0.004 * std::sin(1.3 * t), 0, -0.005 * (1 - std::cos(2 * M_PI * t / 4))};
}

// What the planner hands to the loop. The loop never waits: it takes a slot when there is a new one, and says which it
// no longer needs.
struct Handover {
  std::array<Model, 4> slots;
  std::atomic<int> newest{-1};
  std::array<std::atomic<bool>, 4> in_use{};
};

int main(int argc, char** argv) try {
  if (argc < 2) return fmt::print(stderr, "usage: own_loop SCENE.toml [KEY=VALUE ...]\n"), 2;
  // 1. The scene.
  const SceneInput scene = read_scene(argv[1], {argv + 2, argv + argc});
  for (const std::string& warning : scene.warnings) fmt::print(stderr, "{}\n", warning);
  const StateSpaceOptions& options = scene.input.touched.space;

  // 2. Planner and worker in one thread: the unknown place of the lattice nearest to the hand is solved, and the model
  // is updated.
  Handover handover;
  std::atomic<double> now{0};
  std::atomic<int> solved{0};
  std::jthread planner([&](std::stop_token stop) {
    StateSpace space(options);
    ModelUpdater updater(space, scene.options.model.fit);
    Solver solver(scene.input.touched.body);
    const std::vector<Vec3> places = lattice(options.box, options.spacing);
    while (!stop.stop_requested()) {
      const Vec3 x = hand(now);
      const Vec3* best = nullptr;
      for (const Vec3& place : places)
        if ((!best || (place - x).squaredNorm() < (*best - x).squaredNorm()) && !space.find(place).valid())
          best = &place;
      if (best) {
        const State state = solver.reference(*best, options.spacing).state;
        if (state.usable()) solved += space.insert(state).is_new ? 1 : 0;
      }
      // A slot that the loop does not read.
      std::size_t slot = 0;
      while (slot < 4 && handover.in_use[slot].exchange(true)) ++slot;
      if (slot == 4) continue;
      if (updater.update(hand(now), handover.slots[slot])) {
        const int unseen = handover.newest.exchange(static_cast<int>(slot));
        if (unseen >= 0) handover.in_use[static_cast<std::size_t>(unseen)] = false;
      } else {
        handover.in_use[slot] = false;
      }
    }
  });

  // 3. The loop: 1 kHz for four seconds. Nothing in it allocates, locks or throws.
  ForceSwitch switched;
  const auto begin = std::chrono::steady_clock::now();
  double largest_change = 0, late = 0;
  Vec3 last = Vec3::Zero();
  for (int frame = 0; frame < 4000; ++frame) {
    const auto due = begin + std::chrono::milliseconds(frame);
    std::this_thread::sleep_until(due);
    late = std::max(late, std::chrono::duration<double>(std::chrono::steady_clock::now() - due).count());
    now = 1e-3 * frame;
    const int slot = handover.newest.exchange(-1);
    const Model* model = slot < 0 ? nullptr : &handover.slots[static_cast<std::size_t>(slot)];
    const ForceSwitch::Step step = switched.step(model, hand(now));
    for (const Model* released : {step.released, step.released_too})
      if (released) handover.in_use[static_cast<std::size_t>(released - handover.slots.data())] = false;
    largest_change = std::max(largest_change, (step.force - last).norm());
    last = step.force;
    if (frame % 500 == 0)
      fmt::print("{:.1f} s: {:3} states, force {:6.3f} {:6.3f} {:6.3f} N\n", now.load(), solved.load(),
                 last.x(), last.y(), last.z());
  }
  planner.request_stop();
  fmt::print("{} states; largest change in a millisecond {:.1f} mN; latest frame {:.2f} ms late\n",
             solved.load(), 1e3 * largest_change, 1e3 * late);
} catch (const InputError& error) {
  fmt::print(stderr, "{}\n", error.what());
  return 2;
}
