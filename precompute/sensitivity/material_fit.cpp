#include "precompute/sensitivity/material_fit.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include <Eigen/SVD>

#include "common/text.h"
#include "precompute/sensitivity/mode_matching.h"

namespace tremolo {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kLeastPoisson = -0.99, kMostPoisson = 0.4999;
constexpr const char* kNames[] = {"young", "poisson", "density"};

Material& material_of(MaterialTable& table, const FitUnknown& unknown) {
  return table.materials[unknown.material].material;
}

// ln E, nu or ln rho.
double coordinate_of(MaterialTable& table, const FitUnknown& unknown) {
  const Material& material = material_of(table, unknown);
  switch (unknown.constant) {
    case FitConstant::kYoung:
      return std::log(material.orthotropic ? material.orthotropic->young[0] : material.young);
    case FitConstant::kPoisson:
      return material.poisson;
    default:
      return std::log(material.density);
  }
}

void move(const FitUnknown& unknown, double by, MaterialTable& table) {
  Material& material = material_of(table, unknown);
  switch (unknown.constant) {
    case FitConstant::kYoung:
      if (material.orthotropic) {
        material.orthotropic->young *= std::exp(by);
        material.orthotropic->shear *= std::exp(by);
      } else {
        material.young *= std::exp(by);
      }
      return;
    case FitConstant::kPoisson:
      material.poisson = std::clamp(material.poisson + by, kLeastPoisson, kMostPoisson);
      return;
    default:
      material.density *= std::exp(by);
  }
}

// A cluster's mean stands for each of its modes, so that it does not matter which one was measured.
struct Comparison {
  double hertz = 0.0;
  VectorXd by;  // of the unknowns
  int equal = 1;
};

Cluster cluster_of(const FitModel& model, Index mode) {
  for (const Cluster& cluster : model.clusters)
    if (mode >= cluster.first && mode < cluster.first + cluster.count) return cluster;
  return {mode, 1};
}

Comparison compare(const FitModel& model, const std::vector<FitUnknown>& unknowns, int mode) {
  const Cluster cluster = cluster_of(model, mode);
  const auto mean = [&cluster](const VectorXd& values) {
    return values.segment(cluster.first, cluster.count).mean();
  };
  const double omega = std::sqrt(mean(model.squared));
  Comparison result;
  result.equal = static_cast<int>(cluster.count);
  result.hertz = 0.5 * omega / std::numbers::pi;
  result.by.resize(std::ssize(unknowns));
  for (Index u = 0; u < result.by.size(); ++u) {
    const FitUnknown& unknown = unknowns[static_cast<std::size_t>(u)];
    const ModeDerivatives& by = model.by[unknown.material];
    const VectorXd& squared = unknown.constant == FitConstant::kYoung     ? by.by_log_stiffness
                              : unknown.constant == FitConstant::kPoisson ? by.by_poisson
                                                                          : by.by_log_density;
    result.by[u] = 0.25 * mean(squared) / (std::numbers::pi * omega);
  }
  return result;
}

// The weighted equations: residual = (measured - computed)/deviation, or the difference of the
// logarithms, and its derivatives with the opposite sign.
struct Equations {
  VectorXd residual;
  MatrixXd jacobian;
  std::vector<FittedRow> rows;

