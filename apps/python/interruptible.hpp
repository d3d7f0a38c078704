#pragma once
// Long calls that show progress and can be stopped by Ctrl-C. Python handles signals on its main thread only, so the
// work runs on another thread while the calling thread watches.

#include <pybind11/functional.h>
#include <pybind11/pybind11.h>

#include <functional>
#include <stop_token>

namespace forefeel::python {

using ShowShare = std::function<void(double)>;  // of the work that is done, 0 to 1

// Runs work(stop, tell) without the interpreter's lock; tell(share) may be called on any thread. Calls
// show(share) up to 20 times a second on the calling thread. A signal or an exception of show() requests the stop; the
// exception is rethrown when the work has ended. Exceptions of the work are rethrown, too.
void run_interruptibly(const ShowShare& show,
                       const std::function<void(std::stop_token, const std::function<void(double)>&)>& work);

}  // namespace forefeel::python
