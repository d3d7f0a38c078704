#pragma once
// A vector with signed numbers: those of workers, or by which nodes of a tree and links of a list name each other (-1:
// none).

#include <cstddef>
#include <cstdint>
#include <vector>

namespace forefeel {

template <class Element, class Container = std::vector<Element>>
class SignedVector : public Container {
 public:
  using Container::Container;
  Element& operator[](std::int32_t i) { return Container::operator[](static_cast<std::size_t>(i)); }
  const Element& operator[](std::int32_t i) const {
    return Container::operator[](static_cast<std::size_t>(i));
  }
  std::int32_t count() const { return static_cast<std::int32_t>(this->size()); }
};

}  // namespace forefeel