  double chi_squared() const { return residual.squaredNorm(); }
};

Equations equations_of(const FitProblem& problem, const FitModel& model,
                       const std::vector<int>& modes) {
  const std::vector<MeasuredMode>& measured = problem.measured.rows;
  const auto frequencies =
      std::count_if(measured.begin(), measured.end(),
                    [](const MeasuredMode& row) { return bool(row.frequency); });
  const Index count = frequencies + (problem.mass ? 1 : 0), p = std::ssize(problem.unknowns);
  Equations equations{VectorXd(count), MatrixXd(count, p), {}};
  Index at = 0;
  for (std::size_t i = 0; i < measured.size(); ++i) {
    if (!measured[i].frequency) continue;
    const Uncertain& known = *measured[i].frequency;
    const Comparison computed = compare(model, problem.unknowns, modes[i]);
    const bool absolute = known.deviation > 0.0;
    const double scale = absolute ? known.deviation : computed.hertz;
    equations.residual[at] =
        absolute ? (known.value - computed.hertz) / scale : std::log(known.value / computed.hertz);
    equations.jacobian.row(at++) = computed.by.transpose() / scale;
    equations.rows.push_back(
        {modes[i], computed.equal, known.value, known.deviation, computed.hertz, false});
  }
  if (!problem.mass) return equations;
  double mass = model.other_mass;
  for (const double each : model.mass) mass += each;
  const double scale =
      problem.mass->deviation > 0.0 ? problem.mass->deviation : 1e-6 * problem.mass->value;
  equations.residual[at] = (problem.mass->value - mass) / scale;
  for (Index u = 0; u < p; ++u) {
    const FitUnknown& unknown = problem.unknowns[static_cast<std::size_t>(u)];
    const bool changes = unknown.constant == FitConstant::kDensity;
    equations.jacobian(at, u) = changes ? model.mass[unknown.material] / scale : 0.0;
  }
  return equations;
}

// kContent with the combination that has no effect on the data.
Status check_determined(const FitProblem& problem, const Equations& equations) {
  constexpr double kNoEffect = 1e-5;  // of the largest effect of a combination
  const Index p = equations.jacobian.cols();
  if (equations.jacobian.rows() < p)
    return content_error(std::to_string(equations.jacobian.rows()) + " values are measured for " +
                         std::to_string(p) + " unknowns: measure more, or fit fewer (--fit-for)");
  // The mass row is far more precise than the others; a row's size does not make it determine more.
  MatrixXd scaled = equations.jacobian;
  for (Index i = 0; i < scaled.rows(); ++i) scaled.row(i).normalize();
  const Eigen::JacobiSVD<MatrixXd> svd(scaled, Eigen::ComputeFullV);
  if (svd.singularValues()[p - 1] > kNoEffect * svd.singularValues()[0]) return Success{};
  std::string names;
  const VectorXd direction = svd.matrixV().col(p - 1);
  bool density = false;
  for (Index u = 0; u < p; ++u) {
    const FitUnknown& unknown = problem.unknowns[static_cast<std::size_t>(u)];
    if (std::abs(direction[u]) < 0.05) continue;
    density = density || unknown.constant == FitConstant::kDensity;
    names += (names.empty() ? "" : " and ") + name_of(unknown, problem.materials);
  }
  std::string message = "the measurements do not determine " + names;
  if (density && !problem.mass)
    message +=
        ": frequencies alone give the ratio of stiffness and density only. Give the mass "
        "(--fit-mass KG), or leave density out of --fit-for, so that it stays as given";
  else
    message += " one by one: leave one of them out of --fit-for";
  return content_error(std::move(message));
}

// Rows for which a mode that no row has is about as near as their own.
void find_ambiguous(const FitModel& model, std::vector<FittedRow>& rows) {
  std::vector<char> taken(static_cast<std::size_t>(model.squared.size()), 0);
  for (const FittedRow& row : rows) taken[static_cast<std::size_t>(row.mode)] = 1;
  for (FittedRow& row : rows) {
    const double own = std::abs(row.measured - row.fitted);
    const Cluster cluster = cluster_of(model, row.mode);
    for (Index mode = 0; mode < model.squared.size(); ++mode) {
      const bool same = mode >= cluster.first && mode < cluster.first + cluster.count;
      if (same || taken[static_cast<std::size_t>(mode)] != 0) continue;
      const double hertz = 0.5 * std::sqrt(model.squared[mode]) / std::numbers::pi;
      const double other = std::abs(row.measured - hertz);
      row.ambiguous = row.ambiguous || other <= std::max(2.0 * own, 2.0 * row.deviation);
    }
  }
}

// The rows were compared without damping; they are shown as they were measured.
void show_as_measured(const Measurements& measured, std::vector<FittedRow>& rows) {
  std::size_t at = 0;
  for (const MeasuredMode& row : measured.rows) {
    if (!row.frequency) continue;
    FittedRow& shown = rows[at++];
    for (double* value : {&shown.measured, &shown.deviation, &shown.fitted}) *value /= row.stretch;
  }
}

void add_uncertainty(const FitProblem& problem, const Equations& equations, MaterialFit& fit) {
  const MatrixXd& J = equations.jacobian;
  const Index p = J.cols();
  const Eigen::JacobiSVD<MatrixXd> svd(J, Eigen::ComputeThinU | Eigen::ComputeThinV);
  const MatrixXd root = svd.matrixV() * svd.singularValues().cwiseInverse().asDiagonal();
  MatrixXd covariance = root * root.transpose();
  fit.chi_squared = equations.chi_squared();
  fit.freedom = static_cast<int>(J.rows() - p);
  fit.absolute = problem.measured.frequency_deviations;
  if (!fit.absolute)
    covariance *=
        fit.freedom > 0 ? fit.chi_squared / fit.freedom : std::numeric_limits<double>::quiet_NaN();
  const VectorXd sigma = covariance.diagonal().cwiseSqrt();
  fit.correlation =
      sigma.cwiseInverse().asDiagonal() * covariance * sigma.cwiseInverse().asDiagonal();
  fit.values.resize(p);
  fit.deviations.resize(p);
  for (Index u = 0; u < p; ++u) {
    const FitUnknown& unknown = problem.unknowns[static_cast<std::size_t>(u)];
    const double coordinate = coordinate_of(fit.materials, unknown);
    const bool poisson = unknown.constant == FitConstant::kPoisson;
    fit.values[u] = poisson ? coordinate : std::exp(coordinate);
    fit.deviations[u] = poisson ? sigma[u] : sigma[u] * fit.values[u];
  }
}

}  // namespace

