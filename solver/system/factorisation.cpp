#include "solver/system/factorisation.hpp"

#include <algorithm>
#include <cmath>
#include <type_traits>
#include <variant>

namespace forefeel {
namespace {

// A supernode before layout: nodes first .. first + pivots - 1, which share the later nodes in `rest`.
struct Supernode {
  std::uint32_t first = 0, pivots = 0;
  std::vector<std::uint32_t> rest;  // sorted; the contact, numbered n, is last where present
};

double elimination_flops(double pivots, double rest) {
  const double k = 3 * pivots, m = 3 * (pivots + rest);
  return k * m * m - k * k * m + k * k * k / 3;
}

// Cost of a front besides its flops: bookkeeping, and adding its update matrix to the parent.
double front_cost(const Supernode& s) {
  const double rest = static_cast<double>(s.rest.size());
  return 10000 + 150 * rest * rest + elimination_flops(s.pivots, rest);
}

std::vector<Supernode> supernodes(const BlockPattern& pattern, std::int64_t free_nodes) {
  const auto n = static_cast<std::size_t>(free_nodes);
  std::vector<std::vector<std::uint32_t>> column(n), children(n);
  std::vector<std::size_t> mark(n + 1, n + 1);
  std::vector<Supernode> result;
  for (std::uint32_t j = 0; j < n; ++j) {
    const auto take = [&](std::uint32_t i) {
      if (i <= j || mark[i] == j) return;
      mark[i] = j;
      column[j].push_back(i);
    };
    for (const std::uint32_t i : pattern.row(j)) take(i);
    for (const std::uint32_t child : children[j])
      for (const std::uint32_t i : column[child]) take(i);
    std::sort(column[j].begin(), column[j].end());
    if (!column[j].empty() && column[j][0] < n) children[column[j][0]].push_back(j);
    Supernode fresh{j, 1, column[j]};
    // Joins a supernode with the one before it while that is a child and the joint front is cheaper.
    while (!result.empty()) {
      const Supernode& last = result.back();
      const bool child =
          !last.rest.empty() && last.rest[0] >= fresh.first && last.rest[0] < fresh.first + fresh.pivots;
      if (!child) break;
      Supernode joint{last.first, last.pivots + fresh.pivots, fresh.rest};
      const bool same = last.rest.size() == fresh.rest.size() + fresh.pivots;
      if (!same && front_cost(joint) > front_cost(last) + front_cost(fresh)) break;
      result.pop_back();
      fresh = std::move(joint);
    }
    result.push_back(std::move(fresh));
    for (const std::uint32_t child : children[j]) std::vector<std::uint32_t>().swap(column[child]);
  }
  return result;
}

std::int64_t padded(std::int64_t count, std::int64_t multiple) {
  return (count + multiple - 1) / multiple * multiple;
}

}  // namespace

// The layout of all fronts: fixed by the pattern, shared by all factors of one body.
struct FactorLayout {
  std::vector<Front> fronts;
  std::vector<std::int32_t> rows, children, place;
  std::vector<ExtendRun> runs;
  std::vector<std::int64_t> row_start;
  std::int64_t free_nodes = 0, panel_size = 0, stack_size = 0, most_rest = 0;
  double flops = 0;

  std::int64_t padding;  // of rows

  FactorLayout(const BlockPattern& pattern, std::int64_t n, std::int64_t pad)
      : row_start(pattern.row_start), free_nodes(n), padding(pad) {
    place_fronts(supernodes(pattern, n));
    place_blocks(pattern);
    place_stack();
  }

  std::size_t panels() const { return static_cast<std::size_t>(panel_size + 2 * padding); }
  std::size_t stacks() const { return static_cast<std::size_t>(stack_size + 2 * padding); }

  FrontTree tree() const {
    return {.count = static_cast<std::int64_t>(fronts.size()),
            .free_nodes = free_nodes,
            .fronts = fronts.data(),
            .rows = rows.data(),
            .children = children.data(),
            .runs = runs.data(),
            .row_start = row_start.data(),
            .place = place.data()};
  }

 private:
  const Front* parent_of(const Front& f) const { return f.parent < 0 ? nullptr : fronts.data() + f.parent; }
  const Front& first_child_of(const Front& f) const {
    return *(fronts.data() + *(children.data() + f.children.first));
  }

  // Position of a node within a front: pivots first, then the rest.
  std::int32_t position(const Front& f, std::int32_t node) const {
    if (node < f.first + f.pivots) return node - f.first;
    const auto begin = rows.begin() + f.rows, end = begin + f.rest;
    return f.pivots + static_cast<std::int32_t>(std::lower_bound(begin, end, node) - begin);
  }

