// DampedKick (damping.h) with the damping of StrainDamping at the position of the kick: the kick by
// f - rest(q) v, where v is the mean velocity in the half step that results from that force itself.
//
// With the reach and path of DampedKick, F the total force and s = h/2,
//
//     F = f - rest(q) v,      s v = reach p + path F,
//
// that is (path + path rest(q) path/s) F = path (f - rest(q) reach p/s): symmetric, and positive
// because path beta Lambda/s < 1. Conjugate gradients preconditioned by `path` solve it.
#pragma once

#include "runtime/integrators/solve/damping.h"
#include "runtime/integrators/solve/strain_damping.h"

namespace tremolo {

class StrainKick {
 public:
  StrainKick() = default;
  // rates: D of all coordinates, same as for DampedKick.
  StrainKick(const Eigen::VectorXd& rates, double step)
      : kick_(rates, step), half_step_(0.5 * step) {
    for (Eigen::VectorXd* v : {&force_, &residual_, &direction_, &image_, &velocity_})
      v->setZero(rates.size());
  }

  // Kicks p at q by f, r each. Returns the energy that damping took, J. Nothing is allocated.
  double operator()(StrainDamping& strain, const Eigen::VectorXd& q, const Eigen::VectorXd& f,
                    Eigen::VectorXd& p);

 private:
  DampedKick kick_;
  double half_step_ = 0.0;
  Eigen::VectorXd force_, residual_, direction_, image_, velocity_;
};

struct StrainFlowScratch {
  Eigen::VectorXd term, next, path;  // r each
};

// The exact flow of p' = g - rest(q) p over the time s, which may be negative. Returns the energy
// that damping took, J. The series ends where its terms are below rounding.
double flow_with_strain_damping(StrainDamping& strain, const Eigen::VectorXd& q,
                                const Eigen::VectorXd& g, double s, Eigen::VectorXd& p,
                                StrainFlowScratch& scratch);

}  // namespace tremolo
