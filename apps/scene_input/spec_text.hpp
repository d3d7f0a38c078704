#pragma once
// What a user types for a device, a cost model, a policy, a predictor or workers, read into typed choices. Each keeps the
// text as it was written, so that it is printed as written. The only place where such text is read.
//
//   device   path:NAME[,speed=V][,amplitude=A][,tremor=S][,noise=S]    NAME: path_names()
//            trace:FILE[,scale=F][,offset=X/Y/Z]
//            hand:PROFILE[,target=NAME][,grip=K|light|medium|firm][,speed=V][,amplitude=A][,tremor=S][,noise=S]
//            MINE[:TEXT][,KEY=VALUE…]                                   registered with register_device()
//   cost     constant:SECONDS   lognormal:MEDIAN,SIGMA   recorded   paper
//            MINE[:TEXT][,KEY=VALUE…]                                   registered with register_cost()
//   part     NAME[:TEXT][,KEY=VALUE…]                                   a policy, a predictor, a kind of workers
// Units are SI. InputError("device TEXT: …") says what is wrong and what is expected.

#include <string>

#include "scheduling/common/arguments.hpp"
#include "scheduling/motion/device_spec.hpp"
#include "scheduling/workers/cost_spec.hpp"

namespace forefeel {

DeviceSpec device_from_text(const std::string& text);
CostSpec cost_from_text(const std::string& text);
// kind: for errors, as "policy". The name is not looked up.
Registered part_from_text(const std::string& kind, const std::string& text);

}  // namespace forefeel
