#pragma once
// Converts the text that a user types for a device, a cost model, a policy, a predictor or workers to a typed choice.
// Each choice keeps its text, so that it is printed as written. No other code reads such text.
//
//   device   path:NAME[,speed=V][,amplitude=A][,tremor=S][,noise=S]    NAME: path_names()
//            trace:FILE[,scale=F][,offset=X/Y/Z][,columns=t/x/y/z][,rate=HZ][,unit=mm][,tool=NAME]
//            hand:PROFILE[,target=NAME][,grip=K|light|medium|firm][,speed=V][,amplitude=A]
//                        [,tremor=S][,noise=S]
//            MINE[:TEXT][,KEY=VALUE…]     registered with register_device()
//   cost     constant:SECONDS   lognormal:MEDIAN,SIGMA   recorded   paper
//            MINE[:TEXT][,KEY=VALUE…]     registered with register_cost()
//   part     NAME[:TEXT][,KEY=VALUE…]     a policy, a predictor, a kind of workers
// Units are SI. InputError("device TEXT: …") says what is wrong and what is expected.

#include <string>
#include <vector>

#include "geometry/common/declared.hpp"
#include "scheduling/common/arguments.hpp"
#include "scheduling/motion/device_spec.hpp"
#include "scheduling/workers/cost_spec.hpp"

namespace forefeel {

DeviceSpec device_from_text(const std::string& text);
CostSpec cost_from_text(const std::string& text);
// kind: the word for errors, such as "policy". Does not check that the name is registered.
Registered part_from_text(const std::string& kind, const std::string& text);

// What these texts may hold, for `forefeel help devices`: a table for each kind of device, and the costs.
std::vector<DeclaredTable> device_tables();
DeclaredTable cost_table();

}  // namespace forefeel
