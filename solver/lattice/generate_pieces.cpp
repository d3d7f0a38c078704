#include "solver/lattice/generate_pieces.hpp"

#include <algorithm>
#include <map>
#include <queue>
#include <set>

#include "geometry/states/energy_jet.hpp"
#include "geometry/states/state_message.hpp"
#include "geometry/states/state_outcome.hpp"
#include "solver/lattice/node_states.hpp"
#include "solver/lattice/sweep_plan.hpp"

namespace forefeel {

class CoarseNodes {
 public:
  void keep(SweepNode node) {
    const std::lock_guard lock(mutex_);
    const LatticeIndex index = node.index;
    nodes_.try_emplace(index, std::move(node));
  }
  const SweepNode* find(const LatticeIndex& c) const {
    const std::lock_guard lock(mutex_);
    const auto at = nodes_.find(c);
    return at != nodes_.end() ? &at->second : nullptr;
  }

 private:
  mutable std::mutex mutex_;
  std::map<LatticeIndex, SweepNode> nodes_;  // solved ones
};

std::shared_ptr<CoarseNodes> make_coarse_nodes() {
  return std::make_shared<CoarseNodes>();
}

namespace {

enum class PieceKind : std::uint8_t { coarse, cell };  // cell: a group of fine states

void pack(Packer& message, const LatticeIndex& k) {
  for (const int i : k) message.add(std::int32_t{i});
}

LatticeIndex unpack_index(Unpacker& message) {
  LatticeIndex k{};
  for (int& i : k) i = message.number<std::int32_t>();
  return k;
}

void pack_node(Packer& message, const SweepNode& node) {
  pack(message, node.index);
  forefeel::pack(message, node.state);
  message.add(node.field.u);
  message.add(node.field.tangent);
}

SweepNode unpack_node(Unpacker& message) {
  SweepNode node;
  node.index = unpack_index(message);
  node.state = unpack_state(message);
  node.field.u = message.values();
  node.field.tangent = message.values();
  return node;
}

}  // namespace

struct LatticePieces::Impl {
  // By number: coarse nodes first, because other pieces depend on them.
  using Ready = std::priority_queue<std::size_t, std::vector<std::size_t>, std::greater<>>;

  Impl(const LatticeOptions& options, const std::vector<State>& known, std::shared_ptr<CoarseNodes> its_nodes,
       std::function<void(State)> its_sink, std::function<void(std::size_t, std::size_t)> its_progress)
      : plan(options, known),
        pieces(pieces_of(plan)),
        is_done(pieces.size(), false),
        spacing(options.spacing),
        nodes(std::move(its_nodes)),
        sink(std::move(its_sink)),
        progress(std::move(its_progress)) {
    report.resumed = plan.resumed();
    left = pieces.size();
    for (std::size_t id = 0; id < pieces.size(); ++id)
      if (pieces[id].waits_for == 0) ready.push(id);
  }

  Bytes content(const SweepPiece& piece, int worker) {
    Packer message;
    message.add(piece.is_coarse ? PieceKind::coarse : PieceKind::cell);
    message.add(std::uint32_t(piece.states.size()));
    for (const LatticeIndex& k : piece.states) pack(message, k);
    std::vector<const SweepNode*> needed;
    if (worker > 0) {
      std::set<LatticeIndex>& there = sent[worker];
      for (const LatticeIndex& c : nodes_looked_at(plan.planes(), piece.states))
        if (const SweepNode* node = nodes->find(c); node && there.insert(c).second) needed.push_back(node);
    }
    message.add(std::uint32_t(needed.size()));
    for (const SweepNode* node : needed) pack_node(message, *node);
    return message.take();
  }

  // The nodes of a result, if they are those of the piece.
  std::vector<SweepNode> read(const SweepPiece& piece, Unpacker result) const {
    std::vector<SweepNode> found;
    if (result.number<std::uint32_t>() != piece.states.size())
      throw MalformedMessage("another number of states");
    for (const LatticeIndex& k : piece.states) {
      found.push_back(unpack_node(result));
      const SweepNode& node = found.back();
      if (node.index != k || node.state.at != position_of(k, spacing))
        throw MalformedMessage("another position");
      if (piece.is_coarse && node.solved() && node.field.u.empty())
        throw MalformedMessage("a solution without displacements");
    }
    result.expect_end();
    return found;
  }

  void emit(State state) {
    (state.usable() ? report.solved : report.failed) += 1;
    report.inverted += has_inverted_elements(state);
    sink(std::move(state));
    if (progress) progress(report.resumed + report.solved + report.failed, plan.positions());
  }

