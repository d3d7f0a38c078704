#pragma once
// Decides which rank solves which reference state. Rank 0 keeps one directory for all ranks, so that each state is
// solved once.
//   worker -> rank 0   ask (body, x): may it be solved here? · told (body, state): it was solved here
//   rank 0 -> worker   state (body, state) · grant (body, x): solve it · put off (body, x): another rank solves it

#include <cstddef>
#include <functional>
#include <map>
#include <memory>
#include <vector>

#include "scheduling/workers/farm.hpp"
#include "scheduling/workers/reference_service.hpp"

namespace forefeel {

// A process's reference services, by the number of the body.
using ServiceOfBody = std::function<std::shared_ptr<ReferenceService>(std::size_t body)>;

// Rank 0. The services of its own process hold all states that are known.
class ReferenceDirectory {
 public:
  ReferenceDirectory(std::size_t bodies, ServiceOfBody services);
  void asked(int worker, Unpacker question);  // MalformedMessage
  void lost(int worker);                      // its states are granted to others
  std::vector<FarmWork::Answer> answers();    // since the last call

 private:
  struct Less {
    bool operator()(const Vec3& a, const Vec3& b) const;
  };
  struct Solving {
    int worker = 0;
    std::vector<int> waiting = {};
  };
  using Places = std::map<Vec3, Solving, Less>;
  void ask(int worker, std::size_t body, const Vec3& x);
  void tell(int worker, std::size_t body, const State& state);

  ServiceOfBody services_;
  std::vector<Places> solving_;  // by body
  std::vector<FarmWork::Answer> answers_;
};

// The side of the other ranks: asks rank 0.
std::shared_ptr<ReferenceExchange> make_reference_exchange(std::size_t body, std::function<void(Bytes)> ask);
void take_answer(Unpacker answer, std::size_t bodies, const ServiceOfBody& services);

}  // namespace forefeel