std::string name_of(const FitUnknown& unknown, const MaterialTable& table) {
  const std::string name = kNames[static_cast<std::size_t>(unknown.constant)];
  if (table.materials.size() == 1) return name;
  return name + " of `" + table.materials[unknown.material].name + "`";
}

Result<std::vector<FitUnknown>> read_unknowns(const std::string& text, const MaterialTable& table) {
  std::vector<FitUnknown> unknowns;
  for (std::size_t at = 0; at <= text.size();) {
    const std::size_t end = std::min(text.find(',', at), text.size());
    const std::string item = text.substr(at, end - at);
    at = end + 1;
    const std::size_t colon = item.find(':');
    const std::string name = item.substr(0, colon);
    const auto known = std::find(std::begin(kNames), std::end(kNames), name);
    if (known == std::end(kNames))
      return usage_error("--fit-for " + text +
                         ": expected young, poisson, density, or one of these of a region as in "
                         "young:REGION, separated by commas");
    const auto constant = static_cast<FitConstant>(known - std::begin(kNames));
    const std::size_t before = unknowns.size();
    for (std::size_t m = 0; m < table.materials.size(); ++m) {
      if (colon != std::string::npos && table.materials[m].name != item.substr(colon + 1)) continue;
      if (constant == FitConstant::kPoisson && table.materials[m].material.orthotropic)
        return content_error("--fit-for " + text +
                             ": Poisson's ratio of an orthotropic material (" +
                             table.materials[m].name + ") cannot be fitted");
      for (const FitUnknown& other : unknowns)
        if (other.constant == constant && other.material == m)
          return usage_error("--fit-for " + text + ": " + name_of(other, table) +
                             " is there twice");
      unknowns.push_back({constant, m});
    }
    if (unknowns.size() == before)
      return usage_error("--fit-for " + text + ": there is no material '" + item.substr(colon + 1) +
                         "'");
  }
  return unknowns;
}

