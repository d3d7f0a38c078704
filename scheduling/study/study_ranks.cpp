#include "scheduling/study/study_ranks.hpp"

#include <deque>
#include <set>
#include <stop_token>
#include <utility>

#include "scheduling/workers/rank_listener.hpp"
#include "scheduling/workers/reference_directory.hpp"

namespace forefeel {
namespace {

Bytes packed(std::uint64_t cell, const StudyCellResult& row) {
  Packer message;
  message.add(cell);
  message.add(std::uint32_t(row.columns().size()));
  for (const Column& column : row.columns()) {
    message.add(std::string_view(column.name));
    message.add(std::uint8_t(column.value.index()));
    if (const auto* flag = std::get_if<bool>(&column.value)) message.add(std::uint8_t{*flag});
    if (const auto* integer = std::get_if<std::uint64_t>(&column.value)) message.add(*integer);
    if (const auto* number = std::get_if<double>(&column.value)) message.add(*number);
    if (const auto* text = std::get_if<std::string>(&column.value)) message.add(std::string_view(*text));
  }
  message.add(std::uint32_t(row.notes().size()));
  for (const std::string& note : row.notes()) message.add(std::string_view(note));
  return message.take();
}

ColumnValue unpacked_value(Unpacker& message) {
  switch (message.number<std::uint8_t>()) {
    case 0:
      return {};
    case 1:
      return message.number<std::uint8_t>() != 0;
    case 2:
      return message.number<std::uint64_t>();
    case 3:
      return message.number<double>();
    case 4:
      return message.text();
    default:
      throw MalformedMessage("a column of an unknown kind");
  }
}

StudyCellResult unpacked(std::uint64_t cell, Unpacker message) {
  if (message.number<std::uint64_t>() != cell) throw MalformedMessage("another cell");
  std::vector<Column> columns;
  for (auto left = message.number<std::uint32_t>(); left > 0; --left) {
    std::string name = message.text();
    columns.push_back({std::move(name), unpacked_value(message)});
  }
  std::vector<std::string> notes;
  for (auto left = message.number<std::uint32_t>(); left > 0; --left) notes.push_back(message.text());
  message.expect_end();
  StudyCellResult row(std::move(columns));
  row.set_notes(std::move(notes));
  return row;
}

class CellWork final : public FarmWork {
 public:
  CellWork(const std::vector<std::size_t>& cells, const StudyRunOptions::Take& take,
           ReferenceDirectory directory)
      : open_(cells.begin(), cells.end()),
        left_(cells.begin(), cells.end()),
        take_(take),
        directory_(std::move(directory)) {}

  std::optional<Piece> next(int) override {
    while (!open_.empty()) {
      const std::uint64_t cell = open_.front();
      open_.pop_front();
      if (!left_.contains(cell)) continue;  // was offered again, but its first worker has finished it since
      Packer message;
      message.add(cell);
      return Piece{cell, message.take()};
    }
    return {};
  }
  void done(std::uint64_t cell, int, Unpacker result) override {
    StudyCellResult row = unpacked(cell, std::move(result));
    if (left_.erase(cell) > 0) take_(cell, std::move(row));
  }
  void again(std::uint64_t cell) override { open_.push_front(cell); }
  void lost(int worker) override { directory_.lost(worker); }
  bool finished() const override { return left_.empty(); }
  void asked(int worker, Unpacker question) override { directory_.asked(worker, std::move(question)); }
  std::vector<Answer> answers() override { return directory_.answers(); }

 private:
  std::deque<std::uint64_t> open_;
  std::set<std::uint64_t> left_;
  const StudyRunOptions::Take& take_;
  ReferenceDirectory directory_;
};

// Runs cells until its rank must end; then the running one is dropped.
class CellWorker final : public RankWorker {
 public:
  CellWorker(CellRunner& runner, std::atomic<bool>& interrupted, const RankContext& rank, std::size_t bodies)
      : runner_(runner),
        interrupted_(interrupted),
        rank_(rank),
        on_end_(rank.ended, End{runner, interrupted}) {
    rank_.listen([&runner, bodies](Bytes answer) {
      take_answer(Unpacker(std::move(answer)), bodies,
                  [&](std::size_t body) { return runner.references(body); });
    });
  }
  ~CellWorker() override { rank_.listen(nullptr); }

