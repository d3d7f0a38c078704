#include "scheduling/render/spsc_queue.hpp"
#include "scheduling/render/triple_buffer.hpp"
#include "tests/support/test.hpp"

namespace {

// Torn or stale reads would break the relation between the members.
struct Sample {
  std::uint64_t number = 0, twice = 0, square = 0, filler[9] = {};
};

Sample sample(std::uint64_t i) {
  return {.number = i, .twice = 2 * i, .square = i * i, .filler = {i, i, i, i, i, i, i, i, i}};
}

bool whole(const Sample& s) {
  return s.twice == 2 * s.number && s.square == s.number * s.number && s.filler[8] == s.number;
}

}  // namespace

TEST_CASE("triple buffer: nothing before the first value, the newest after") {
  TripleBuffer<int> buffer;
  CHECK_FALSE(buffer.take());
  CHECK_FALSE(buffer.publish(1));
  CHECK(buffer.publish(2) == 1);  // never taken: the writer's again
  CHECK(buffer.take() == 2);
  CHECK_FALSE(buffer.take());
  CHECK_FALSE(buffer.publish(3));
  CHECK(buffer.take() == 3);
}

TEST_CASE("triple buffer: values are whole, never go back, and the last one arrives") {
  for (const int pairs : {1, 2, 3, 7}) {
    std::vector<TripleBuffer<Sample>> buffers(static_cast<std::size_t>(pairs));
    std::atomic<std::uint64_t> broken{0}, backwards{0}, lost{0}, reported{0};
    constexpr std::uint64_t count = 20000;
    std::vector<std::thread> threads;
    for (auto& buffer : buffers) {
      threads.emplace_back([&] {
        std::uint64_t missed = 0;
        for (std::uint64_t i = 1; i <= count; ++i)
          if (const auto old = buffer.publish(sample(i))) missed += whole(*old) ? 1 : count;
        reported += missed;
      });
      threads.emplace_back([&] {
        std::uint64_t last = 0, taken = 0;
        while (last != count) {
          const auto s = buffer.take();
          if (!s) {
            std::this_thread::yield();
            continue;
          }
          broken += !whole(*s);
          backwards += s->number <= last;
          last = s->number;
          ++taken;
        }
        lost += count - taken;
      });
    }
    for (auto& thread : threads) thread.join();
    CHECK(broken == 0);
    CHECK(backwards == 0);
    CHECK(lost == reported);  // each value is either taken or given back, none is both
  }
}

TEST_CASE("queue: every value once, in order, and full is full") {
  SpscQueue<int, 4> small;
  CHECK(small.push(1));
  CHECK(small.push(2));
  CHECK(small.push(3));
  CHECK_FALSE(small.push(4));
  CHECK(small.pop() == 1);
  CHECK(small.push(4));
  for (const int expected : {2, 3, 4}) CHECK(small.pop() == expected);
  CHECK_FALSE(small.pop());

  for (const int pairs : {1, 2, 3, 7}) {
    std::vector<SpscQueue<std::uint64_t, 8>> queues(static_cast<std::size_t>(pairs));
    std::atomic<std::uint64_t> wrong{0};
    constexpr std::uint64_t count = 20000;
    std::vector<std::thread> threads;
    for (auto& queue : queues) {
      threads.emplace_back([&] {
        for (std::uint64_t i = 0; i < count;)
          if (queue.push(i))
            ++i;
          else
            std::this_thread::yield();
      });
      threads.emplace_back([&] {
        for (std::uint64_t i = 0; i < count;)
          if (const auto value = queue.pop())
            wrong += *value != i++;
          else
            std::this_thread::yield();
      });
    }
    for (auto& thread : threads) thread.join();
    CHECK(wrong == 0);
  }
}
