// A step whose solve fails is taken in parts: twice h/2, each of which may be cut again.
//
// Every part obeys the law of its own method for its own step, so what that law keeps for any step
// (the energy balance of the energy-preserving family) is kept exactly; a symplectic method is then
// one for another step for that moment. Inside the step the load is the quadratic of
// runtime/load.h, so the parts receive together what the whole would have received.
//
// The parts' integrators are made when they are first needed: that one step allocates.
#pragma once

#include "runtime/integrator.h"

namespace tremolo {

using IntegratorMaker = Result<std::unique_ptr<Integrator>> (*)(Model::Pointer,
                                                                const IntegratorOptions&);

// What `make` makes, with up to options.halvings halvings of a step that fails. A method that
// splits keeps the split of the whole step in its parts; `imexv-adaptive` starts its first parts
// with that and then chooses for each length of step by itself. Errors as `make`.
Result<std::unique_ptr<Integrator>> make_halving(IntegratorMaker make, Model::Pointer model,
                                                 const IntegratorOptions& options);

}  // namespace tremolo
