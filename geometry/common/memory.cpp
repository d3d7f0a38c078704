#include "geometry/common/memory.hpp"

#include <fmt/format.h>
#include <sys/resource.h>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <limits>
#include <string>

namespace forefeel {
namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();

// The number in a file that holds one word; infinite if that word is not a number ("max").
double number_in(const std::string& file) {
  std::ifstream in(file);
  double value = 0;
  return in >> value ? value : infinite;
}

double free_of_machine() {
  std::ifstream in("/proc/meminfo");
  for (std::string key, unit; in >> key;) {
    double kilobytes = 0;
    if (!(in >> kilobytes)) return infinite;
    if (key == "MemAvailable:") return 1024 * kilobytes;
    std::getline(in, unit);
  }
  return infinite;
}

double free_of_group() {
  const double most = std::min(number_in("/sys/fs/cgroup/memory.max"),
                               number_in("/sys/fs/cgroup/memory/memory.limit_in_bytes"));
  const double used = std::min(number_in("/sys/fs/cgroup/memory.current"),
                               number_in("/sys/fs/cgroup/memory/memory.usage_in_bytes"));
  return most < infinite && used < infinite ? std::max(0.0, most - used) : infinite;
}

double free_of_process() {
  rlimit limit{};
  if (getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return infinite;
  std::ifstream in("/proc/self/statm");
  double pages = 0;
  in >> pages;
  return std::max(0.0, static_cast<double>(limit.rlim_cur) - 4096 * pages);
}

}  // namespace

double available_memory() {
  return std::min({free_of_machine(), free_of_group(), free_of_process()});
}

std::string bytes_in_words(double bytes) {
  if (bytes >= 1e9) return fmt::format("{:.2g} GB", 1e-9 * bytes);
  return fmt::format("{:.2g} MB", 1e-6 * bytes);
}

}  // namespace forefeel
