// Ranks of a run without MPI: threads with mailboxes. A rank that hangs, fails or sends nonsense costs its own work.

#include <latch>

#include "geometry/coverage/state_space.hpp"
#include "geometry/states/state_message.hpp"
#include "mailboxes.hpp"
#include "scheduling/workers/generate_ranks.hpp"
#include "scheduling/workers/rank_workers.hpp"
#include "small_body.hpp"

namespace {

// A clock that advances by a step at each call.
RankPool::Clock clock_in_steps(double step) {
  return [now = std::make_shared<double>(0), step] { return *now += step; };
}

LatticeOptions small_lattice() {
  LatticeOptions options;
  options.spacing = 0.006;
  options.box = {Vec3(-0.018, -0.013, -0.012), Vec3(0.012, 0.013, 0.018)};
  return options;
}

LoadWorker load_lattice_worker(const std::shared_ptr<const Body>& body) {
  return [body](const RankContext& rank) {
    return LoadedWorker{.worker = make_lattice_worker(body, small_lattice(), rank.ended), .identity = "same"};
  };
}

using Values = std::map<std::array<double, 3>, std::array<double, 14>>;
struct Collected {
  Values values;
  std::vector<State> states;
  std::function<void(State)> sink() {
    return [this](State s) {
      std::array<double, 14>& v = values[{s.at.x(), s.at.y(), s.at.z()}];
      std::memcpy(v.data(), s.force.data(), sizeof(Vec3));
      std::memcpy(v.data() + 3, s.stiffness.data(), sizeof(Mat3));
      v[12] = s.energy;
      v[13] = static_cast<double>(s.solve.status) + 10 * s.solve.multivalued;
      states.push_back(std::move(s));
    };
  }
};

Values by_one_thread(const std::shared_ptr<const Body>& body) {
  Collected all;
  LatticeOptions options = small_lattice();
  options.threads = 1;
  generate_lattice(body, options, all.sink());
  return all.values;
}

bool contains(const std::vector<std::string>& lines, const std::string& words) {
  return std::ranges::any_of(lines, [&](const std::string& line) { return line.find(words) != line.npos; });
}

}  // namespace

TEST_CASE(
    "a rank that loads early receives what rank 0 sends when the work begins, and leaves where it never "
    "does") {
  for (const bool begins : {true, false}) {
    Mail mail(2);
    std::atomic<double> received = 0;
    std::atomic<bool> left = false;
    const std::shared_ptr<const Body> body = small_body();
    std::jthread rank([&] {
      Endpoint endpoint(mail, 1);
      const LoadWorker load = [&](const RankContext& context) {
        std::optional<Bytes> message = context.begun();
        if (message)
          received = Unpacker(std::move(*message)).number<double>();
        else
          left = true;
        return LoadedWorker{.worker = make_lattice_worker(body, small_lattice(), context.ended),
                            .identity = "same"};
      };
      CHECK(serve_rank(endpoint, load, true) == ServedRank::done);
    });
    Endpoint own(mail, 0);
    RankPool pool(own);
    Packer message;
    message.add(0.0042);
    if (begins) pool.begin("same", message.take());
    if (begins) pool.wait_until_loaded(60);
    pool.stop();
    rank.join();
    CHECK(pool.all_left());
    CHECK(received == (begins ? 0.0042 : 0));
    CHECK(left == !begins);
  }
}

TEST_CASE("a lattice solved by three ranks has the bits of one solved by a thread, resumed or not") {
  for (const Law law : {Law::neo_hookean, Law::st_venant_kirchhoff}) {
    const std::shared_ptr<const Body> body = small_body(law);
    const Values expected = by_one_thread(body);
    Collected first;
    for (const bool resumed : {false, true}) {
      Mail mail(3);
      std::atomic<int> in_order = 0;
      std::vector<std::jthread> ranks;
      for (const int rank : {1, 2})
        ranks.emplace_back([&mail, &body, &in_order, rank] {
          Endpoint endpoint(mail, rank);
          in_order += serve_rank(endpoint, load_lattice_worker(body)) == ServedRank::done ? 1 : 0;
        });
      Endpoint own(mail, 0);
      RankPool pool(own);
      pool.begin("same");
      std::vector<State> known;
      if (resumed)
        for (std::size_t i = 0; i < first.states.size(); i += 3) known.push_back(first.states[i]);
      Collected found;
      const RankedGenerateReport report =
          generate_with_ranks(pool, body, small_lattice(), known, found.sink(), {}, {.queue = 2});
      CHECK(pool.all_left());
      ranks.clear();
      CHECK(in_order == 2);
      CHECK(report.farm.lost == 0);
      CHECK(report.states.solved + report.states.failed + known.size() == expected.size());
      for (const auto& [at, values] : found.values) {
        REQUIRE(expected.contains(at));
        CHECK(std::memcmp(values.data(), expected.at(at).data(), sizeof values) == 0);
      }
      if (!resumed) {
        CHECK(found.values.size() == expected.size());
        first = std::move(found);
      }
    }
  }
}

