#include "apps/scene/kept_pieces.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <sstream>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

#include "apps/console/interrupt.hpp"
#include "geometry/common/packer.hpp"
#include "geometry/common/sha256.hpp"

namespace forefeel {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t piece_digest = 16;  // hexadecimal digits at the end of each

// Number, length, numbers, digest.
std::string piece_bytes(std::uint64_t piece, std::span<const double> values) {
  Packer out;
  out.add(piece);
  out.add(std::vector<double>(values.begin(), values.end()));
  const Bytes packed = out.take();
  std::string bytes(packed.begin(), packed.end());
  return bytes + Sha256().add(bytes).hex().substr(0, piece_digest);
}

// The next piece, of which `at` is moved to the end; false where no whole one follows.
bool next_piece(std::string_view all, std::size_t& at, std::uint64_t& piece, std::vector<double>& values) {
  constexpr std::size_t head = 2 * sizeof(std::uint64_t);
  const std::string_view left = all.substr(at);
  if (left.size() < head + piece_digest) return false;
  std::uint64_t count = 0;
  std::copy_n(left.data() + sizeof piece, sizeof count, reinterpret_cast<char*>(&count));
  if (count > (left.size() - head - piece_digest) / sizeof(double)) return false;
  const std::size_t size = head + count * sizeof(double);
  if (Sha256().add(left.substr(0, size)).hex().substr(0, piece_digest) != left.substr(size, piece_digest))
    return false;
  std::copy_n(left.data(), sizeof piece, reinterpret_cast<char*>(&piece));
  values.resize(count);
  std::copy_n(left.data() + head, count * sizeof(double), reinterpret_cast<char*>(values.data()));
  at += size + piece_digest;
  return true;
}

}  // namespace

PieceFile::PieceFile(fs::path file) : file_(std::move(file)) {
  if (file_.empty()) return;
  descriptor_ = open(file_.c_str(), O_CREAT | O_RDWR | O_APPEND | O_CLOEXEC, 0644);
  if (descriptor_ < 0) return;
  if (flock(descriptor_, LOCK_EX | LOCK_NB) != 0) {
    close(std::exchange(descriptor_, -1));
    return;
  }
  pieces_are_kept();
  std::ostringstream bytes;
  bytes << std::ifstream(file_, std::ios::binary).rdbuf();
  std::size_t at = 0;
  std::uint64_t piece = 0;
  for (std::vector<double> values; next_piece(bytes.view(), at, piece, values);)
    pieces_[piece] = std::exchange(values, {});
  if (ftruncate(descriptor_, static_cast<off_t>(at)) != 0) close(std::exchange(descriptor_, -1));
}

PieceFile::~PieceFile() {
  if (descriptor_ >= 0) close(descriptor_);
}

bool PieceFile::take(std::uint64_t piece, std::span<double> values) {
  const auto found = pieces_.find(piece);
  if (found == pieces_.end() || found->second.size() != values.size()) return false;
  std::ranges::copy(found->second, values.begin());
  pieces_.erase(found);
  return true;
}

void PieceFile::keep(std::uint64_t piece, std::span<const double> values) {
  if (descriptor_ < 0) return;
  const std::string bytes = piece_bytes(piece, values);
  if (write(descriptor_, bytes.data(), bytes.size()) != static_cast<ssize_t>(bytes.size()))
    close(std::exchange(descriptor_, -1));  // for example a full disk; a rerun reads to the last whole piece
}

void PieceFile::remove() {
  if (descriptor_ < 0) return;
  std::error_code error;
  fs::remove(file_, error);
}

}  // namespace forefeel
