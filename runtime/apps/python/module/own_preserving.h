// The methods `avf` and `ep4` for a potential of the user's (docs/theory.md, section "Methods").
#pragma once

#include <memory>
#include <string_view>

#include <Eigen/Core>

#include "runtime/step/nodal_integrator.h"

namespace tremolo::python {

// A potential of coordinates with the mass 1.
class OwnPotential {
 public:
  virtual ~OwnPotential() = default;
  virtual Eigen::Index coordinates() const = 0;  // r
  virtual double value(const Eigen::VectorXd& y) const = 0;
  virtual Eigen::VectorXd slope(const Eigen::VectorXd& y) const = 0;    // r
  virtual Eigen::MatrixXd tangent(const Eigen::VectorXd& y) const = 0;  // r x r, symmetric
  virtual double force_size() const = 0;                                // the largest force so far
};

// name: "avf" or "ep4"; null for another. potential: must outlive the method.
std::unique_ptr<NodalIntegrator> make_preserving(std::string_view name,
                                                 const OwnPotential& potential,
                                                 const NodalOptions& options);

}  // namespace tremolo::python
