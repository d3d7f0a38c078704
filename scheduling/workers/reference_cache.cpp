#include "scheduling/workers/reference_cache.hpp"

#include <fmt/format.h>

#include <cstdint>
#include <exception>
#include <utility>

#include "geometry/common/error.hpp"
#include "scheduling/motion/random.hpp"
#include "solver/kernels/revision.hpp"

namespace forefeel {
namespace {

std::string cache_name(const ReferenceOptions& options) {
  std::uint64_t low = 1, high = 2;
  const auto take = [&](const std::string& text) {
    for (const char c : text)
      low = random::mix(low, static_cast<unsigned char>(c)), high = random::mix(high, low);
    low = random::mix(low, 0x100);
  };
  for (const auto& [name, hash] : options.identity) take(name), take(hash);
  take(fmt::format("{}", options.spacing));
  take(solver_revision());
  return fmt::format("{:016x}{:016x}{}{}", low, high, options.displacements ? "-displacements" : "",
                     options.jet > 1 ? fmt::format("-jet{}", options.jet) : "");
}

}  // namespace

ReferenceCache::ReferenceCache(const ReferenceOptions& options, bool names_only) {
  if (options.cache_folder.empty() || options.identity.empty()) return;
  name_ = cache_name(options);
  if (names_only) return;
  const std::filesystem::path file = options.cache_folder / (name_ + ".states");
  try {
    std::filesystem::create_directories(options.cache_folder);
    StateFileHeader header{
        .identity = options.identity, .spacing = options.spacing, .box = options.box, .notes = {}};
    header.notes["content"] = "tight solves on the reference branch";
    StateFile cache = StateFile::open_or_create(file, header);
    read(cache, file);
    cache.drop_damaged();
    writer_ = std::make_unique<StateWriter>(std::move(cache));
  } catch (const std::exception& problem) {
    states_.clear();
    note_ = fmt::format("no cache of reference solves: {}", problem.what());
    try {  // another run writes the file; its states are used here, too
      const StateFile cache = StateFile::open_read_only(file);
      if (cache.header().identity != options.identity) return;
      read(cache, file);
      note_ = fmt::format("the cache of reference solves is only read: {}", problem.what());
    } catch (const std::exception&) {
      states_.clear();
    }
  }
}

void ReferenceCache::read(const StateFile& file, const std::filesystem::path& path) {
  states_ = file.read_all();
  if (file.damaged() > 0) damage_ = damage_in_words(path.string(), file.damaged(), true);
}

// The cache is optional: a session must not fail with its disk.
void ReferenceCache::keep(const State& state) {
  if (!writer_) return;
  try {
    writer_->push(state);
    unflushed_ = true;
  } catch (const std::exception& problem) {
    fail(problem);
  }
}

std::optional<std::string> ReferenceCache::failure() {
  if (writer_ && unflushed_) try {
      writer_->flush();
      unflushed_ = false;
    } catch (const std::exception& problem) {
      fail(problem);
    }
  return failure_;
}

void ReferenceCache::fail(const std::exception& problem) {
  failure_ = fmt::format("the cache of reference solves is no longer written: {}", problem.what());
  writer_.reset();
}

}  // namespace forefeel
