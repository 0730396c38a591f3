#include "precompute/fit_solid.h"

#include <cmath>
#include <cstdio>
#include <numbers>

#include <nlohmann/json.hpp>

#include "common/text.h"
#include "common/units.h"
#include "precompute/problem/material_rules.h"
#include "precompute/problem/point_mass.h"
#include "precompute/sensitivity/mode_matching.h"
#include "precompute/system/failure.h"

namespace tremolo {
namespace {

using Json = nlohmann::ordered_json;

// "KG" or "KG:SD".
Uncertain read_mass(const std::string& text) {
  const std::size_t colon = std::min(text.find(':'), text.size());
  const auto number = [](const std::string& part, double& value) {
    const auto [stop, error] = read_decimal(part.data(), part.data() + part.size(), value);
    return error == std::errc{} && stop == part.data() + part.size() && value > 0.0 &&
           std::isfinite(value);
  };
  Uncertain mass;
  const bool good = number(text.substr(0, colon), mass.value) &&
                    (colon == text.size() || number(text.substr(colon + 1), mass.deviation));
  if (good) return mass;
  throw Failure(
      usage_error("--fit-mass " + text +
                  ": expected KG or KG:SD, the measured mass and its standard deviation"));
}

FitModel model_of(const ModeSensitivities& found, const Problem& problem) {
  FitModel model{found.squared_frequencies, found.clusters, found.by, {}, 0.0};
  const std::vector<MaterialShare> shares = material_shares(problem.materials, problem.mesh);
  for (std::size_t m = 0; m < shares.size(); ++m)
    model.mass.push_back(problem.materials.materials[m].material.density * shares[m].volume);
  for (const double mass : mass_of_vertices(problem.point_masses, problem.mesh.vertices.size()))
    model.other_mass += mass;
  return model;
}

const char* unit_of(FitConstant constant) {
  return constant == FitConstant::kYoung     ? " Pa"
         : constant == FitConstant::kDensity ? " kg/m^3"
                                             : "";
}

// "value +- deviation" with as many digits as the deviation bears; "value" where it is not known.
std::string with_deviation(double value, double deviation) {
  return std::isfinite(deviation) && deviation > 0.0 ? text("%.6g +- %.2g", value, deviation)
                                                     : text("%.6g (uncertainty not known)", value);
}

// Null for a number that is not known.
Json known(double value) {
  return std::isfinite(value) ? Json(value) : Json(nullptr);
}

}  // namespace

SolidFit fit_solid(const PrecomputeRequest& request, LoadedProblem& loaded, StageLog& log) {
  const FitRequest& asked = *request.fit;
  Problem& problem = loaded.problem;
  SolidFit fit;
  FitProblem data;
  data.materials = problem.materials;
  data.measured = unwrap(read_measurements(asked.measured));
  data.unknowns = fit.unknowns = unwrap(read_unknowns(asked.unknowns, problem.materials));
  if (!asked.mass.empty()) data.mass = read_mass(asked.mass);
  StageLog quiet(true);
  Eigen::VectorXd hertz;
  data.solve = [&](const MaterialTable& materials) {
    problem.materials = materials;
    const ModeSensitivities found = solve_modes(request, loaded, quiet);
    hertz = found.squared_frequencies.cwiseSqrt() / (2.0 * std::numbers::pi);
    return model_of(found, problem);
  };
  log.begin("fit");
  Result<MaterialFit> made = fit_materials(data);
  if (!made) {
    made.error().message = "--fit " + asked.measured + ": " + made.error().message;
    throw Failure(made.error());
  }
  fit.materials = std::move(*made);
  problem.materials = fit.materials.materials;
  fit.damping = fit_damping(data.measured, fit.materials.modes, hertz);
  log.end(text("%d measured frequencies, %d solutions, chi^2 %.3g of %d",
               static_cast<int>(fit.materials.rows.size()), fit.materials.solves,
               fit.materials.chi_squared, fit.materials.freedom));
  return fit;
}

void print_sensitivities(const ModeSensitivities& found, const MaterialTable& materials) {
  std::fprintf(
      stderr,
      "  relative change of a frequency per relative change of E and density, and per unit "
      "of nu\n  mode          Hz      d ln E    d ln rho        d nu\n");
  for (Eigen::Index k = 0; k < found.squared_frequencies.size(); ++k) {
    const double squared = found.squared_frequencies[k];
    for (std::size_t m = 0; m < found.by.size(); ++m) {
      const ModeDerivatives& by = found.by[m];
      std::fprintf(stderr, "  %4d %11.5g %11.5f %11.5f %11.5f%s\n", static_cast<int>(k) + 1,
                   hertz(squared), 0.5 * by.by_log_stiffness[k] / squared,
                   0.5 * by.by_log_density[k] / squared, 0.5 * by.by_poisson[k] / squared,
                   materials.materials.size() == 1
                       ? ""
                       : ("  " + printable(materials.materials[m].name)).c_str());
    }
  }
  for (const Cluster& cluster : found.clusters)
    std::fprintf(stderr,
                 "  modes %d to %d have one frequency: their values are those into which each "
                 "constant splits it\n",
                 static_cast<int>(cluster.first) + 1,
                 static_cast<int>(cluster.first + cluster.count));
}

Json sensitivities_json(const ModeSensitivities& found, const MaterialTable& materials) {
  Json modes = Json::array();
  for (Eigen::Index k = 0; k < found.squared_frequencies.size(); ++k) {
    const double squared = found.squared_frequencies[k];
    Json mode{{"mode", k + 1}, {"frequency_hz", hertz(squared)}, {"equal_frequencies", 1}};
    for (const Cluster& cluster : found.clusters)
      if (k >= cluster.first && k < cluster.first + cluster.count)
        mode["equal_frequencies"] = cluster.count;
    mode["materials"] = Json::array();
    for (std::size_t m = 0; m < found.by.size(); ++m) {
      const ModeDerivatives& by = found.by[m];
      const Material& material = materials.materials[m].material;
      Json entry{{"region", materials.materials[m].name},
                 {"omega2_by_log_stiffness", by.by_log_stiffness[k]},
                 {"omega2_by_density", by.by_log_density[k] / material.density}};
      if (!material.orthotropic) {
        entry["omega2_by_young"] = by.by_log_stiffness[k] / material.young;
        entry["omega2_by_poisson"] = by.by_poisson[k];
      }
      mode["materials"].push_back(std::move(entry));
    }
    modes.push_back(std::move(mode));
  }
  return modes;
}

void print_fit(const SolidFit& fit) {
  const MaterialFit& found = fit.materials;
  for (std::size_t u = 0; u < fit.unknowns.size(); ++u) {
    const auto at = static_cast<Eigen::Index>(u);
    std::fprintf(stderr, "  %s: %s%s\n",
                 printable(name_of(fit.unknowns[u], found.materials)).c_str(),
                 with_deviation(found.values[at], found.deviations[at]).c_str(),
                 unit_of(fit.unknowns[u].constant));
  }
  const std::string warning = misfit_warning(found);
  if (!warning.empty()) std::fprintf(stderr, "  %s\n", warning.c_str());
  std::fprintf(stderr, "  mode    measured      fitted\n");
  for (const FittedRow& row : found.rows)
    std::fprintf(stderr, "  %4d %11.5g %11.5g Hz, %+.2f %%%s%s\n", row.mode + 1, row.measured,
                 row.fitted, 100.0 * (row.measured / row.fitted - 1.0),
                 row.equal > 1 ? text(", %d modes of this frequency", row.equal).c_str() : "",
                 row.ambiguous ? ", another mode is as near: name the mode in the file" : "");
  if (!fit.damping) return;
  const DampingFit& damping = *fit.damping;
  std::fprintf(stderr, "  alpha %s 1/s, beta %s s\n  --damping-ratio %s\n",
               damping.alpha.value == 0.0
                   ? "0"
                   : with_deviation(damping.alpha.value, damping.alpha.deviation).c_str(),
               damping.beta.value == 0.0
                   ? "0"
                   : with_deviation(damping.beta.value, damping.beta.deviation).c_str(),
               damping.ratios.c_str());
}

Json fit_json(const SolidFit& fit) {
  const MaterialFit& found = fit.materials;
  constexpr const char* kNames[] = {"young", "poisson", "density"};
  Json unknowns = Json::array(), rows = Json::array(), correlation = Json::array();
  for (std::size_t u = 0; u < fit.unknowns.size(); ++u) {
    const auto at = static_cast<Eigen::Index>(u);
    const FitUnknown& unknown = fit.unknowns[u];
    unknowns.push_back({{"constant", kNames[static_cast<std::size_t>(unknown.constant)]},
                        {"region", found.materials.materials[unknown.material].name},
                        {"value", found.values[at]},
                        {"standard_deviation", known(found.deviations[at])}});
    Json line = Json::array();
    for (Eigen::Index v = 0; v < found.correlation.cols(); ++v)
      line.push_back(known(found.correlation(at, v)));
    correlation.push_back(std::move(line));
  }
  for (const FittedRow& row : found.rows)
    rows.push_back({{"mode", row.mode + 1},
                    {"equal_frequencies", row.equal},
                    {"measured_hz", row.measured},
                    {"standard_deviation_hz", row.deviation > 0.0 ? Json(row.deviation) : Json()},
                    {"fitted_hz", row.fitted},
                    {"ambiguous", row.ambiguous}});
  Json json{{"unknowns", unknowns},
            {"correlation", correlation},
            {"frequencies", rows},
            {"chi_squared", found.chi_squared},
            {"degrees_of_freedom", found.freedom},
            {"deviations_given", found.absolute},
            {"solutions", found.solves},
            {"warning", misfit_warning(found).empty() ? Json() : Json(misfit_warning(found))},
            {"damping", nullptr}};
  if (!fit.damping) return json;
  const DampingFit& damping = *fit.damping;
  const auto constant = [](const Uncertain& value) {
    return Json{{"value", value.value},
                {"standard_deviation", value.deviation > 0.0 ? Json(value.deviation) : Json()}};
  };
  json["damping"] = {{"alpha", constant(damping.alpha)},      {"beta", constant(damping.beta)},
                     {"correlation", damping.correlation},    {"chi_squared", damping.chi_squared},
                     {"degrees_of_freedom", damping.freedom}, {"damping_ratio", damping.ratios}};
  return json;
}

}  // namespace tremolo
