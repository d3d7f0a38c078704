// Cells of a study and reference states, shared by ranks that are threads with mailboxes.

#include <catch2/catch.hpp>
#include <thread>

#include "geometry/states/state_message.hpp"
#include "mailboxes.hpp"
#include "scheduling/study/study_ranks.hpp"
#include "scheduling/workers/reference_directory.hpp"
#include "small_body.hpp"

using namespace forefeel;
using testing::Endpoint;
using testing::Mail;
using testing::small_input;
using testing::virtual_options;

namespace {

StudyPlan small_plan() {
  const Study study{.seeds = {1, 2}, .axes = {{"policy", {{"nearest"}, {"coverage"}}}}};
  return plan_study(study, [](std::span<const std::size_t> choice) {
    StudySession session{.input = small_input(), .options = virtual_options(0.1)};
    session.options.planning.policy = choice[0] == 0 ? "nearest" : "coverage";
    return session;
  });
}

bool same(const StudyCellResult& a, const StudyCellResult& b) {
  return std::ranges::equal(a.columns(), b.columns(), [](const Column& x, const Column& y) {
    return x.name == y.name && x.value == y.value;
  });
}

// A study on ranks 0 to 2; rank 1 hangs from the start.
StudyResult run_on_three(const StudyPlan& plan, bool one_hangs) {
  Mail mail(3);
  std::vector<std::jthread> threads;
  for (const int rank : one_hangs ? std::vector<int>{2} : std::vector<int>{1, 2})
    threads.emplace_back([&mail, rank] {
      Endpoint endpoint(mail, rank);
      serve_rank(endpoint, [](const RankContext& context) {
        auto own = std::make_shared<const StudyPlan>(small_plan());
        return LoadedWorker{.worker = make_cell_worker(own, context), .identity = "same"};
      });
    });
  Endpoint own(mail, 0), hanging(mail, 1);
  if (one_hangs) hanging.say_ready();
  RankPool pool(own, 1);
  pool.begin("same");
  const auto elsewhere = [&](const std::vector<std::size_t>& cells, const StudyRunOptions::Take& take) {
    run_cells_with_ranks(pool, plan, cells, take, {});
  };
  return run_study(plan, {.elsewhere = elsewhere});
}

struct Told final : ReferenceExchange {
  void ask(const Vec3& x) override { asked.push_back(x); }
  void tell(const State& state) override { told.push_back(state.at); }
  std::vector<Vec3> asked, told;
};

Bytes question(std::uint8_t kind, std::uint32_t body, const Vec3& x) {
  Packer message;
  message.add(kind);
  message.add(body);
  message.add(x);
  return message.take();
}

}  // namespace

TEST_CASE("cells run by three ranks have the results of cells run by threads, also where a rank hangs") {
  const StudyPlan plan = small_plan();
  const StudyResult expected = run_study(plan, {.threads = 2});
  for (const bool one_hangs : {false, true}) {
    const StudyResult found = run_on_three(plan, one_hangs);
    CHECK(found.ran == 4);
    for (std::size_t i = 0; i < plan.cells.size(); ++i) CHECK(same(found.cells[i], expected.cells[i]));
  }
}

TEST_CASE(
    "a reference state that two ranks ask for is granted to one, and to the other if the first is lost") {
  const SessionInput input = small_input();
  const auto service = std::make_shared<ReferenceService>(reference_options(input), 1);
  ReferenceDirectory directory(1, [&](std::size_t) { return service; });
  const Vec3 x(0.001, 0, 0);
  directory.asked(1, Unpacker(question(0, 0, x)));
  directory.asked(2, Unpacker(question(0, 0, x)));
  auto answers = directory.answers();
  REQUIRE(answers.size() == 2);
  CHECK(answers[0].content == question(1, 0, x));  // grant
  CHECK(answers[1].content == question(2, 0, x));  // put off
  directory.lost(1);
  answers = directory.answers();
  REQUIRE(answers.size() == 1);
  CHECK(answers[0].worker == 2);
  CHECK(answers[0].content == question(1, 0, x));
  directory.asked(3, Unpacker(question(0, 0, x)));
  State state;
  state.at = x;
  state.solve.status = SolveStatus::converged;
  Packer told;
  told.add(std::uint8_t{1});
  told.add(std::uint32_t{0});
  pack(told, state);
  directory.answers();
  directory.asked(2, Unpacker(told.take()));
  answers = directory.answers();
  REQUIRE(answers.size() == 1);
  CHECK(answers[0].worker == 3);
  CHECK(service->find(x).has_value());
  CHECK_THROWS_AS(directory.asked(1, Unpacker(question(7, 0, x))), MalformedMessage);
  CHECK_THROWS_AS(directory.asked(1, Unpacker(question(0, 5, x))), MalformedMessage);
  CHECK_THROWS_AS(directory.asked(1, Unpacker(question(0, 0, Vec3(unknown, 0, 0)))), MalformedMessage);
}

TEST_CASE("a service that shares solves what it is granted, and everything once it shares no more") {
  const SessionInput input = small_input();
  ReferenceService alone(reference_options(input), 1), service(reference_options(input), 1);
  const auto exchange = std::make_shared<Told>();
  service.share(exchange);
  const Vec3 a(0.001, 0, 0), b(0.002, 0, 0), c(0.003, 0, 0);
  for (const Vec3& x : {a, b, c}) service.request(x);
  service.grant(a);
  CHECK(service.get(a).force == alone.get(a).force);
  service.put_off(b);
  const State elsewhere = alone.get(b);
  service.learn(std::span(&elsewhere, 1));
  CHECK(service.get(b).force == elsewhere.force);
  CHECK_FALSE(service.find(c).has_value());
  service.share(nullptr);
  CHECK(service.get(c).force == alone.get(c).force);
}
