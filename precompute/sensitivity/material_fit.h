// Constants of materials from measured frequencies, by the method of Gauss and Newton.
//
// The unknowns are ln E and ln rho of a material, and nu; with the standard deviations s of the
// measured frequencies f, the sum of ((f - f(unknowns))/s)^2 is made least. The covariance of the
// unknowns is (J^T J)^-1, J the derivatives of f(unknowns)/s. Where the deviations are not known
// the sum is that of (ln f - ln f(unknowns))^2: all frequencies are off by equal fractions, and the
// misfit gives the fraction. Fractions of the measured values would favour those measured low.
//
// Frequencies alone do not change when E and rho are multiplied by one number: they give the ratio.
// The unknowns of which a combination has no effect are refused by name.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "common/elements/elasticity.h"
#include "precompute/modes/mode_clusters.h"
#include "precompute/sensitivity/measurements.h"
#include "precompute/sensitivity/modal_forms.h"

namespace tremolo {

enum class FitConstant { kYoung, kPoisson, kDensity };

// E of an orthotropic material stands for all its moduli together.
struct FitUnknown {
  FitConstant constant = FitConstant::kYoung;
  std::size_t material = 0;
};

// text: "young", "young,density", "young:REGION,poisson", ...; without a region: of every material.
// Errors: kUsage for another form or an unknown region; kContent for nu of an orthotropic material.
Result<std::vector<FitUnknown>> read_unknowns(const std::string& text, const MaterialTable& table);

// "young of `grip`"; without a region where there is one material.
std::string name_of(const FitUnknown& unknown, const MaterialTable& table);

// Frequencies, derivatives and mass of a body with certain materials.
struct FitModel {
  Eigen::VectorXd squared;          // omega^2 of its modes, (rad/s)^2, ascending
  std::vector<Cluster> clusters;    // of equal frequencies
  std::vector<ModeDerivatives> by;  // one a material
  std::vector<double> mass;         // of each material, kg
  double other_mass = 0.0;          // of point masses, kg
};

struct FitProblem {
  MaterialTable materials;  // the start
  std::vector<FitUnknown> unknowns;
  Measurements measured;
  std::optional<Uncertain> mass;  // of the body, kg
  std::function<FitModel(const MaterialTable&)> solve;
};

// A measured frequency after the fit, Hz, of the ringing body as in the file.
struct FittedRow {
  int mode = 0;   // from 0
  int equal = 1;  // modes of this frequency: their mean is compared
  double measured = 0.0, deviation = 0.0, fitted = 0.0;
  bool ambiguous = false;  // a mode that no row has is as near
};

struct MaterialFit {
  MaterialTable materials;
  Eigen::VectorXd values;       // of the unknowns: Pa, dimensionless, kg/m^3
  Eigen::VectorXd deviations;   // standard deviations, in the same units
  Eigen::MatrixXd correlation;  // of the unknowns
  std::vector<int> modes;       // of every row of the measurements, from 0
  std::vector<FittedRow> rows;  // of those with a frequency
  double chi_squared = 0.0;     // with the deviations; if they are not known, of equal fractions
  int freedom = 0;              // data less unknowns
  // The deviations are the data's. False: they are from the misfit; with freedom 0 unknown.
  bool absolute = false;
  int solves = 0;  // of the body's modes
};

// Errors: kContent for too few data, unknowns that the data do not determine, a measured mode that
// is not computed; kSolver if it does not converge. Throws what `solve` throws.
Result<MaterialFit> fit_materials(const FitProblem& problem);

// A sentence if the fitted body is not the measured one: the misfit is far beyond the deviations,
// or, if they are not known, a frequency is off by more than 5 %. Empty else.
std::string misfit_warning(const MaterialFit& fit);

}  // namespace tremolo