TEST_CASE(
    "a rank that takes pieces and hangs: the others solve them, all states are there, and a note says so") {
  const std::shared_ptr<const Body> body = small_body();
  Mail mail(2);
  Endpoint own(mail, 0), hanging(mail, 1);
  hanging.say_ready();
  RankPool pool(own, 10, clock_in_steps(0.05));
  pool.begin("same");
  Collected found;
  std::vector<std::string> notes;
  const RankedGenerateReport report =
      generate_with_ranks(pool, body, small_lattice(), {}, found.sink(), {},
                          {.queue = 2, .note = [&](const std::string& line) { notes.push_back(line); }});
  CHECK(found.values == by_one_thread(body));
  CHECK(report.farm.lost == 1);
  CHECK(report.farm.ranks == 2);
  CHECK_FALSE(pool.all_left());
  CHECK(contains(notes, "rank 1 has not answered for 10 s; its work goes to others"));
}

TEST_CASE("a rank that fails, or whose solves throw, loses its work to others") {
  class Broken final : public RankWorker {
    void run(Unpacker, const Give&, const std::stop_token&) override { throw std::runtime_error("no luck"); }
  };
  const std::shared_ptr<const Body> body = small_body();
  Mail mail(2);
  const std::jthread rank([&mail] {
    Endpoint endpoint(mail, 1);
    serve_rank(endpoint, [](const RankContext&) {
      return LoadedWorker{.worker = std::make_unique<Broken>(), .identity = "same"};
    });
  });
  Endpoint own(mail, 0);
  RankPool pool(own);
  pool.begin("same");
  pool.wait_until_loaded(60);
  REQUIRE(pool.taking_jobs() == 1);
  Collected found;
  generate_with_ranks(pool, body, small_lattice(), {}, found.sink(), {}, {});
  CHECK(found.values == by_one_thread(body));
  CHECK(contains(pool.notes(), "rank 1 has failed: no luck"));
}

TEST_CASE("messages without meaning do not end rank 0; their rank gets no more work") {
  const auto fate_after = [](const std::function<void(Endpoint&)>& send) {
    Mail mail(3);
    Endpoint own(mail, 0), odd(mail, 1), good(mail, 2);
    RankPool pool(own, 10, clock_in_steps(0.001));
    pool.begin("same");
    good.say_ready();
    send(odd);
    std::vector<RankEvent> events = pool.poll();
    for (RankEvent& event : pool.poll()) events.push_back(std::move(event));
    CHECK(pool.takes_jobs(2));
    const bool lost = std::ranges::any_of(
        events, [](const RankEvent& e) { return e.kind == RankEvent::Kind::lost && e.rank == 1; });
    CHECK(lost == !pool.takes_jobs(1));
    return pool.notes().empty() ? std::string() : pool.notes().front();
  };
  const std::string nonsense = "rank 1 sent a message without meaning; it gets no more work";
  CHECK(fate_after([](Endpoint& odd) { odd.send(0, 99, {}); }) == nonsense);
  CHECK(fate_after([](Endpoint& odd) { odd.send(0, -3, Bytes(1000)); }) == nonsense);
  CHECK(fate_after([](Endpoint& odd) { odd.say(RankTag::job, Bytes(8)); }) == nonsense);
  CHECK(fate_after([](Endpoint& odd) { odd.say(RankTag::result, Bytes(7)); }) == nonsense);
  CHECK(fate_after([](Endpoint& odd) { odd.say(RankTag::ready, Bytes(8, '\x7f')); }) == nonsense);
  CHECK(fate_after([](Endpoint& odd) { odd.say(RankTag::failure, Bytes(3)); }) == nonsense);
  CHECK(fate_after([](Endpoint& odd) { odd.say_ready("another"); }) ==
        "rank 1 has another build or other input; it gets no work");
}

TEST_CASE("a result that does not fit its piece is refused, and the piece is solved by others") {
  const std::shared_ptr<const Body> body = small_body();
  for (const std::size_t size : {0, 3, 4, 40, 4000}) {
    Mail mail(2);
    Endpoint own(mail, 0), odd(mail, 1);
    odd.say_ready();
    for (std::uint64_t id = 0; id < 40; ++id) {  // before any was given, and after
      Packer result;
      result.add(id);
      result.add_raw(Bytes(size, '\x01'));
      odd.say(RankTag::result, result.take());
    }
    odd.say(RankTag::left);
    RankPool pool(own);
    pool.begin("same");
    Collected found;
    generate_with_ranks(pool, body, small_lattice(), {}, found.sink(), {}, {});
    CHECK(found.values == by_one_thread(body));
  }
}

TEST_CASE("every message that ends too early is malformed, at whatever byte") {
  State state;
  state.at = Vec3(1, 2, 3);
  state.displacements = std::make_shared<const std::vector<double>>(std::vector<double>{4, 5, 6});
  Packer message;
  pack(message, state);
  const Bytes whole = message.take();
  Unpacker all(whole);
  CHECK(unpack_state(all).displacements->back() == 6);
  for (std::size_t size = 0; size < whole.size(); ++size) {
    Unpacker part(Bytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size)));
    CHECK_THROWS_AS(unpack_state(part), MalformedMessage);
  }
}

