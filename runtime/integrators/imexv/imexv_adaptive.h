// `imexv` (runtime/integrators/imexv/imexv.h) with a split that follows the motion.
//
// Deformation stiffens a solid: the explicit half is stable only while h^2 lambda_max(K_ll(q)) < 4,
// K_ll the low rows' block of the tangent at the present q, and a split made for K(0) may leave
// that. Whether a block obeys lambda_max(K_ll) < b is answered exactly by one Cholesky
// factorisation of b I - K_ll: it runs through iff the block obeys, and where it stops at pivot j
// the leading j coordinates are the largest leading block that does. K(q) costs nothing beside
// R(q), which every step evaluates there anyway.
//
//   - before each step: b = (2 leave/h)^2, leave = (1 + safety)/2. The coordinates from the pivot
//     that fails on become implicit at once.
//   - the block with one coordinate more has obeyed the stricter b = (2 safety/h)^2 for as long as
//     one period of the lowest mode (100 steps at least, 10 000 at most): that coordinate becomes
//     explicit again.
//
// The bound is necessary, not sufficient: V couples low and high rows, `imexv` is symplectic only
// where it does not, and strong coupling can feed energy in while every block obeys. So the balance
// is watched too: a step after which H exceeds what was there and was put in by a tenth is done
// again with half of the low coordinates, the others implicit for good (until reset()), and the
// watch begins anew from there. With none left the step is the midpoint rule.
//
// Each step is one of `imexv` with the split of the moment: its order, damping and dissipation. A
// change of split moves the level on which the energy oscillates by a part of that oscillation,
// which is why coordinates come back late.
#pragma once

#include "runtime/integrator.h"

namespace tremolo {

// Starts with the split that options.split gives. Errors as choose_split.
Result<std::unique_ptr<Integrator>> make_imexv_adaptive(Model::Pointer model,
                                                        const IntegratorOptions& options);

}  // namespace tremolo
