// A step whose solve fails is taken in parts: twice h/2, each of which may be divided again.
//
// Every part obeys its method's law for its own step. A quantity that the law conserves for any
// step (the energy balance of the energy-preserving family) is therefore conserved exactly; a
// symplectic method is symplectic for another step at that time. Inside the step the load is the
// quadratic of runtime/load.h, so that the parts together receive the impulse of the whole.
//
// The parts' integrators are made at the first failure: that one step allocates.
#pragma once

#include "runtime/integrator.h"

namespace tremolo {

using IntegratorMaker = Result<std::unique_ptr<Integrator>> (*)(Model::Pointer,
                                                                const IntegratorOptions&);

// Makes the method of `make` with up to options.halvings halvings of a step that fails. A method
// that splits keeps the split of the whole step in its parts; `imexv-adaptive` starts its first
// parts with that and then chooses a split for each length of step. Errors: same as for `make`.
Result<std::unique_ptr<Integrator>> make_halving(IntegratorMaker make, Model::Pointer model,
                                                 const IntegratorOptions& options);

}  // namespace tremolo
