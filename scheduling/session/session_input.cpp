#include "scheduling/session/session_input.hpp"

#include "scheduling/touch/surface_models.hpp"
#include "scheduling/workers/reference_service.hpp"

namespace forefeel {

ReferenceOptions reference_options(const SessionInput& input) {
  const TouchedBody& touched = input.touched;
  return {.body = touched.body,
          .identity = touched.identity,
          .spacing = touched.space.spacing,
          .box = touched.space.box,
          .displacements = touched.displacements,
          .jet = touched.jet,
          .sites = touched.anywhere ? touched.anywhere->field->rest_shared() : nullptr,
          .cache_folder = input.files.cache};
}

}  // namespace forefeel
