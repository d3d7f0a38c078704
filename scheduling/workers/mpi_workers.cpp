#include "scheduling/workers/mpi_workers.hpp"

#ifndef FOREFEEL_MPI

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
void MpiGroup::serve(const std::shared_ptr<const Body>&, const StateSolverOptions&) {}
bool MpiGroup::told_to_stop(double) {
  return true;
}
void MpiGroup::abort(int exit_code) {
  std::exit(exit_code);
}
std::unique_ptr<RealWorkers> MpiGroup::workers() {
  return nullptr;
}

}  // namespace forefeel

#else

#include <fmt/format.h>

#include <boost/mpi.hpp>
#include <chrono>
#include <stdexcept>
#include <thread>

#include "geometry/common/error.hpp"
#include "scheduling/workers/worker_threads.hpp"

namespace forefeel {
namespace {

namespace mpi = boost::mpi;

enum Tag : int { tag_job = 1, tag_cancel, tag_stop, tag_result, tag_failure, tag_left };
constexpr auto pause = std::chrono::microseconds(200);

// Every message is a list of doubles; integers are exact in them up to 2^53.
class Packer {
 public:
  void add(double value) { numbers_.push_back(value); }
  void add(const Vec3& x) { numbers_.insert(numbers_.end(), x.data(), x.data() + 3); }
  void add(const std::vector<double>& values) {
    add(static_cast<double>(values.size()));
    numbers_.insert(numbers_.end(), values.begin(), values.end());
  }
  void add(const Equilibrium* e) {
    add(e ? 1.0 : 0.0);
    if (!e) return;
    add(e->at);
    add(e->displacements);
    add(e->tangent);
  }
  const std::vector<double>& numbers() const { return numbers_; }

 private:
  std::vector<double> numbers_;
};

class Unpacker {
 public:
  explicit Unpacker(std::vector<double> numbers) : numbers_(std::move(numbers)) {}
  double number() { return numbers_.at(next_++); }
  template <class T>
  T integer() {
    return static_cast<T>(number());
  }
  Vec3 vector() {
    Vec3 x;
    for (int i = 0; i < 3; ++i) x[i] = number();
    return x;
  }
  std::vector<double> values() {
    const auto count = integer<std::size_t>();
    if (count > numbers_.size() - next_) throw std::runtime_error("a message of another rank is cut short");
    const auto begin = numbers_.begin() + static_cast<std::ptrdiff_t>(next_);
    next_ += count;
    return {begin, begin + static_cast<std::ptrdiff_t>(count)};
  }
  std::shared_ptr<const Equilibrium> equilibrium() {
    if (number() == 0) return nullptr;
    auto e = std::make_shared<Equilibrium>();
    e->at = vector();
    e->displacements = values();
    e->tangent = values();
    return e;
  }

