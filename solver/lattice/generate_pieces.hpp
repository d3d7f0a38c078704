#pragma once
// The sweep of generate_lattice() in pieces that several processes solve: the same states, bit by bit. One process
// keeps the plan (LatticePieces) and hands out coarse nodes and cells as soon as what they depend on is solved; each
// process solves pieces with a LatticeHand of its own. A piece carries the solved coarse nodes that it looks at and
// that its process was not sent before.

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

// The solved coarse nodes that a process holds. Any thread; what find() gives stays valid.
class CoarseNodes;
std::shared_ptr<CoarseNodes> make_coarse_nodes();

// Worker 0 shares the process, and the coarse nodes, of this object; the others have their own.
class LatticePieces {
 public:
  struct Piece {
    std::uint64_t id = 0;
    Bytes content = {};
  };
  // sink and progress as in generate_lattice(); called by the thread that calls done().
  LatticePieces(const GenerateOptions& options, const std::vector<State>& known,
                std::shared_ptr<CoarseNodes> nodes, std::function<void(State)> sink,
                std::function<void(std::size_t, std::size_t)> progress);
  ~LatticePieces();
  LatticePieces(LatticePieces&&) noexcept;

  std::optional<Piece> next(int worker);  // nullopt: none until another is done
  // MalformedMessage, without effect: the result does not belong to the piece.
  void done(std::uint64_t id, int worker, Unpacker result);
  void again(std::uint64_t id);  // it was given out and is not done
  void forget(int worker);       // that process is lost, with the nodes that it was sent
  bool finished() const;
  const GenerateReport& report() const;  // without seconds and threads

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// Solves pieces; one thread. Not for linear bodies, whose lattice is solved faster than it is sent.
class LatticeHand {
 public:
  LatticeHand(std::shared_ptr<const Body> body, const GenerateOptions& options,
              std::shared_ptr<CoarseNodes> nodes);
  ~LatticeHand();
  // nullopt: options.stop came in between.
  std::optional<Bytes> solve(Unpacker piece);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace forefeel
