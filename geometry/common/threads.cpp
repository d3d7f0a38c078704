#include "geometry/common/threads.hpp"

#include <cstdlib>
#include <exception>
#include <latch>
#include <thread>
#include <vector>

namespace forefeel {

int threads_that_start(int wanted) {
  std::latch end(1);
  std::vector<std::jthread> threads;
  try {
    threads.reserve(static_cast<std::size_t>(wanted));
    for (int i = 0; i < wanted; ++i)
      threads.emplace_back([&end] {
        void* volatile some = std::malloc(64);  // the allocator reserves address space for a new thread
        std::free(some);
        end.wait();
      });
  } catch (const std::exception&) {  // std::system_error: no more threads; std::bad_alloc: no memory for one
  }
  end.count_down();
  return static_cast<int>(threads.size());
}

}  // namespace forefeel