  void place_fronts(const std::vector<Supernode>& supernode) {
    std::vector<std::int32_t> owner;  // of the nodes in elimination order
    for (std::size_t s = 0; s < supernode.size(); ++s)
      owner.insert(owner.end(), supernode[s].pivots, static_cast<std::int32_t>(s));
    for (const Supernode& s : supernode) {
      Front f;
      f.first = static_cast<std::int32_t>(s.first);
      f.pivots = static_cast<std::int32_t>(s.pivots);
      f.rest = static_cast<std::int32_t>(s.rest.size());
      f.rows = static_cast<std::int64_t>(rows.size());
      rows.insert(rows.end(), s.rest.begin(), s.rest.end());
      if (!s.rest.empty() && s.rest[0] < owner.size()) f.parent = owner[s.rest[0]];
      f.ld = padded(3 * (f.pivots + f.rest), padding);
      f.panel = panel_size;
      panel_size += 3 * f.pivots * f.ld;
      f.update_ld = padded(3 * f.rest, padding);
      most_rest = std::max<std::int64_t>(most_rest, f.rest);
      flops += elimination_flops(f.pivots, f.rest);
      fronts.push_back(f);
    }
    std::vector<std::vector<std::int32_t>> of(fronts.size());
    for (std::size_t s = 0; s < fronts.size(); ++s)
      if (fronts[s].parent >= 0) (of.begin() + fronts[s].parent)->push_back(static_cast<std::int32_t>(s));
    for (std::size_t s = 0; s < fronts.size(); ++s) {
      fronts[s].children = {static_cast<std::int64_t>(children.size()),
                            static_cast<std::int64_t>(of[s].size())};
      children.insert(children.end(), of[s].begin(), of[s].end());
    }
    for (Front& f : fronts) {
      f.runs.first = static_cast<std::int64_t>(runs.size());
      const Front* const parent = parent_of(f);
      if (!parent) continue;
      const std::int32_t* const rest = rows.data() + f.rows;
      for (std::int32_t i = 0; i < f.rest; ++i) {
        const std::int32_t to = position(*parent, rest[i]);
        const bool goes_on = f.runs.count > 0 && runs.back().to + runs.back().length == to;
        if (goes_on)
          ++runs.back().length;
        else
          runs.push_back({i, to, 1}), ++f.runs.count;
      }
    }
  }

  void place_blocks(const BlockPattern& pattern) {
    place.reserve(pattern.column.size());
    std::uint32_t i = 0;
    for (const Front& f : fronts)
      for (std::int32_t pivot = 0; pivot < f.pivots; ++pivot, ++i)
        for (const std::uint32_t j : pattern.row(i))
          place.push_back(position(f, static_cast<std::int32_t>(j)));
    place.resize(pattern.column.size());  // and the diagonal of the contact, which no front holds
  }

  // Two stacks, for fronts of even and odd depth: a front's update matrix is made on one stack while those of
  // its children are on top of the other, so that nothing has to be moved.
  void place_stack() {
    std::vector<char> odd(fronts.size(), 0);
    for (std::size_t s = fronts.size(); s-- > 0;)
      if (fronts[s].parent >= 0) odd[s] = *(odd.begin() + fronts[s].parent) == 0;
    std::int64_t top[2] = {0, 0}, size[2] = {0, 0};
    for (std::size_t s = 0; s < fronts.size(); ++s) {
      Front& f = fronts[s];
      const std::size_t mine = odd[s] != 0 ? 1 : 0;
      f.update = top[mine];
      size[mine] = std::max(size[mine], f.update + 3 * f.rest * f.update_ld);
      if (f.children.count > 0) top[1 - mine] = first_child_of(f).update;
      if (f.parent >= 0) top[mine] = f.update + 3 * f.rest * f.update_ld;
    }
    for (std::size_t s = 0; s < fronts.size(); ++s)
      if (odd[s] != 0) fronts[s].update += size[0];
    stack_size = size[0] + size[1];
  }
};

namespace {

std::shared_ptr<const FactorLayout> make_layout(const Discretisation& d, Precision precision) {
  const int padding = precision == Precision::exact ? row_padding<double> : row_padding<float>;
  return std::make_shared<const FactorLayout>(d.pattern, d.free_nodes, padding);
}

const FactorKernels<double>& kernels_of(const double*) {
  return front_kernels().exact;
}
const FactorKernels<float>& kernels_of(const float*) {
  return front_kernels().single;
}

// The numbers of a factor, and the vectors that are solved with it.
template <class Real>
struct Numbers {
  const FactorLayout& layout;
  const FactorKernels<Real>& kernels = kernels_of(static_cast<const Real*>(nullptr));
  std::vector<Real> panels, stack;
  mutable std::vector<Real> work, vectors;

  explicit Numbers(const FactorLayout& its_layout)
      : layout(its_layout),
        panels(layout.panels()),
        stack(layout.stacks()),
        work(static_cast<std::size_t>((3 * layout.most_rest + layout.padding) * lane_count)) {}

