#pragma once
// How much memory is left, for estimates that are made before anything large is begun.

#include <string>

namespace forefeel {

// Memory that can be taken without swapping [bytes]: what the machine has free or can free (MemAvailable), and
// no more than what the limits of the control group and of the process (ulimit -v) leave. Infinite where the
// system does not tell.
double available_memory();

// "3.1 GB", "12 MB"
std::string bytes_in_words(double bytes);

}  // namespace forefeel
