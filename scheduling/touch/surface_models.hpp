#pragma once
// A body that may be touched anywhere, as a session needs it, and the models that its states make: the field of jets at
// rest, corrected by the states solved so far (solver/jet/deep_states.hpp). A model is immutable and lives as long as
// the session, so that the loop may take the newest without giving back the one before.

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "geometry/states/state.hpp"
#include "scheduling/motion/touch_surface.hpp"
#include "scheduling/render/model_keeper.hpp"
#include "scheduling/touch/touch_field.hpp"

namespace forefeel {

inline constexpr double usual_friction = 0.2;  // of moist tissue

// What is known of the body, and wanted of its states.
struct TouchTask {
  std::shared_ptr<const SiteField> field;
  std::shared_ptr<const SurfaceGrid> grid;
  std::shared_ptr<const FieldPatches> patches;      // of the field
  std::shared_ptr<const TouchSurface> surface;      // for paths of the hand
  double depth = 0.025;                             // of states [m]
  std::optional<double> friction = usual_friction;  // coefficient; none: bonded, the site never moves
  double tolerance = 0.07;                          // of the relative error [1]
  double floor = 0.05;                              // f0 [N]

  double site_spacing() const { return field->options().spacing; }  // [m]
  FieldOfSites field_of_sites() const { return {field, grid, farthest_of(depth), patches}; }
};

struct SurfaceModel {
  std::uint32_t serial = 0, known = 0;  // known: states that it holds
  std::shared_ptr<const DeepStates> deep;
};

// One thread owns it.
class SurfaceModels {
 public:
  explicit SurfaceModels(std::shared_ptr<const TouchTask> task);

  const TouchTask& task() const { return *task_; }
  // Usable, with a site. Its number is that of the states learned before it.
  void learn(const State& state);
  const std::vector<State>& known() const { return known_; }
  const SurfaceModel* newest();                                        // of all that is known; stays valid
  const SurfaceModel* latest() const { return models_.back().get(); }  // made last
  const SurfaceModel* made(std::uint64_t serial) const;                // null: there is none of that number
  // By serial number - 1.
  std::vector<std::shared_ptr<const DeepStates>> all() const;

 private:
  std::shared_ptr<const TouchTask> task_;
  std::vector<State> known_;
  std::vector<std::unique_ptr<SurfaceModel>> models_;
};

// Passes the newest model to the loop.
class SurfaceMaker final : public ModelMaker {
 public:
  SurfaceMaker(std::shared_ptr<SurfaceModels> models, LoopLink& link)
      : models_(std::move(models)), link_(link) {}
  void update(double now, const Vec3& hip, bool time_it = false) override;

 private:
  std::shared_ptr<SurfaceModels> models_;
  LoopLink& link_;
  const SurfaceModel* published_ = nullptr;
};

}  // namespace forefeel
