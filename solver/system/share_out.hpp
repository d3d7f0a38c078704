#pragma once
// Work inside one solve that threads with nothing else to do may share. The parts are the same whatever the threads,
// and each part writes what no other one reads: so are the values.

#include <cstddef>
#include <functional>

namespace forefeel {

class Crew {
 public:
  virtual ~Crew() = default;
  // Calls part(i) once for each i < count, on this thread and those that are free. Returns when all are done. A part
  // must not throw.
  virtual void share(std::size_t count, const std::function<void(std::size_t)>& part) = 0;
};

// This thread's crew during a scope; the one before returns after it.
class WithCrew {
 public:
  explicit WithCrew(Crew* crew);
  ~WithCrew();
  WithCrew(const WithCrew&) = delete;

 private:
  Crew* before_;
};

// By this thread's crew; by this thread alone if it has none.
void share_out(std::size_t count, const std::function<void(std::size_t)>& part);

}  // namespace forefeel
