#include "scheduling/workers/generate_ranks.hpp"

#include <chrono>
#include <utility>

#include "solver/lattice/generate_pieces.hpp"

namespace forefeel {
namespace {

class LatticeWork final : public FarmWork {
 public:
  explicit LatticeWork(LatticePieces pieces) : pieces_(std::move(pieces)) {}
  std::optional<Piece> next(int worker) override {
    auto piece = pieces_.next(worker);
    if (!piece) return {};
    return Piece{piece->id, std::move(piece->content)};
  }
  void done(std::uint64_t id, int worker, Unpacker result) override {
    pieces_.done(id, worker, std::move(result));
  }
  void again(std::uint64_t id) override { pieces_.again(id); }
  void lost(int worker) override { pieces_.forget(worker); }
  bool finished() const override { return pieces_.finished(); }
  const GenerateReport& report() const { return pieces_.report(); }

 private:
  LatticePieces pieces_;
};

class LatticeRankWorker final : public RankWorker {
 public:
  LatticeRankWorker(std::shared_ptr<const Body> body, const LatticeOptions& options,
                    std::shared_ptr<CoarseNodes> nodes)
      : worker_(std::move(body), options, std::move(nodes)) {}
  void run(Unpacker piece, const Give& give, const std::stop_token&) override {
    if (auto result = worker_.solve(std::move(piece))) give(std::move(*result));
  }

 private:
  LatticeWorker worker_;
};

}  // namespace

RankedGenerateReport generate_with_ranks(RankPool& pool, std::shared_ptr<const Body> body,
                                         const LatticeOptions& options, const std::vector<State>& known,
                                         const std::function<void(State)>& sink,
                                         const std::function<void(std::size_t, std::size_t)>& progress,
                                         const FarmOptions& farm) {
  const auto start = std::chrono::steady_clock::now();
  const std::shared_ptr<CoarseNodes> nodes = make_coarse_nodes();
  LatticeWork work(LatticePieces(options, known, nodes, sink, progress));
  const LoadWorker own = [&](const RankContext& rank) {
    LatticeOptions its = options;
    its.stop = rank.ended;
    return LoadedWorker{.worker = std::make_unique<LatticeRankWorker>(body, its, nodes), .identity = {}};
  };
  RankedGenerateReport report;
  report.farm = run_farm(pool, work, own, farm);
  report.states = work.report();
  report.states.threads = report.farm.ranks;
  report.states.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return report;
}

std::unique_ptr<RankWorker> make_lattice_worker(std::shared_ptr<const Body> body, LatticeOptions options,
                                                const std::stop_token& ended) {
  options.stop = ended;
  return std::make_unique<LatticeRankWorker>(std::move(body), options, make_coarse_nodes());
}

}  // namespace forefeel
