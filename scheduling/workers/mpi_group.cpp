#include "scheduling/workers/mpi_group.hpp"

#ifndef FOREFEEL_MPI

#include <cstdlib>

namespace forefeel {

struct MpiGroup::Impl {};
bool MpiGroup::built() {
  return false;
}
MpiGroup::MpiGroup() = default;
MpiGroup::~MpiGroup() = default;
int MpiGroup::rank() const {
  return 0;
}
int MpiGroup::ranks() const {
  return 1;
}
Transport& MpiGroup::transport() {
  std::abort();
}
void MpiGroup::abandon() {}
void MpiGroup::end_within(double, const std::function<void()>&) {}
void MpiGroup::end_all(int exit_code) {
  std::exit(exit_code);
}

}  // namespace forefeel

#else

#include <atomic>
#include <boost/mpi.hpp>
#include <chrono>
#include <cstdlib>
#include <deque>
#include <thread>

#include "geometry/common/error.hpp"

namespace forefeel {
namespace {

namespace mpi = boost::mpi;

// A send or a receive under way; the bytes stay where they are until it is done.
struct Transfer {
  int rank = 0, tag = 0;
  std::unique_ptr<Bytes> bytes;
  MPI_Request request = MPI_REQUEST_NULL;

  bool done() {
    int flag = 0;
    MPI_Test(&request, &flag, MPI_STATUS_IGNORE);
    return flag != 0;
  }
};

class MpiTransport final : public Transport {
 public:
  explicit MpiTransport(const mpi::communicator& world) : world_(world), comm_(world) {}
  // Messages that are not delivered yet.
  bool sends() {
    std::erase_if(sending_, [](Transfer& transfer) { return transfer.done(); });
    return !sending_.empty();
  }

  int rank() const override { return world_.rank(); }
  int ranks() const override { return world_.size(); }

  void send(int rank, int tag, Bytes bytes) override {
    sends();
    Transfer transfer{.rank = rank, .tag = tag, .bytes = std::make_unique<Bytes>(std::move(bytes))};
    MPI_Isend(transfer.bytes->data(), static_cast<int>(transfer.bytes->size()), MPI_BYTE, rank, tag, comm_,
              &transfer.request);
    sending_.push_back(std::move(transfer));
  }

  // If a sender hangs in the middle of a long message, that message waits here while others are received.
  std::optional<Message> receive() override {
    sends();
    while (match_next()) {
    }
    for (auto transfer = receiving_.begin(); transfer != receiving_.end(); ++transfer) {
      if (waits_for_another(transfer) || !transfer->done()) continue;
      Message message{.rank = transfer->rank, .tag = transfer->tag, .bytes = std::move(*transfer->bytes)};
      receiving_.erase(transfer);
      return message;
    }
    return {};
  }

 private:
  bool match_next() {
    int found = 0;
    MPI_Message handle;
    MPI_Status status;
    MPI_Improbe(MPI_ANY_SOURCE, MPI_ANY_TAG, comm_, &found, &handle, &status);
    if (!found) return false;
    int size = 0;
    MPI_Get_count(&status, MPI_BYTE, &size);
    Transfer transfer{.rank = status.MPI_SOURCE,
                      .tag = status.MPI_TAG,
                      .bytes = std::make_unique<Bytes>(static_cast<std::size_t>(std::max(size, 0)))};
    MPI_Imrecv(transfer.bytes->data(), size, MPI_BYTE, &handle, &transfer.request);
    receiving_.push_back(std::move(transfer));
    return true;
  }
  // An earlier message of the same rank is still on its way.
  bool waits_for_another(std::deque<Transfer>::iterator transfer) {
    return std::any_of(receiving_.begin(), transfer,
                       [&](const Transfer& earlier) { return earlier.rank == transfer->rank; });
  }

  mpi::communicator world_;
  MPI_Comm comm_;
  std::deque<Transfer> sending_, receiving_;
};

}  // namespace

struct MpiGroup::Impl {
  mpi::environment environment{mpi::threading::serialized, false};
  mpi::communicator world;
  MpiTransport transport{world};
};

bool MpiGroup::built() {
  return true;
}

MpiGroup::MpiGroup() : impl_(std::make_unique<Impl>()) {
  if (mpi::environment::thread_level() < mpi::threading::serialized)
    throw InputError(
        "--mpi", "this MPI cannot be called from several threads, expected one built with thread support");
}

MpiGroup::~MpiGroup() {
  while (impl_ && impl_->transport.sends()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
}

void MpiGroup::end_within(double seconds, const std::function<void()>& expired) {
  const auto ended = std::make_shared<std::atomic<bool>>(false);
  std::thread([ended, seconds, expired] {
    const auto until = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
    while (!*ended && std::chrono::steady_clock::now() < until)
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    if (!*ended) expired();
  }).detach();
  while (impl_->transport.sends()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  impl_.reset();
  *ended = true;
}

int MpiGroup::rank() const {
  return impl_->world.rank();
}
int MpiGroup::ranks() const {
  return impl_->world.size();
}
Transport& MpiGroup::transport() {
  return impl_->transport;
}

void MpiGroup::abandon() {
  impl_.release();  // its destructor would wait for them
}

void MpiGroup::end_all(int exit_code) {
  // After MPI_Abort, mpirun (Open MPI 4.1, PMIx 4.2) sometimes deadlocks or crashes at its own end, when all ranks are
  // gone. It ends properly if a process simply exits.
  std::_Exit(exit_code);
}

}  // namespace forefeel

#endif