Result<MaterialFit> fit_materials(const FitProblem& problem) {
  constexpr int kMostSolves = 40;
  constexpr double kSmallMove = 1e-7;  // of ln E, nu, ln rho; the error left is its square
  constexpr double kLongestMove = 1.0;
  MaterialFit fit;
  fit.materials = problem.materials;
  const auto solve = [&](const MaterialTable& materials) {
    ++fit.solves;
    return problem.solve(materials);
  };
  FitModel model = solve(fit.materials);
  double share = 1.0;
  while (true) {
    VectorXd hertz = model.squared.cwiseSqrt() / (2.0 * std::numbers::pi);
    Result<std::vector<int>> modes = match_modes(problem.measured.rows, hertz);
    if (!modes) return modes.error();
    fit.modes = *modes;
    const Equations now = equations_of(problem, model, fit.modes);
    if (Status s = check_determined(problem, now); !s) return s.error();
    const Eigen::JacobiSVD<MatrixXd> svd(now.jacobian, Eigen::ComputeThinU | Eigen::ComputeThinV);
    VectorXd step = svd.solve(now.residual);
    const double longest = step.lpNorm<Eigen::Infinity>();
    if (longest < kSmallMove) {
      add_uncertainty(problem, now, fit);
      fit.rows = now.rows;
      find_ambiguous(model, fit.rows);
      show_as_measured(problem.measured, fit.rows);
      return fit;
    }
    if (!std::isfinite(longest) || fit.solves >= kMostSolves)
      return Error{ErrorKind::kSolver,
                   "the fit did not converge in " + std::to_string(fit.solves) +
                       " solutions: begin nearer (--young, --poisson, --density), or name the "
                       "modes in the file"};
    step *= std::min(1.0, kLongestMove / longest);
    // A shorter move where the misfit would grow, with the modes as they are matched now.
    for (share = 1.0;; share *= 0.5) {
      MaterialTable moved = fit.materials;
      for (Index u = 0; u < step.size(); ++u)
        move(problem.unknowns[static_cast<std::size_t>(u)], share * step[u], moved);
      FitModel there = solve(moved);
      const bool better =
          equations_of(problem, there, fit.modes).chi_squared() <= now.chi_squared() * (1.0 + 1e-9);
      if (!better && share > 1e-3 && fit.solves < kMostSolves) continue;
      fit.materials = std::move(moved);
      model = std::move(there);
      break;
    }
  }
}

std::string misfit_warning(const MaterialFit& fit) {
  constexpr double kMuch = 10.0;  // of chi^2 a degree of freedom; chance hardly reaches it
  constexpr double kFar = 0.05;   // of a frequency: no measurement errs by as much
  const std::string causes =
      ": the modes are matched wrongly, or shape or support differ from the measured body's";
  if (fit.absolute)
    return fit.freedom > 0 && fit.chi_squared > kMuch * fit.freedom
               ? text("the misfit is %.2g times what the standard deviations explain",
                      std::sqrt(fit.chi_squared / fit.freedom)) +
                     causes
               : std::string();
  const FittedRow* worst = nullptr;
  const auto distance = [](const FittedRow& row) {
    return std::abs(std::log(row.measured / row.fitted));
  };
  for (const FittedRow& row : fit.rows)
    if (worst == nullptr || distance(row) > distance(*worst)) worst = &row;
  if (worst == nullptr || distance(*worst) < kFar) return {};
  return text("this is not a fit, mode %d is off by %+.3g %%", worst->mode + 1,
              100.0 * (worst->measured / worst->fitted - 1.0)) +
         causes + "; begin nearer (--young, --poisson, --density), or name the modes in the file";
}

}  // namespace tremolo
