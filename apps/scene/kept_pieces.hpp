#pragma once
// Pieces of a long computation in a file of the cache folder. Each is written as soon as it is made, so that a run that
// was killed loses at most the pieces it was at.

#include <filesystem>
#include <map>
#include <memory>

#include "solver/jet/rest_sites.hpp"

namespace forefeel {

class PieceFile final : public KeptPieces {
 public:
  // Reads the file, to the last piece that is whole. Keeps nothing where the path is empty, the file cannot be written,
  // or another process writes it.
  explicit PieceFile(std::filesystem::path file);
  ~PieceFile() override;
  PieceFile(const PieceFile&) = delete;
  PieceFile& operator=(const PieceFile&) = delete;

  bool take(std::uint64_t piece, std::span<double> values) override;  // a second time: it is gone
  void keep(std::uint64_t piece, std::span<const double> values) override;
  std::size_t size() const { return pieces_.size(); }
  void remove();  // once the whole result is kept elsewhere

 private:
  std::filesystem::path file_;
  int descriptor_ = -1;  // open for appending, locked
  std::map<std::uint64_t, std::vector<double>> pieces_;
};

}  // namespace forefeel
