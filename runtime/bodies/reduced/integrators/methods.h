// The makers of the integration methods, one file each. Every file starts with the equation of its
// method, its symbols, its order, its stability and the definition of its `dissipated`. factory.cpp
// names the methods.
#pragma once

#include <memory>
#include <string_view>

#include "common/result.h"
#include "runtime/integrator.h"

namespace tremolo {

using IntegratorPointer = std::unique_ptr<Integrator>;

IntegratorPointer make_explicit_euler(Model::Pointer model, const IntegratorOptions& options);
IntegratorPointer make_rk2(Model::Pointer model, const IntegratorOptions& options);
IntegratorPointer make_rk4(Model::Pointer model, const IntegratorOptions& options);
IntegratorPointer make_verlet(Model::Pointer model, const IntegratorOptions& options);
IntegratorPointer make_verlet4(Model::Pointer model, const IntegratorOptions& options);
// Half the trace of its step on a linear mode of angle z = h omega: the cosine of the step's
// rotation angle.
double verlet4_cosine(double z);

IntegratorPointer make_implicit_euler(Model::Pointer model, const IntegratorOptions& options);
IntegratorPointer make_midpoint(Model::Pointer model, const IntegratorOptions& options);
IntegratorPointer make_newmark(Model::Pointer model, const IntegratorOptions& options);

IntegratorPointer make_avf(Model::Pointer model, const IntegratorOptions& options);
IntegratorPointer make_ep2(Model::Pointer model, const IntegratorOptions& options);
IntegratorPointer make_ep4(Model::Pointer model, const IntegratorOptions& options);

// The methods that split the coordinates. Errors: same as for choose_split.
using MadeIntegrator = Result<IntegratorPointer>;
MadeIntegrator make_imexv(Model::Pointer model, const IntegratorOptions& options);
MadeIntegrator make_imexv_thesis(Model::Pointer model, const IntegratorOptions& options);
MadeIntegrator make_imexv_adaptive(Model::Pointer model, const IntegratorOptions& options);
MadeIntegrator make_imexv_linear(Model::Pointer model, const IntegratorOptions& options);
MadeIntegrator make_imexv_coupled(Model::Pointer model, const IntegratorOptions& options);

// name: returned by Integrator::name(). model: linear (Potential::linear).
IntegratorPointer make_exact_linear(std::string_view name, Model::Pointer model,
                                    const IntegratorOptions& options);

// name: returned by Integrator::name(). For a model without coordinates, whose frame is free.
IntegratorPointer make_rigid_step(std::string_view name, const IntegratorOptions& options);

}  // namespace tremolo
