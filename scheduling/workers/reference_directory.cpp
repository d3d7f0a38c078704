#include "scheduling/workers/reference_directory.hpp"

#include <algorithm>
#include <span>
#include <utility>

#include "geometry/states/state_message.hpp"

namespace forefeel {
namespace {

enum class Question : std::uint8_t { ask, told };
enum class Reply : std::uint8_t { state, grant, put_off };

template <class Kind>
Packer begun(Kind kind, std::size_t body) {
  Packer message;
  message.add(kind);
  message.add(std::uint32_t(body));
  return message;
}

Bytes with_place(Packer message, const Vec3& x) {
  message.add(x);
  return message.take();
}

Bytes with_state(Packer message, const State& state) {
  pack(message, state);
  return message.take();
}

template <class Kind>
std::pair<Kind, std::size_t> opened(Unpacker& message, std::size_t bodies, Kind last) {
  const auto kind = message.number<std::uint8_t>();
  const auto body = message.number<std::uint32_t>();
  if (kind > static_cast<std::uint8_t>(last) || body >= bodies)
    throw MalformedMessage("of an unknown kind, or about an unknown body");
  return {static_cast<Kind>(kind), body};
}

Vec3 place(Unpacker& message) {
  const Vec3 x = message.vector();
  message.expect_end();
  if (!x.allFinite()) throw MalformedMessage("a position is not finite");
  return x;
}

State state_of(Unpacker& message) {
  State state = unpack_state(message);
  message.expect_end();
  return state;
}

class RankExchange final : public ReferenceExchange {
 public:
  RankExchange(std::size_t body, std::function<void(Bytes)> ask) : body_(body), ask_(std::move(ask)) {}
  void ask(const Vec3& x) override { ask_(with_place(begun(Question::ask, body_), x)); }
  void tell(const State& state) override { ask_(with_state(begun(Question::told, body_), state)); }

 private:
  std::size_t body_;
  std::function<void(Bytes)> ask_;
};

}  // namespace

bool ReferenceDirectory::Less::operator()(const Vec3& a, const Vec3& b) const {
  return std::lexicographical_compare(a.data(), a.data() + 3, b.data(), b.data() + 3);
}

ReferenceDirectory::ReferenceDirectory(std::size_t bodies, ServiceOfBody services)
    : services_(std::move(services)), solving_(bodies) {}

void ReferenceDirectory::asked(int worker, Unpacker question) {
  const auto [kind, body] = opened(question, solving_.size(), Question::told);
  if (kind == Question::ask)
    ask(worker, body, place(question));
  else
    tell(worker, body, state_of(question));
}

void ReferenceDirectory::ask(int worker, std::size_t body, const Vec3& x) {
  if (const std::optional<State> known = services_(body)->find(x)) {
    answers_.push_back({worker, with_state(begun(Reply::state, body), *known)});
    return;
  }
  const auto [at, is_new] = solving_[body].try_emplace(x, Solving{.worker = worker});
  if (!is_new) at->second.waiting.push_back(worker);
  answers_.push_back({worker, with_place(begun(is_new ? Reply::grant : Reply::put_off, body), x)});
}

void ReferenceDirectory::tell(int worker, std::size_t body, const State& state) {
  if (worker > 0) services_(body)->learn_and_keep(state);
  const auto at = solving_[body].find(state.at);
  if (at == solving_[body].end()) return;
  for (const int other : at->second.waiting)
    if (other > 0 && other != worker)
      answers_.push_back({other, with_state(begun(Reply::state, body), state)});
  solving_[body].erase(at);
}

void ReferenceDirectory::lost(int worker) {
  for (std::size_t body = 0; body < solving_.size(); ++body)
    for (auto at = solving_[body].begin(); at != solving_[body].end();) {
      Solving& solving = at->second;
      if (solving.worker != worker) {
        ++at;
        continue;
      }
      std::erase(solving.waiting, worker);
      if (solving.waiting.empty()) {
        at = solving_[body].erase(at);
        continue;
      }
      solving.worker = solving.waiting.front();
      solving.waiting.erase(solving.waiting.begin());
      answers_.push_back({solving.worker, with_place(begun(Reply::grant, body), at->first)});
      ++at;
    }
}

std::vector<FarmWork::Answer> ReferenceDirectory::answers() {
  return std::exchange(answers_, {});
}

std::shared_ptr<ReferenceExchange> make_reference_exchange(std::size_t body, std::function<void(Bytes)> ask) {
  return std::make_shared<RankExchange>(body, std::move(ask));
}

void take_answer(Unpacker answer, std::size_t bodies, const ServiceOfBody& services) {
  const auto [kind, body] = opened(answer, bodies, Reply::put_off);
  const std::shared_ptr<ReferenceService> service = services(body);
  if (kind == Reply::state) {
    const State state = state_of(answer);
    service->learn(std::span(&state, 1));
  } else if (kind == Reply::grant) {
    service->grant(place(answer));
  } else {
    service->put_off(place(answer));
  }
}

}  // namespace forefeel
