#include "scheduling/session/input_replay.hpp"

#include <fmt/format.h>

#include <array>
#include <cstring>
#include <limits>
#include <map>
#include <memory>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "geometry/common/error.hpp"
#include "geometry/coverage/state_space.hpp"
#include "geometry/states/state_message.hpp"
#include "scheduling/render/input_format.hpp"
#include "scheduling/render/render_loop.hpp"
#include "scheduling/render/session_model.hpp"
#include "scheduling/session/session_input.hpp"
#include "scheduling/touch/surface_contact.hpp"

namespace forefeel {
namespace {

constexpr double farthest_state = 1e3;  // [m]

bool same_bits(const Vec3& a, const Vec3& b) {
  return std::memcmp(a.data(), b.data(), 3 * sizeof(double)) == 0;
}

// At the recorded position of the frame.
struct RecordedMotion final : Device {
  Vec3 position(double, const Vec3&) noexcept override { return at; }
  double duration() const override { return std::numeric_limits<double>::infinity(); }
  Vec3 at = Vec3::Zero();
};

RealTime real_time(const InputHeader& header, const double& now) {
  if (!header.real) return {};
  return {.now = [&now] { return now; }, .spare = header.spare};
}

class Replayer {
 public:
  // surface: null: one place of contact.
  Replayer(const InputReader& reader, const std::shared_ptr<const TouchTask>& surface)
      : reader_(reader),
        space_(reader.header().space),
        updater_(space_, reader.header().model),
        surface_(surface ? std::make_unique<SurfaceModels>(surface) : nullptr),
        loop_(motion_, link_, reader.header().render, reader.header().frames,
              real_time(reader.header(), now_),
              surface ? std::make_unique<SurfaceContact>(*surface, link_, reader.header().render.switching)
                      : std::unique_ptr<Contact>()) {}

  void take(const InputRecord& record, ReplayReport& report) {
    try {
      Unpacker content(record.content);
      if (record.kind == InputKind::state)
        insert(record, content, report);
      else if (record.kind == InputKind::failed)
        ++report.failed;
      else if (record.kind == InputKind::model)
        make(record, unpack_model(content), report);
      else
        frame(record, unpack_frame(content), report);
    } catch (const MalformedMessage& problem) {
      reader_.refuse(record, problem.what());
    }
  }

 private:
  void insert(const InputRecord& record, Unpacker& content, ReplayReport& report) {
    const State state = unpack_state(content);
    content.expect_end();
    if (!(state.tip().norm() < farthest_state)) reader_.refuse(record, "a state far from any body");
    if (state.has_site() != static_cast<bool>(surface_)) reader_.refuse(record, "a state of another contact");
    ++report.states;
    if (surface_) return surface_->learn(state);
    try {
      if (!space_.insert(state).is_new) reader_.refuse(record, "a state that is known already");
    } catch (const InputError& problem) {
      reader_.refuse(record, "a state that cannot be known");
    }
  }

  void make(const InputRecord& record, const ModelInput& input, ReplayReport& report) {
    const std::size_t known_states = surface_ ? surface_->known().size() : space_.size();
    if (input.states != known_states)
      reader_.refuse(record,
                     fmt::format("a model of {} states where {} are known", input.states, known_states));
    if (surface_) {
      if (surface_->newest()->serial != input.serial) reader_.refuse(record, "a model out of turn");
      ++report.models;
      return;
    }
    std::unique_ptr<Model> model = spare();
    const bool known = updater_.update(input.hip, *model);
    const std::uint64_t serial = known ? model->serial() : 0;
    if (serial != input.serial)
      reader_.refuse(record, fmt::format("model {} where {} is made", input.serial, serial));
    ++report.models;
    if (input.published)
      published_.emplace(serial, std::move(model));
    else
      spare_.push_back(std::move(model));
  }

  void frame(const InputRecord& record, const FrameInput& input, ReplayReport& report) {
    if (input.frame < loop_.next()) reader_.refuse(record, "a frame that is not later than the one before");
    if (input.model > 0) publish(record, input.model);
    if (input.ended) loop_.end();
    motion_.at = input.at;
    now_ = input.now;
    link_.planner_beat.store(input.beat);
    link_.known.store(input.known);
    loop_.frame(input.frame, input.started);
    take_back();
    compare(input, report);
  }

  void publish(const InputRecord& record, std::uint64_t serial) {
    if (surface_) {
      const SurfaceModel* model = surface_->made(serial);
      if (!model) reader_.refuse(record, fmt::format("a frame with model {}, which is none", serial));
      link_.surfaces.publish(model);
      return;
    }
    const auto mine = published_.find(serial);
    if (mine == published_.end())
      reader_.refuse(record, fmt::format("a frame with model {}, which is none", serial));
    for (auto it = published_.begin(); it != mine; it = published_.erase(it))  // never taken
      spare_.push_back(std::move(it->second));
    link_.models.publish(mine->second.get());
    in_loop_.push_back(std::move(mine->second));
    published_.erase(mine);
  }