  void run(Unpacker piece, const Give& give, const std::stop_token&) override {
    const auto cell = piece.number<std::uint64_t>();
    piece.expect_end();
    StudyCellResult row = runner_.run(cell);
    if (!interrupted_) give(packed(cell, row));
  }

 private:
  // Rank 0 answers no more, so the reference states that the running cell waits for are solved here.
  struct End {
    CellRunner& runner;
    std::atomic<bool>& interrupted;
    void operator()() const {
      interrupted = true;
      runner.share_no_more();
    }
  };
  CellRunner& runner_;
  std::atomic<bool>& interrupted_;
  RankContext rank_;
  std::stop_callback<End> on_end_;
};

// A worker with all that it needs.
class OwningCellWorker final : public RankWorker {
 public:
  OwningCellWorker(std::shared_ptr<const StudyPlan> plan, const RankContext& rank)
      : plan_(std::move(plan)),
        runner_(
            *plan_,
            {.threads = 1,
             .interrupted = &interrupted_,
             .hurried = &interrupted_,
             .read_only_cache = true,
             .exchange = [ask = rank.ask](std::size_t body) { return make_reference_exchange(body, ask); }}),
        worker_(runner_, interrupted_, rank, plan_->inputs.size()) {}
  void run(Unpacker piece, const Give& give, const std::stop_token& cancelled) override {
    worker_.run(std::move(piece), give, cancelled);
  }

 private:
  std::shared_ptr<const StudyPlan> plan_;
  std::atomic<bool> interrupted_ = false;
  CellRunner runner_;
  CellWorker worker_;
};

// The worker of rank 0, whose reference services also serve the directory.
class RootCellWorker final : public RankWorker {
 public:
  RootCellWorker(CellRunner& runner, std::atomic<bool>& interrupted, const RankContext& rank,
                 std::size_t bodies, RankListener& asking)
      : asking_(asking), worker_(runner, interrupted, rank, bodies) {
    asking_.set(rank.ask);
  }
  ~RootCellWorker() override { asking_.set(nullptr); }
  void run(Unpacker piece, const Give& give, const std::stop_token& cancelled) override {
    worker_.run(std::move(piece), give, cancelled);
  }

 private:
  RankListener& asking_;
  CellWorker worker_;
};

// Measured costs are kept beside the cache: rank 0 measures them before others look there.
void measure_costs(const StudyPlan& plan, const std::vector<std::size_t>& cells, CellRunner& runner) {
  std::set<std::size_t> measured;
  for (const std::size_t cell : cells) {
    const std::size_t input = plan.cells[cell].input;
    const CostSpec& cost = plan.cells[cell].options.workers.cost;
    if (!std::holds_alternative<RecordedCost>(cost.cost()) || !measured.insert(input).second) continue;
    runner.references(runner.body_of(input))->recorded_costs();
  }
}

}  // namespace

FarmReport run_cells_with_ranks(RankPool& pool, const StudyPlan& plan, const std::vector<std::size_t>& cells,
                                const StudyRunOptions::Take& take, const StudyRankOptions& options) {
  RankListener asking;  // to the rank of this process, while there is one
  std::atomic<bool> interrupted = false;
  CellRunner runner(plan, {.threads = 1,
                           .interrupted = &interrupted,
                           .hurried = options.hurried,
                           .warn = options.warn,
                           .exchange = [&asking](std::size_t body) {
                             return make_reference_exchange(
                                 body, [&asking](Bytes question) { asking.receive(std::move(question)); });
                           }});
  measure_costs(plan, cells, runner);
  const LoadWorker own = [&](const RankContext& rank) {
    return LoadedWorker{
        .worker = std::make_unique<RootCellWorker>(runner, interrupted, rank, plan.inputs.size(), asking),
        .identity = {}};
  };
  CellWork work(cells, take, ReferenceDirectory(plan.inputs.size(), [&](std::size_t body) {
                  return runner.references(body);
                }));
  return run_farm(pool, work, own, options.farm);
}

std::unique_ptr<RankWorker> make_cell_worker(std::shared_ptr<const StudyPlan> plan, const RankContext& rank) {
  return std::make_unique<OwningCellWorker>(std::move(plan), rank);
}

}  // namespace forefeel