 private:
  std::vector<double> numbers_;
  std::size_t next_ = 0;
};

void send(mpi::communicator& world, int rank, Tag tag, const Packer& message) {
  world.send(rank, tag, message.numbers().data(), static_cast<int>(message.numbers().size()));
}

std::vector<double> receive(mpi::communicator& world, const mpi::status& found) {
  std::vector<double> numbers(static_cast<std::size_t>(found.count<double>().value_or(0)));
  world.recv(found.source(), found.tag(), numbers.data(), static_cast<int>(numbers.size()));
  return numbers;
}

Packer packed(const Job& job) {
  Packer message;
  message.add(job.dispatch);
  message.add(job.at);
  message.add(job.start.get());
  message.add(static_cast<double>(job.beside.size()));
  for (const Job::Neighbour& neighbour : job.beside) {
    message.add(neighbour.dispatch);
    message.add(neighbour.at);
  }
  return message;
}

Job unpacked_job(Unpacker message) {
  Job job;
  job.dispatch = message.integer<std::uint32_t>();
  job.at = message.vector();
  job.start = message.equilibrium();
  for (auto left = message.integer<std::size_t>(); left > 0; --left) {
    const auto dispatch = message.integer<std::uint32_t>();
    job.beside.push_back({.dispatch = dispatch, .at = message.vector()});
  }
  return job;
}

Packer packed(const JobResult& result) {
  const State& s = result.state;
  Packer message;
  message.add(result.dispatch);
  message.add(result.finished - result.started);
  message.add(static_cast<double>(s.status));
  for (const Vec3& v : {s.at, s.force, s.parent}) message.add(v);
  for (int i = 0; i < 3; ++i) message.add(Vec3(s.stiffness.row(i)));
  for (const double v : {s.energy, s.residual, s.seconds, s.min_jacobian, static_cast<double>(s.iterations),
                         static_cast<double>(s.multivalued), s.displacements ? 1.0 : 0.0})
    message.add(v);
  if (s.displacements) message.add(*s.displacements);
  message.add(result.equilibrium.get());
  message.add(result.partial.get());
  return message;
}

JobResult unpacked_result(Unpacker message, double now) {
  JobResult result;
  State& s = result.state;
  result.dispatch = message.integer<std::uint32_t>();
  result.finished = now;
  result.started = now - message.number();
  s.status = static_cast<SolveStatus>(message.integer<int>());
  s.at = message.vector();
  s.force = message.vector();
  s.parent = message.vector();
  for (int i = 0; i < 3; ++i) s.stiffness.row(i) = message.vector();
  s.energy = message.number();
  s.residual = message.number();
  s.seconds = message.number();
  s.min_jacobian = message.number();
  s.iterations = message.integer<int>();
  s.multivalued = message.number() != 0;
  if (message.number() != 0) s.displacements = std::make_shared<const std::vector<double>>(message.values());
  result.equilibrium = message.equilibrium();
  result.partial = message.equilibrium();
  return result;
}

}  // namespace

struct MpiGroup::Impl {
  mpi::environment environment{mpi::threading::serialized, false};
  mpi::communicator world;
  bool stopped = false;

  // Rank 0: returns when no rank sends any more. Results that came until then go to `results`.
  void stop(std::vector<JobResult>* results, double now) {
    if (stopped) return;
    stopped = true;
    for (int rank = 1; rank < world.size(); ++rank) send(world, rank, tag_stop, Packer());
    for (int left = world.size() - 1; left > 0;) {
      const mpi::status found = world.probe();
      std::vector<double> numbers = receive(world, found);
      if (found.tag() == tag_left) --left;
      if (found.tag() != tag_result || !results) continue;
      results->push_back(unpacked_result(Unpacker(std::move(numbers)), now));
      results->back().worker = found.source() - 1;
    }
  }
};

namespace {

// The other ranks, seen from rank 0: worker w is rank w + 1.
class MpiWorkers final : public RealWorkers {
 public:
  MpiWorkers(mpi::communicator& world, std::function<void(std::vector<JobResult>*, double)> stop_all)
      : world_(world), stop_all_(std::move(stop_all)) {}

  void begin(std::function<double()> now) override { now_ = std::move(now); }
  int workers() const override { return world_.size() - 1; }
  void dispatch(int worker, Job job) override { send(world_, worker + 1, tag_job, packed(job)); }
  void cancel(int worker) override { send(world_, worker + 1, tag_cancel, Packer()); }

  void collect(std::vector<JobResult>& out, double timeout) override {
    out.clear();
    out.swap(late_);
    if (ended_) return;
    const auto until = std::chrono::steady_clock::now() + std::chrono::duration<double>(timeout);
    do {
      while (const auto found = world_.iprobe()) take(*found, out);
      if (!out.empty() || failure_) return;
      std::this_thread::sleep_for(pause);
    } while (std::chrono::steady_clock::now() < until);
  }

  void stop() override {
    ended_ = true;
    stop_all_(&late_, now_());
  }
  std::exception_ptr failure() const override { return failure_; }

