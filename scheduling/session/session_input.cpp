#include "scheduling/session/session_input.hpp"

#include "scheduling/touch/surface_models.hpp"
#include "scheduling/workers/reference_service.hpp"

namespace forefeel {

std::shared_ptr<const RestSites> sites_of(const TouchedBody& touched) {
  return touched.anywhere ? touched.anywhere->field->rest_shared() : nullptr;
}

ReferenceOptions reference_options(const SessionInput& input) {
  const TouchedBody& touched = input.touched;
  return {.body = touched.body,
          .identity = touched.identity,
          .spacing = touched.space.spacing,
          .box = touched.space.box,
          .displacements = touched.displacements,
          .jet = touched.jet,
          .sites = sites_of(touched),
          .cache_folder = input.files.cache};
}

}  // namespace forefeel
