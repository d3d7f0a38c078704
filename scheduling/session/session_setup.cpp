#include "scheduling/session/session_setup.hpp"

#include "geometry/coverage/state_space.hpp"
#include "scheduling/motion/predictor.hpp"
#include "scheduling/policy/policy.hpp"
#include "scheduling/workers/reference_service.hpp"
#include "solver/body/body.hpp"
#include "solver/body/contact_bound.hpp"

namespace forefeel {

FactoryContext factory_context(const SessionPlan& plan) {
  return {.box = plan.input.touched.space.box,
          .inward = plan.input.touched.inward,
          .seed = plan.options.seed,
          .folder = plan.input.files.scene};
}

std::shared_ptr<Policy> policy_of(const SessionPlan& plan) {
  if (plan.input.parts.policy) return plan.input.parts.policy;
  return make_policy(plan.options.planning.policy, factory_context(plan));
}

std::shared_ptr<Predictor> predictor_of(const SessionPlan& plan) {
  if (plan.input.parts.predictor) return plan.input.parts.predictor;
  return make_predictor(plan.options.motion.predictor, factory_context(plan));
}

bool is_rehearsed(const SessionPlan& plan) {
  const SessionOptions& options = plan.options;
  return options.planning.policy.name == "clairvoyant" && !plan.input.parts.policy &&
         options.clock.kind == Clock::virtual_time && !options.planning.arrivals && !options.motion.replay &&
         !plan.input.foreign;
}

std::vector<double> coarse_costs(const CostModel& cost, const Box& box) {
  std::vector<double> seconds;
  for (const Vec3& x : lattice(box, box.size().maxCoeff() / 4)) seconds.push_back(checked_seconds(cost, x));
  return seconds;
}

std::unique_ptr<CostModel> cost_model(const SessionPlan& plan, ReferenceService& references) {
  if (plan.input.foreign) return make_cost(CostSpec(), factory_context(plan), {});  // no solve is measured
  return make_cost(plan.options.workers.cost, factory_context(plan),
                   [&] { return references.recorded_costs(); });
}

PlannerSetup planner_setup(const SessionPlan& plan) {
  const SessionOptions& options = plan.options;
  return {.space = plan.input.touched.space,
          .known = plan.input.known,
          .nodes = plan.input.touched.body->mesh.nodes.size(),
          .policy = policy_of(plan),
          .predictor = predictor_of(plan),
          .placement = options.planning.placement,
          .batch = plan.batch,
          .preempt = options.planning.preempt,
          .rest_first = options.planning.rest_first,
          .latency = options.workers.latency,
          .model = plan.model,
          .jnd = options.switching,
          .audits = {.share = options.planning.audit, .seed = options.seed},
          .stiffest = contact_stiffness_bound(*plan.input.touched.body)};
}

JudgeSetup judge_setup(const SessionPlan& plan) {
  return {.model = plan.model,
          .judging = plan.options.judging,
          .stop = plan.options.stop,
          .viscosity = plan.input.touched.viscosity,
          .errors = !plan.input.foreign};
}

}  // namespace forefeel
