#include "geometry/states/state_message.hpp"
#include "geometry/states/energy_jet.hpp"

namespace forefeel {

namespace {
constexpr int has_displacements = 1, has_jet = 2, has_site = 4;  // of the byte in front of both
}

void pack(Packer& message, const State& s) {
  message.add(s.solve.status);
  for (const Vec3& v : {s.at, s.force, s.solve.parent}) message.add(v);
  for (int i = 0; i < 3; ++i) message.add(Vec3(s.stiffness.row(i)));
  for (const double v : {s.energy, s.spacing, s.solve.residual, s.solve.seconds, s.solve.min_jacobian})
    message.add(v);
  message.add(std::int32_t{s.solve.iterations});
  message.add(std::uint8_t{s.solve.multivalued});
  message.add(static_cast<std::uint8_t>((s.displacements ? has_displacements : 0) | (s.jet ? has_jet : 0) |
                                        (s.has_site() ? has_site : 0)));
  if (s.has_site()) message.add(s.site);
  if (s.displacements) message.add(*s.displacements);
  if (!s.jet) return;
  message.add(static_cast<std::uint8_t>(s.jet->order));
  message.add(s.jet->limit);
  for (std::size_t i = 0; i < jet_terms_of_order(s.jet->order); ++i) message.add(s.jet->coefficients[i]);
}

namespace {

std::shared_ptr<const EnergyJet> unpack_jet(Unpacker& message) {
  const int order = message.number<std::uint8_t>();
  if (order < 2 || order > most_jet_order) throw MalformedMessage("a jet has an unknown order");
  EnergyJet jet{.order = order, .limit = message.number<double>()};
  for (std::size_t i = 0; i < jet_terms_of_order(order); ++i) jet.coefficients[i] = message.number<double>();
  return std::make_shared<const EnergyJet>(jet);
}

}  // namespace

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
  const int parts = message.number<std::uint8_t>();
  if ((parts & ~(has_displacements | has_jet | has_site)) != 0)
    throw MalformedMessage("a state has unknown parts");
  if ((parts & has_site) != 0) s.site = message.vector();
  if ((parts & has_displacements) != 0)
    s.displacements = std::make_shared<const std::vector<double>>(message.values());
  if ((parts & has_jet) != 0) s.jet = unpack_jet(message);
  return s;
}

}  // namespace forefeel
