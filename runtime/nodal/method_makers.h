// The methods' makers; nodal_factory.cpp maps names to them.
#pragma once

#include <memory>
#include <string_view>

#include "runtime/nodal/nodal_integrator.h"

namespace tremolo {

std::unique_ptr<NodalIntegrator> make_explicit(std::string_view name, const NodalSystem& system,
                                               const NodalOptions& options);
Result<std::unique_ptr<NodalIntegrator>> make_implicit(std::string_view name,
                                                       const NodalSystem& system,
                                                       const NodalOptions& options);
Result<std::unique_ptr<NodalIntegrator>> make_split(const NodalSystem& system,
                                                    const NodalOptions& options);

}  // namespace tremolo