TEST_CASE("a silent rank is lost once, and has work again when it answers again") {
  Mail mail(2);
  Endpoint own(mail, 0), rank(mail, 1);
  RankPool pool(own, 1, clock_in_steps(0.01));
  pool.begin("same");
  rank.say_ready();
  REQUIRE(pool.poll().size() == 1);
  int lost = 0;
  for (int i = 0; i < 400; ++i)
    for (const RankEvent& event : pool.poll()) lost += event.kind == RankEvent::Kind::lost ? 1 : 0;
  CHECK(lost == 1);
  CHECK_FALSE(pool.takes_jobs(1));
  rank.say(RankTag::beat);
  const auto back = pool.poll();
  REQUIRE(back.size() == 1);
  CHECK(back.front().kind == RankEvent::Kind::ready);
  CHECK(pool.takes_jobs(1));
  CHECK(pool.lost() == 0);
  CHECK(contains(pool.notes(), "rank 1 answers again"));
}

TEST_CASE("time in which rank 0 itself stood still is no silence of the others") {
  Mail mail(2);
  Endpoint own(mail, 0), rank(mail, 1);
  RankPool pool(own, 10, clock_in_steps(1000));
  pool.begin("same");
  rank.say_ready();
  for (int i = 0; i < 20; ++i) pool.poll();
  CHECK(pool.takes_jobs(1));
}

TEST_CASE("a rank beats while it solves") {
  class Slow final : public RankWorker {
   public:
    explicit Slow(std::latch& end) : end_(end) {}
    void run(Unpacker, const Give& give, const std::stop_token&) override {
      end_.wait();
      give({});
    }

   private:
    std::latch& end_;
  };
  std::latch received(1);
  Mail mail(2);
  const std::jthread rank([&] {
    Endpoint endpoint(mail, 1);
    serve_rank(endpoint, [&received](const RankContext&) {
      return LoadedWorker{.worker = std::make_unique<Slow>(received), .identity = "same"};
    });
  });
  Endpoint own(mail, 0);
  own.send(1, static_cast<int>(RankTag::begin), {});
  Packer job;
  job.add(std::uint64_t{7});
  own.send(1, static_cast<int>(RankTag::job), job.take());
  int beats = 0;
  bool solved = false;
  while (!solved) {
    const auto message = own.receive();
    if (!message) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
      continue;
    }
    beats += message->tag == static_cast<int>(RankTag::beat) ? 1 : 0;
    if (beats == 1 && !received.try_wait()) received.count_down();
    solved = message->tag == static_cast<int>(RankTag::result);
  }
  CHECK(beats >= 1);
  own.send(1, static_cast<int>(RankTag::stop), {});
}

TEST_CASE(
    "a session's worker that hangs gives its states back as cancelled, and its late result is ignored") {
  Mail mail(3);
  Endpoint own(mail, 0), hanging(mail, 1), other(mail, 2);
  RankPool pool(own, 1, clock_in_steps(0.05));
  pool.begin("same");
  hanging.say_ready();
  other.say_ready();
  const auto workers = make_rank_workers(pool);
  workers->begin([] { return 1.5; });
  std::vector<JobResult> results;
  workers->collect(results, 0);
  REQUIRE(workers->takes_jobs(0));
  const Vec3 a(1, 0, 0), b(2, 0, 0);
  workers->dispatch(0, {.dispatch = 4, .at = a, .start = nullptr, .beside = {{.dispatch = 5, .at = b}}});
  while (results.empty()) {
    other.say(RankTag::beat);
    workers->collect(results, 0);
  }
  REQUIRE(results.size() == 2);
  CHECK(results[0].state.solve.status == SolveStatus::cancelled);
  CHECK(results[1].dispatch == 5);
  CHECK(results[1].state.at == b);
  CHECK_FALSE(workers->takes_jobs(0));
  CHECK(workers->takes_jobs(1));
  CHECK(contains(workers->notes(), "rank 1 has not answered for 1 s"));
  Packer late;  // of the same job
  late.add(std::uint64_t{4});
  late.add(std::uint32_t{4});
  late.add(0.1);
  State state;
  state.at = a;
  state.solve.status = SolveStatus::converged;
  pack(late, state);
  late.add(std::uint8_t{0});
  late.add(std::uint8_t{0});
  hanging.say(RankTag::result, late.take());
  workers->collect(results, 0);
  CHECK(results.empty());
  CHECK(workers->takes_jobs(0));
  workers->dispatch(1, {.dispatch = 6, .at = b, .start = nullptr});
  Packer wrong;  // another position than it was asked for
  wrong.add(std::uint64_t{6});
  wrong.add(std::uint32_t{6});
  wrong.add(0.1);
  pack(wrong, state);
  wrong.add(std::uint8_t{0});
  wrong.add(std::uint8_t{0});
  other.say(RankTag::result, wrong.take());
  workers->collect(results, 0);
  workers->collect(results, 0);
  REQUIRE(results.size() == 1);
  CHECK(results[0].state.solve.status == SolveStatus::cancelled);
  CHECK_FALSE(workers->takes_jobs(1));
}
