// Steps of the force that a hand feels: sequences of frames whose answer is known.

#include "scheduling/record/felt_steps.hpp"
#include "tests/support/test.hpp"

namespace {

constexpr std::size_t step = 500;  // the frame in which something happens

// 1000 frames a second after the start-up ramp, 1 N each.
std::vector<FrameRecord> held() {
  std::vector<FrameRecord> frames(1000);
  for (std::size_t k = 0; k < frames.size(); ++k)
    frames[k].t = 1 + 1e-3 * static_cast<double>(k), frames[k].sent = Vec3::UnitX();
  return frames;
}

// The same in touch.
std::vector<FrameRecord> touching(TouchKind kind) {
  std::vector<FrameRecord> frames = held();
  for (FrameRecord& frame : frames) frame.touch.applies = true, frame.touch.kind = kind;
  return frames;
}

// The force from a frame on.
void set_from(std::vector<FrameRecord>& frames, std::size_t first, double force) {
  for (std::size_t k = first; k < frames.size(); ++k) frames[k].sent = Vec3(force, 0, 0);
}

std::vector<FeltStep> steps_in(const std::vector<FrameRecord>& frames, std::size_t ending = 0) {
  return felt_steps(frames, FeltRule(), ending);
}

void check_one(const std::vector<FeltStep>& steps, FeltCause cause, double change, double share) {
  REQUIRE(steps.size() == 1);
  CHECK(steps[0].cause == cause);
  CHECK(steps[0].change == Approx(change));
  CHECK(steps[0].share == Approx(share));
}

}  // namespace

TEST_CASE("a jump by a switch is one step, and none below the just noticeable difference") {
  std::vector<FrameRecord> frames = held();
  CHECK(steps_in(frames).empty());
  set_from(frames, step, 1.5);
  frames[step].step.change = 0.5;
  check_one(steps_in(frames), FeltCause::change_of_model, 0.5, 0.5 / 1.5);
  CHECK(steps_in(frames)[0].t == Approx(1.5));
  set_from(frames, step, 1.07);
  CHECK(steps_in(frames).empty());
  set_from(frames, step, 1.08);
  CHECK(steps_in(frames).size() == 1);
}

TEST_CASE("a switch that goes at its rule's bound all the time is not felt, up or down") {
  for (const bool up : {true, false}) {
    std::vector<FrameRecord> frames = held();
    for (std::size_t k = 1; k < frames.size(); ++k) {
      const double before = frames[k - 1].sent[0];
      frames[k].sent[0] = k < step ? before : up ? 1.007 * before : before / 1.007;
      frames[k].step.change = std::abs(frames[k].sent[0] - before);
    }
    CHECK(steps_in(frames).empty());
  }
}

TEST_CASE("steps within one window are one, steps apart are several") {
  for (const std::size_t apart : {5u, 30u}) {
    std::vector<FrameRecord> frames = held();
    set_from(frames, step, 1.2);
    set_from(frames, step + apart, 1.5);
    const std::vector<FeltStep> steps = steps_in(frames);
    REQUIRE(steps.size() == (apart == 5 ? 1 : 2));
    CHECK(steps.back().change == Approx(apart == 5 ? 0.5 : 0.3));
  }
}

TEST_CASE("a site that slides, and one that snaps, are causes that the way of the tip does not explain") {
  std::vector<FrameRecord> frames = touching(TouchKind::slip);
  for (std::size_t k = 0; k < 4; ++k) {
    set_from(frames, step + k, 1.1 + 0.1 * static_cast<double>(k));
    frames[step + k].step.motion_change = 0.1;  // holds the slide; tip_change does not
  }
  check_one(steps_in(frames), FeltCause::slip, 0.4, 0.4 / 1.4);
  frames[step + 1].touch.snaps = true;
  check_one(steps_in(frames), FeltCause::snap, 0.4, 0.4 / 1.4);
  for (std::size_t k = 0; k < 4; ++k) frames[step + k].touch.tip_change = 0.1;
  CHECK(steps_in(frames).empty());
}

TEST_CASE("a touch that begins or ends under force is felt, and the ramp at the end of a session") {
  std::vector<FrameRecord> frames = touching(TouchKind::stick);
  for (std::size_t k = 0; k < step; ++k) frames[k].touch.kind = TouchKind::none, frames[k].sent.setZero();
  check_one(steps_in(frames), FeltCause::begin, 1, 1);
  frames[step].touch.tip_change = 0.995;  // the way from the surface explains the rest
  CHECK(steps_in(frames).empty());

  frames = touching(TouchKind::stick);
  for (std::size_t k = step; k < frames.size(); ++k)
    frames[k].touch.kind = TouchKind::none, frames[k].sent.setZero();
  frames[step].step.change = 1;  // an end comes before other causes
  check_one(steps_in(frames), FeltCause::end, 1, 1);

  frames = held();
  frames[998].sent *= 0.5, frames[999].sent.setZero();
  check_one(steps_in(frames, 2), FeltCause::end, 1, 1);
  CHECK(steps_in(frames)[0].cause == FeltCause::motion);
}

TEST_CASE("the motion explains a force that rises fast, and the start-up ramp is a begin") {
  std::vector<FrameRecord> frames = held();
  for (std::size_t k = step; k < step + 50; ++k) {
    set_from(frames, k, 1 + 0.1 * static_cast<double>(k - step + 1));
    frames[k].step.motion_change = 0.1;
  }
  CHECK(steps_in(frames).empty());
  for (FrameRecord& frame : frames) frame.step.motion_change *= 0.5;
  check_one(steps_in(frames), FeltCause::motion, 0.5, 0.5 / 2);

  frames = held();
  for (std::size_t k = 0; k < frames.size(); ++k) {
    frames[k].t -= 1;
    frames[k].sent *= std::min(1.0, frames[k].t / 0.1);
  }
  check_one(steps_in(frames), FeltCause::begin, 0.1, 1);
}

TEST_CASE("a pause of the loop makes a window longer, and its motion counts") {
  std::vector<FrameRecord> frames = held();
  for (std::size_t k = step; k < frames.size(); ++k) frames[k].t += 0.05;
  set_from(frames, step, 1.5);
  frames[step].step.motion_change = 0.3;
  check_one(steps_in(frames), FeltCause::motion, 0.2, 0.2 / 1.5);
}

TEST_CASE("steps are counted by cause, with the largest of them") {
  const FeltSteps felt = counted_steps(std::vector<FeltStep>{
      {1, 0.2, 0.5, FeltCause::slip}, {2, 0.7, 0.1, FeltCause::end}, {3, 0.1, 0.2, FeltCause::slip}});
  CHECK(felt.count == 3);
  CHECK(felt.largest == 0.7);
  CHECK(felt.largest_share == 0.5);
  CHECK(in_words(felt) ==
        "2 steps of the force that a hand feels, the largest 0.2 N (50 %): 2 by a slip; apart from these 1 "
        "by the end "
        "of a "
        "touch or of the session");
  CHECK(in_words(FeltSteps()) == "0 steps of the force that a hand feels");
}
