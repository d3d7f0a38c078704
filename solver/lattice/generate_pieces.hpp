#pragma once
// Splits the sweep of generate_lattice() into pieces that several processes solve. The states are the same, bit by bit.
// One process keeps the plan (LatticePieces). It gives out a coarse node or a cell as soon as the nodes on which that
// depends are solved. Each process solves pieces with its own LatticeWorker. A piece contains the solved coarse nodes
// that it needs and that its process does not have yet.

#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <vector>

#include "geometry/common/packer.hpp"
#include "solver/lattice/generate.hpp"

namespace forefeel {

// The solved coarse nodes that a process holds. Any thread; pointers returned by find() stay valid.
class CoarseNodes;
std::shared_ptr<CoarseNodes> make_coarse_nodes();

// Worker 0 runs in the process of this object and shares its coarse nodes; the other workers have their own.
class LatticePieces {
 public:
  struct Piece {
    std::uint64_t id = 0;
    Bytes content = {};
  };
  // sink and progress as in generate_lattice(); called by the thread that calls done().
  LatticePieces(const LatticeOptions& options, const std::vector<State>& known,
                std::shared_ptr<CoarseNodes> nodes, std::function<void(State)> sink,
                std::function<void(std::size_t, std::size_t)> progress);
  ~LatticePieces();
  LatticePieces(LatticePieces&&) noexcept;

  std::optional<Piece> next(int worker);  // nullopt: none until another is done
  // MalformedMessage, without effect: the result does not belong to the piece.
  void done(std::uint64_t id, int worker, Unpacker result);
  void again(std::uint64_t id);  // the piece was given out but not done: next() offers it again
  void forget(int worker);       // that process is lost, with the nodes that it was sent
  bool finished() const;
  const GenerateReport& report() const;  // without seconds and threads

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// Solves pieces; for one thread. Not for linear bodies: solving their lattice is faster than sending it.
class LatticeWorker {
 public:
  LatticeWorker(std::shared_ptr<const Body> body, const LatticeOptions& options,
                std::shared_ptr<CoarseNodes> nodes);
  ~LatticeWorker();
  // nullopt: options.stop was requested before the end.
  std::optional<Bytes> solve(Unpacker piece);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace forefeel
