// forefeel cache [--empty]: where the cache is, what it holds, and how to empty it.

#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "apps/console/commands.hpp"
#include "apps/console/console.hpp"
#include "apps/console/json.hpp"
#include "apps/scene/cache_folder.hpp"
#include "geometry/common/error.hpp"

namespace forefeel {
namespace {

struct CacheArguments {
  bool empty = false;
};

std::string size_in_words(std::uintmax_t bytes) {
  if (bytes < 1'000'000) return fmt::format("{:.1f} kB", 1e-3 * static_cast<double>(bytes));
  return fmt::format("{:.1f} MB", 1e-6 * static_cast<double>(bytes));
}

int run_cache(const Globals& globals, const CacheArguments& arguments) {
  const std::filesystem::path folder = cache_folder();
  if (folder.empty())
    throw InputError("cache", "there is none: neither $XDG_CACHE_HOME nor ~/.cache can be written");
  const CacheContent before = cache_content(folder);
  const CacheContent removed = arguments.empty ? empty_cache(folder) : CacheContent{};
  const CacheContent now = arguments.empty ? cache_content(folder) : before;
  if (globals.json)
    print_json({{"place", folder.string()},
                {"files", now.files},
                {"bytes", now.bytes},
                {"removed", {{"files", removed.files}, {"bytes", removed.bytes}}},
                {"in_use", removed.in_use},
                {"foreign", now.foreign}});
  if (arguments.empty)
    answer(globals, fmt::format("{}: {} files removed, {}", folder.string(), removed.files,
                                size_in_words(removed.bytes)));
  else
    answer(globals, fmt::format("{}: {} files, {}", folder.string(), now.files, size_in_words(now.bytes)));
  if (now.foreign > 0)
    warn(globals,
         fmt::format("{}: {} files there are not of the cache: left alone", folder.string(), now.foreign));
  if (removed.in_use == 0) return 0;
  warn(globals, fmt::format("{}: {} files are in use by another forefeel: left there", folder.string(),
                            removed.in_use));
  return 1;
}

}  // namespace

void add_cache(CommandLine& line) {
  const auto arguments = std::make_shared<CacheArguments>();
  Command sub =
      line.add("cache", "Where results are kept between runs, how large that is, and how to empty it");
  sub.reads_no_scene();
  sub.runs([arguments](const Globals& globals) { return run_cache(globals, *arguments); });
  sub.flag("--empty", arguments->empty,
           "Remove what is kept: meshes of phantoms, tight solves, fields of sites, measured spacings and "
           "costs. All of it is "
           "made again when needed. The place is $XDG_CACHE_HOME/forefeel, or else ~/.cache/forefeel");
}

}  // namespace forefeel
