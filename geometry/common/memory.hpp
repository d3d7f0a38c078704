#pragma once
// Available memory, to check a large allocation before it is made.

#include <string>

namespace forefeel {

// Memory that can be allocated without swapping [bytes]: MemAvailable of the system, at most what the limits of
// the control group and of the process (ulimit -v) leave. Infinite if the system does not report it.
double available_memory();

// "3.1 GB", "12 MB"
std::string bytes_in_words(double bytes);

}  // namespace forefeel