  const SweepPlan plan;
  std::vector<SweepPiece> pieces;
  std::vector<bool> is_done;  // by piece
  double spacing;
  std::shared_ptr<CoarseNodes> nodes;
  std::function<void(State)> sink;
  std::function<void(std::size_t, std::size_t)> progress;
  Ready ready;
  std::size_t left = 0;
  std::map<int, std::set<LatticeIndex>> sent;  // to each worker
  GenerateReport report;
};

LatticePieces::LatticePieces(const LatticeOptions& options, const std::vector<State>& known,
                             std::shared_ptr<CoarseNodes> nodes, std::function<void(State)> sink,
                             std::function<void(std::size_t, std::size_t)> progress)
    : impl_(std::make_unique<Impl>(options, known, std::move(nodes), std::move(sink), std::move(progress))) {}

LatticePieces::~LatticePieces() = default;
LatticePieces::LatticePieces(LatticePieces&&) noexcept = default;

std::optional<LatticePieces::Piece> LatticePieces::next(int worker) {
  while (!impl_->ready.empty()) {
    const std::size_t id = impl_->ready.top();
    impl_->ready.pop();
    if (impl_->is_done[id]) continue;  // was offered again, but its first worker has finished it since
    return Piece{id, impl_->content(impl_->pieces[id], worker)};
  }
  return {};
}

void LatticePieces::done(std::uint64_t id, int worker, Unpacker result) {
  const SweepPiece& piece = impl_->pieces.at(id);
  if (impl_->is_done[id]) return;
  std::vector<SweepNode> found = impl_->read(piece, std::move(result));
  impl_->is_done[id] = true;
  --impl_->left;
  for (SweepNode& node : found) {
    if (impl_->plan.is_wanted(node.index)) impl_->emit(node.state);
    node.state.displacements = nullptr;  // neighbours are predicted from the field
    node.state.jet = nullptr;
  }
  if (piece.is_coarse && found.front().solved()) {
    impl_->sent[worker].insert(found.front().index);
    impl_->nodes->keep(std::move(found.front()));
  }
  for (const std::size_t other : piece.before)
    if (--impl_->pieces[other].waits_for == 0) impl_->ready.push(other);
}

void LatticePieces::again(std::uint64_t id) {
  impl_->ready.push(id);
}

void LatticePieces::forget(int worker) {
  impl_->sent.erase(worker);
}

bool LatticePieces::finished() const {
  return impl_->left == 0;
}

const GenerateReport& LatticePieces::report() const {
  return impl_->report;
}

struct LatticeWorker::Impl {
  Impl(std::shared_ptr<const Body> its_body, const LatticeOptions& its_options,
       std::shared_ptr<CoarseNodes> its_nodes)
      : body(std::move(its_body)),
        d(analyse(*body, Precision::single)),
        options(its_options),
        nodes(std::move(its_nodes)),
        worker(d, fitting(d, sweep_options(*body, options, options.stop, solved))),
        states(d, *body, options) {}

  static SweepOptions fitting(const std::shared_ptr<const Discretisation>& d, SweepOptions options) {
    options.precision = fitting_precision(d);
    return options;
  }

  std::shared_ptr<const Body> body;
  std::shared_ptr<const Discretisation> d;
  LatticeOptions options;
  std::shared_ptr<CoarseNodes> nodes;
  std::vector<LatticeIndex> looked_at;  // by the piece under way; sorted
  // Only nodes of nodes_looked_at() may be used. Others may not have been sent here, and the values would then depend
  // on which process solves.
  const SolvedNodes solved = [this](const LatticeIndex& c) {
    if (!std::ranges::binary_search(looked_at, c))
      throw std::logic_error("a piece of the lattice looks at a node that it was not sent");
    return nodes->find(c);
  };
  SweepWorker worker;
  NodeStates states;
};

LatticeWorker::LatticeWorker(std::shared_ptr<const Body> body, const LatticeOptions& options,
                             std::shared_ptr<CoarseNodes> nodes)
    : impl_(std::make_unique<Impl>(std::move(body), options, std::move(nodes))) {}

LatticeWorker::~LatticeWorker() = default;

std::optional<Bytes> LatticeWorker::solve(Unpacker piece) {
  const auto kind = static_cast<PieceKind>(piece.number<std::uint8_t>());
  std::vector<LatticeIndex> fine;
  for (auto count = piece.number<std::uint32_t>(); count > 0; --count) fine.push_back(unpack_index(piece));
  for (auto count = piece.number<std::uint32_t>(); count > 0; --count) impl_->nodes->keep(unpack_node(piece));
  piece.expect_end();
  impl_->looked_at = nodes_looked_at(impl_->worker.options().planes, fine);
  std::vector<SweepNode> found;
  if (kind == PieceKind::coarse)
    found.push_back(solve_coarse_node(impl_->worker, fine.at(0)));
  else
    found = solve_fine_nodes(impl_->worker, fine);
  Packer result;
  result.add(std::uint32_t(found.size()));
  for (SweepNode& node : found) {
    if (node.state.solve.status == SolveStatus::cancelled || impl_->options.stop.stop_requested()) return {};
    node.state = impl_->states.of(node);
    if (kind == PieceKind::cell) node.field = {};  // only coarse nodes are looked at by others
    pack_node(result, node);
    if (kind == PieceKind::cell || !node.solved()) continue;
    node.state.displacements = nullptr;
    node.state.jet = nullptr;
    impl_->nodes->keep(std::move(node));  // it is not sent here again
  }
  return result.take();
}

}  // namespace forefeel
