#pragma once
// How many threads the limits of the process, the user and the control group allow. OpenMP ends the program where it
// cannot start a thread, so this is tried before.

namespace forefeel {

// Starts up to `wanted` threads that live at the same time and use the heap, ends them, and returns how many there
// were. About 20 us for each.
int threads_that_start(int wanted);

}  // namespace forefeel
