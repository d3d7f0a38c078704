#include "apps/python/interruptible.hpp"

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <thread>

namespace forefeel::python {

namespace py = pybind11;

void run_interruptibly(const ShowShare& show,
                       const std::function<void(std::stop_token, const std::function<void(double)>&)>& work) {
  std::atomic<double> share = 0;
  std::mutex mutex;
  std::condition_variable ended;
  bool done = false;
  std::exception_ptr of_work, of_watch;
  const py::gil_scoped_release released;
  std::jthread worker([&](std::stop_token stop) {
    try {
      work(stop, [&](double now) { share = now; });
    } catch (...) {
      of_work = std::current_exception();
    }
    const std::lock_guard lock(mutex);
    done = true;
    ended.notify_one();
  });
  double shown = -1;
  std::unique_lock lock(mutex);
  while (!ended.wait_for(lock, std::chrono::milliseconds(50), [&] { return done; })) {
    lock.unlock();
    if (!of_watch) try {
        const py::gil_scoped_acquire locked;
        if (PyErr_CheckSignals() != 0) throw py::error_already_set();
        const double now = share;
        if (show && now != shown) show(shown = now);
      } catch (...) {
        of_watch = std::current_exception();
        worker.request_stop();
      }
    lock.lock();
  }
  lock.unlock();
  worker.join();
  if (of_watch) std::rethrow_exception(of_watch);
  if (of_work) std::rethrow_exception(of_work);
  if (show) {
    const py::gil_scoped_acquire locked;
    show(1);
  }
}

}  // namespace forefeel::python
