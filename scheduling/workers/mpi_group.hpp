#pragma once
// This process as a rank of an MPI run: `mpirun -n 5 forefeel … --mpi`. The messages between the ranks are in
// transport.hpp. Without Boost.MPI, built() returns false and no other function may be called.

#include <functional>
#include <memory>

#include "scheduling/workers/transport.hpp"

namespace forefeel {

// At most one object in a process, used by one thread at a time.
class MpiGroup {
 public:
  static bool built();
  MpiGroup();   // InputError if MPI works only from the first thread
  ~MpiGroup();  // waits for all ranks, as MPI requires
  MpiGroup(const MpiGroup&) = delete;
  MpiGroup& operator=(const MpiGroup&) = delete;

  int rank() const;
  int ranks() const;
  Transport& transport();
  // After this call the destructor does not wait for ranks that hang. If this process then ends with an
  // error, mpirun ends the others.
  void abandon();
  // Ends MPI as the destructor does. If that takes longer than `seconds`, because a rank hangs, `expired` is
  // called from another thread; it must end the process.
  void end_within(double seconds, const std::function<void()>& expired);
  // Ends this process with that code at once. mpirun then ends the others, also those that hang, and itself
  // with an error.
  [[noreturn]] void end_all(int exit_code);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace forefeel
