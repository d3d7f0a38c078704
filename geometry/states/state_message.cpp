#include "geometry/states/state_message.hpp"

namespace forefeel {

void pack(Packer& message, const State& s) {
  message.add(s.solve.status);
  for (const Vec3& v : {s.at, s.force, s.solve.parent}) message.add(v);
  for (int i = 0; i < 3; ++i) message.add(Vec3(s.stiffness.row(i)));
  for (const double v : {s.energy, s.spacing, s.solve.residual, s.solve.seconds, s.solve.min_jacobian})
    message.add(v);
  message.add(std::int32_t{s.solve.iterations});
  message.add(std::uint8_t{s.solve.multivalued});
  message.add(std::uint8_t{s.displacements != nullptr});
  if (s.displacements) message.add(*s.displacements);
}

State unpack_state(Unpacker& message) {
  State s;
  const auto status = message.number<std::uint8_t>();
  if (status > static_cast<std::uint8_t>(SolveStatus::measured))
    throw MalformedMessage("a state has an unknown status");
  s.solve.status = static_cast<SolveStatus>(status);
  for (Vec3* v : {&s.at, &s.force, &s.solve.parent}) *v = message.vector();
  for (int i = 0; i < 3; ++i) s.stiffness.row(i) = message.vector();
  for (double* v : {&s.energy, &s.spacing, &s.solve.residual, &s.solve.seconds, &s.solve.min_jacobian})
    *v = message.number<double>();
  s.solve.iterations = message.number<std::int32_t>();
  s.solve.multivalued = message.number<std::uint8_t>() != 0;
  if (message.number<std::uint8_t>() != 0)
    s.displacements = std::make_shared<const std::vector<double>>(message.values());
  return s;
}

}  // namespace forefeel