  void take_back() {
    while (const auto returned = link_.returned.pop())
      for (std::unique_ptr<Model>& model : in_loop_)
        if (model.get() == *returned) spare_.push_back(std::move(model));
    std::erase(in_loop_, nullptr);
    while (link_.rendered.pop()) {
    }
  }

  void compare(const FrameInput& input, ReplayReport& report) {
    const Vec3 rendered = loop_.rendered(), sent = loop_.sent();
    const bool same = same_bits(rendered, input.rendered);
    ++report.frames;
    report.seconds = loop_.hip().t;
    if (same && same_bits(sent, input.sent)) {
      ++report.equal;
    } else if (!report.first) {
      report.first = {.frame = input.frame,
                      .t = loop_.hip().t,
                      .sent = same,
                      .recorded = same ? input.sent : input.rendered,
                      .replayed = same ? sent : rendered};
    }
  }

  std::unique_ptr<Model> spare() {
    if (spare_.empty()) return std::make_unique<Model>();
    std::unique_ptr<Model> model = std::move(spare_.back());
    spare_.pop_back();
    return model;
  }

  const InputReader& reader_;
  StateSpace space_;
  SessionModel updater_;
  std::unique_ptr<SurfaceModels> surface_;  // null: one place of contact
  LoopLink link_;
  RecordedMotion motion_;
  double now_ = 0;
  RenderLoop loop_;
  std::map<std::uint64_t, std::unique_ptr<Model>> published_;  // by serial number; not taken yet
  std::vector<std::unique_ptr<Model>> in_loop_, spare_;
};

}  // namespace

std::string settings_in_words(const TouchedBody& touched) {
  std::string text;
  for (const auto& [name, value] : touched.identity) text += fmt::format("{}: {}\n", name, value);
  const TouchTask& task = *touched.anywhere;
  return text + fmt::format("site_spacing: {}\ndepth: {}\nfriction: {}\n", task.site_spacing(), task.depth,
                            task.friction ? fmt::format("{}", *task.friction) : "none");
}

namespace {

// "friction: 0.3 in the record, 0.5 in the scene; depth: …": the lines that are not the same.
std::string differences(const std::string& theirs, const std::string& ours) {
  std::map<std::string, std::array<std::string, 2>> by_name;
  for (const auto& [text, side] : {std::pair(&theirs, 0U), std::pair(&ours, 1U)}) {
    std::istringstream lines(*text);
    for (std::string line; std::getline(lines, line);)
      if (const std::size_t colon = line.find(": "); colon != std::string::npos)
        by_name[line.substr(0, colon)][side] = line.substr(colon + 2);
  }
  std::string found;
  for (const auto& [name, values] : by_name)
    if (values[0] != values[1])
      found += fmt::format("{}{}: {} in the record, {} in the scene", found.empty() ? "" : "; ", name,
                           values[0].empty() ? "none" : values[0], values[1].empty() ? "none" : values[1]);
  return found;
}

std::shared_ptr<const TouchTask> surface_of(const std::filesystem::path& file, const InputRecord& record,
                                            const std::function<TouchedBody()>& touched) {
  if (!touched)
    throw InputError({.file = file.string()},
                     "is of a body that may be touched anywhere, expected its scene: --scene SCENE");
  const TouchedBody given = touched();
  const std::string ours = given.anywhere ? settings_in_words(given) : "";
  const std::string theirs(record.content.begin(), record.content.end());
  if (ours != theirs)
    throw InputError({.file = file.string()},
                     "is of another body, pad or friction than the scene: " + differences(theirs, ours));
  return given.anywhere;
}

}  // namespace

ReplayReport replay_inputs(const std::filesystem::path& file, const std::string& program,
                           const std::function<void(double)>& progress,
                           const std::function<TouchedBody()>& touched) {
  InputReader reader(file);
  ReplayReport report{.made_by = reader.header().made_by, .replayed_by = inputs_made_by(program)};
  std::optional<InputRecord> record = reader.next();
  std::shared_ptr<const TouchTask> surface;
  if (record && record->kind == InputKind::surface) {
    surface = surface_of(file, *record, touched);
    record = reader.next();
  }
  Replayer replay(reader, surface);
  for (; record; record = reader.next()) {
    if (record->kind == InputKind::surface) reader.refuse(*record, "a second body");
    replay.take(*record, report);
    if (progress && record->kind == InputKind::frame && report.frames % 1000 == 0) progress(report.seconds);
  }
  report.whole = reader.whole();
  report.bytes = reader.bytes();
  return report;
}

}  // namespace forefeel