 private:
  void take(const mpi::status& found, std::vector<JobResult>& out) {
    const int source = found.source();
    if (found.tag() == tag_failure) {
      std::string text(static_cast<std::size_t>(found.count<char>().value_or(0)), ' ');
      world_.recv(source, tag_failure, text.data(), static_cast<int>(text.size()));
      failure_ = std::make_exception_ptr(std::runtime_error(fmt::format("rank {}: {}", source, text)));
      return;
    }
    out.push_back(unpacked_result(Unpacker(receive(world_, found)), now_()));
    out.back().worker = source - 1;
  }

  mpi::communicator& world_;
  std::function<void(std::vector<JobResult>*, double)> stop_all_;
  std::function<double()> now_;
  std::vector<JobResult> late_;
  bool ended_ = false;
  std::exception_ptr failure_;
};

void send_failure(mpi::communicator& world, const std::exception_ptr& failure) {
  std::string text = "failed";
  try {
    std::rethrow_exception(failure);
  } catch (const std::exception& error) {
    text = error.what();
  } catch (...) {
  }
  world.send(0, tag_failure, text.data(), static_cast<int>(text.size()));
}

}  // namespace

bool MpiGroup::built() {
  return true;
}

MpiGroup::MpiGroup() : impl_(std::make_unique<Impl>()) {
  if (mpi::environment::thread_level() < mpi::threading::serialized)
    throw InputError(
        "--mpi", "this MPI cannot be called from several threads, expected one built with thread support");
}

MpiGroup::~MpiGroup() {
  if (rank() == 0) impl_->stop(nullptr, 0);
}

int MpiGroup::rank() const {
  return impl_->world.rank();
}
int MpiGroup::ranks() const {
  return impl_->world.size();
}

void MpiGroup::serve(const std::shared_ptr<const Body>& body, const StateSolverOptions& options) {
  mpi::communicator& world = impl_->world;
  const auto start = std::chrono::steady_clock::now();
  WorkerThreads worker(body, options, [start] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  });
  std::thread solver([&] { worker.serve(); });
  while (worker.workers() == 0 && !worker.failure()) std::this_thread::sleep_for(pause);
  std::vector<JobResult> results;
  bool failed = false;
  for (bool going = true; going;) {
    while (const auto found = world.iprobe(0, mpi::any_tag)) {
      std::vector<double> numbers = receive(world, *found);
      if (found->tag() == tag_stop) going = false;
      if (found->tag() == tag_job && !failed) worker.dispatch(0, unpacked_job(Unpacker(std::move(numbers))));
      if (found->tag() == tag_cancel) worker.cancel(0);
    }
    worker.collect(results, std::chrono::duration<double>(pause).count());
    for (const JobResult& result : results) send(world, 0, tag_result, packed(result));
    if (worker.failure() && !failed) {
      failed = true;
      send_failure(world, worker.failure());
    }
    if (failed) std::this_thread::sleep_for(pause);
  }
  worker.stop();
  solver.join();
  worker.collect(results, 0);
  for (const JobResult& result : results) send(world, 0, tag_result, packed(result));
  send(world, 0, tag_left, Packer());
}

bool MpiGroup::told_to_stop(double seconds) {
  const auto until = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
  while (std::chrono::steady_clock::now() < until) {
    if (const auto found = impl_->world.iprobe(0, tag_stop)) {
      receive(impl_->world, *found);
      send(impl_->world, 0, tag_left, Packer());
      return true;
    }
    std::this_thread::sleep_for(pause);
  }
  return false;
}

void MpiGroup::abort(int exit_code) {
  impl_->environment.abort(exit_code);
  std::abort();
}

std::unique_ptr<RealWorkers> MpiGroup::workers() {
  return std::make_unique<MpiWorkers>(
      impl_->world, [this](std::vector<JobResult>* results, double at) { impl_->stop(results, at); });
}

}  // namespace forefeel

#endif