  // b: local vectors, `count` of them side by side
  void solve(double* b, int count) const {
    const FrontTree tree = layout.tree();
    const auto rows = static_cast<std::size_t>(3 * layout.free_nodes * count),
               contact = 3 * static_cast<std::size_t>(count);
    Real* v = taken(b, rows + contact);
    std::fill_n(v + rows, contact, Real(0));
    (count == 1 ? kernels.forward : kernels.forward_lanes)(tree, panels.data(), v, work.data());
    std::fill_n(v + rows, contact, Real(0));
    (count == 1 ? kernels.backward : kernels.backward_lanes)(tree, panels.data(), v, work.data());
    give(v, b, rows + contact);
  }
  void half_solve_lanes(double* b) const {
    const auto rows = static_cast<std::size_t>(3 * layout.free_nodes * lane_count),
               contact = std::size_t{3 * lane_count};
    Real* v = taken(b, rows + contact);
    std::fill_n(v + rows, contact, Real(0));
    kernels.forward_lanes(layout.tree(), panels.data(), v, work.data());
    std::fill_n(v + rows, contact, Real(0));
    give(v, b, rows + contact);
  }
  void tangent(double* v) const {
    const auto n = static_cast<std::size_t>(3 * layout.free_nodes);
    vectors.assign((n + 6) * lane_count, Real(0));
    for (std::size_t c = 0; c < 3; ++c) vectors[(n + c) * lane_count + c] = 1;
    kernels.backward_lanes(layout.tree(), panels.data(), vectors.data(), work.data());
    for (std::size_t c = 0; c < 3; ++c)
      for (std::size_t i = 0; i < n + 6; ++i)
        v[c * (n + 6) + i] = static_cast<double>(vectors[i * lane_count + c]);
  }

 private:
  Real* taken(double* b, std::size_t size) const {
    if constexpr (std::is_same_v<Real, double>) {
      return b;
    } else {
      vectors.resize(std::max(vectors.size(), size));
      for (std::size_t i = 0; i < size; ++i) vectors[i] = static_cast<Real>(b[i]);
      return vectors.data();
    }
  }
  void give(const Real* v, double* b, std::size_t size) const {
    if constexpr (!std::is_same_v<Real, double>)
      for (std::size_t i = 0; i < size; ++i) b[i] = static_cast<double>(v[i]);
  }
};

}  // namespace

struct Factorisation::Impl {
  std::shared_ptr<const FactorLayout> layout;
  std::variant<Numbers<double>, Numbers<float>> numbers;
  double corner[9] = {};

  Impl(const Discretisation& d, Precision precision)
      : layout(d.layout && precision == Precision::exact ? d.layout : make_layout(d, precision)),
        numbers(make_numbers(*layout, precision)) {}

  static std::variant<Numbers<double>, Numbers<float>> make_numbers(const FactorLayout& layout,
                                                                    Precision precision) {
    if (precision == Precision::exact) return Numbers<double>(layout);
    return Numbers<float>(layout);
  }
};

Factorisation::Factorisation(const Discretisation& discretisation, Precision precision)
    : impl_(std::make_unique<Impl>(discretisation, precision)) {}
Factorisation::~Factorisation() = default;
Factorisation::Factorisation(Factorisation&&) noexcept = default;

Precision Factorisation::precision() const {
  return impl_->numbers.index() == 0 ? Precision::exact : Precision::single;
}

bool Factorisation::compute(const double* blocks) {
  Impl& f = *impl_;
  return std::visit(
      [&](auto& n) {
        return n.kernels.factor(f.layout->tree(), blocks, n.panels.data(), n.stack.data(), f.corner);
      },
      f.numbers);
}

void Factorisation::solve(double* b) const {
  std::visit([&](const auto& n) { n.solve(b, 1); }, impl_->numbers);
}

void Factorisation::solve_lanes(double* b) const {
  std::visit([&](const auto& n) { n.solve(b, lane_count); }, impl_->numbers);
}

void Factorisation::half_solve_lanes(double* b) const {
  std::visit([&](const auto& n) { n.half_solve_lanes(b); }, impl_->numbers);
}

Mat3 Factorisation::stiffness() const {
  return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(impl_->corner);
}

void Factorisation::tangent(double* v) const {
  std::visit([&](const auto& n) { n.tangent(v); }, impl_->numbers);
}

std::shared_ptr<const Discretisation> analyse(const Body& body) {
  auto made = std::make_shared<Discretisation>(discretise(body));
  made->layout = make_layout(*made, Precision::exact);
  return made;
}

FactorCost cost_of_factor(const Discretisation& discretisation) {
  const FactorLayout& l = *discretisation.layout;
  const auto bytes = l.padding == row_padding<float> ? sizeof(float) : sizeof(double);
  return {l.flops, static_cast<std::int64_t>(bytes * l.panels()),
          static_cast<std::int64_t>(bytes * l.stacks())};
}

}  // namespace forefeel
