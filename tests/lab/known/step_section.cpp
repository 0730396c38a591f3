#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "tests/lab/known/known_answers.h"
#include "tests/lab/known/step_properties.h"

namespace tremolo::known {

template <class Archive>
void fields(Archive& archive, StepProperties& properties) {
  archive("defect", properties.defect, "reversal", properties.reversal, "energy", properties.energy,
          "order", properties.order, "errors", properties.order_errors);
}

namespace {

using Json = nlohmann::json;

constexpr double kTestedStep = 3e-3;   // s
constexpr double kOrderStep = 2.5e-4;  // s, the coarsest of the four

// Bounds of a promised zero. The Jacobian is good to 1e-13 (its own line in the table), J^T Omega J
// doubles that a few times; a solve at the tolerance 1e-13 adds as much.
constexpr double kDefectBound = 1e-11;
constexpr double kReversalBound = 1e-11;
constexpr double kEnergyBound = 1e-12;
constexpr double kOrderSlack = 0.2;

StepProperties stored_properties(const Store& store, std::string_view method) {
  const Json key = {{"experiment", "step"},
                    {"version", 2},
                    {"method", std::string(method)},
                    {"step", kTestedStep},
                    {"order_step", kOrderStep}};
  StepProperties properties =
      store.get_as<StepProperties>(fmt::format("known-step-{}", method), key,
                                   [&] { return measure_step(method, kTestedStep, kOrderStep); });
  properties.method = method;
  return properties;
}

std::string text(const std::optional<double>& value, int digits) {
  return value ? cell(*value, digits) : "failed";
}

// The worst of a promised zero over all methods that promise it; a failed solve is the worst.
struct Worst {
  double value = 0.0;
  std::string method;
  void see(const std::optional<double>& measured, const std::string& who) {
    const double now = measured.value_or(std::numeric_limits<double>::quiet_NaN());
    if (!std::isnan(value) && !(now < value)) {
      value = now;
      method = who;
    }
  }
};

Criterion order_criterion(const StepProperties& properties, int promised) {
  Criterion criterion;
  criterion.what = fmt::format("order of {} on the strongly nonlinear chain", properties.method);
  criterion.bound = fmt::format(">= {:.1f} (theory: {})", promised - kOrderSlack, promised);
  criterion.measured = text(properties.order, 4);
  criterion.met = properties.order && *properties.order >= promised - kOrderSlack;
  return criterion;
}

std::vector<std::string> properties_row(const StepProperties& properties,
                                        const std::optional<Promise>& promise) {
  const auto promised = [&](bool Promise::*what) {
    return !promise ? "?" : (*promise).*what ? "yes" : "-";
  };
  std::vector<std::string> row = {properties.method,
                                  promised(&Promise::symplectic),
                                  text(properties.defect, 2),
                                  promised(&Promise::reversible),
                                  text(properties.reversal, 2),
                                  promised(&Promise::energy),
                                  text(properties.energy, 2),
                                  promise ? std::to_string(promise->order) : "?",
                                  text(properties.order, 3)};
  for (std::size_t k = 0; k < 4; ++k)
    row.push_back(k < properties.order_errors.size() ? cell(properties.order_errors[k], 3) : "");
  return row;
}

// explicit Euler's defect is the control: it must be found.
std::vector<Criterion> judge(const std::vector<StepProperties>& measured) {
  Worst defect, reversal, energy;
  std::optional<double> euler_defect;
  std::vector<Criterion> criteria, orders;
  for (const StepProperties& one : measured) {
    const std::optional<Promise> promise = promise_of(one.method);
    if (!promise) continue;
    if (promise->symplectic) defect.see(one.defect, one.method);
    if (promise->reversible) reversal.see(one.reversal, one.method);
    if (promise->energy) energy.see(one.energy, one.method);
    if (one.method == "explicit-euler") euler_defect = one.defect;
    orders.push_back(order_criterion(one, promise->order));
  }
  criteria.push_back(at_most("largest symplecticity defect of the methods that promise none",
                             defect.value, kDefectBound, defect.method));
  if (euler_defect)
    criteria.push_back({"symplecticity defect, control: explicit Euler's is found", ">= 0.001",
                        cell(*euler_defect, 3), *euler_defect >= 1e-3});
  criteria.push_back(at_most("largest reversal error of the methods that promise none",
                             reversal.value, kReversalBound, reversal.method));
  if (!energy.method.empty())
    criteria.push_back(at_most("largest energy error of one step of the methods that promise none",
                               energy.value, kEnergyBound, energy.method));
  criteria.insert(criteria.end(), orders.begin(), orders.end());
  return criteria;
}

}  // namespace

std::vector<Criterion> add_step_section(const Experiments& experiments) {
  Report& report = experiments.report;
  report.section("Known answers: what one step keeps, and the order");
  report.paragraph(fmt::format(
      "Three unit masses on four one-dimensional StVK bars, pressed by up to 40 %, h = 3 ms (h "
      "omega = 0.69, 1.3, 2.1), no load, no damping, tolerance 1e-13; the splitting methods take "
      "the first two coordinates explicitly. Defect: the largest entry of |J^T Omega J - Omega|, J "
      "the derivative of one step. J comes from central differences of eighth order: the "
      "integrators compute in doubles, a complex step cannot pass through them. Against the closed "
      "form of Verlet's J they are off by {:.1e} at small and {:.1e} at this amplitude. Reversal: "
      "|z after step, p -> -p, step, p -> -p minus z| / |z|. Energy: |H1 - H0| / H0 of one step. "
      "Order: fit of the error at h, h/2, h/4, h/8 with h = 0.25 ms after 8 ms, against classical "
      "Runge-Kutta with 512 times smaller steps. All in variables scaled by sqrt(omega_2). \"yes\" "
      "and \"-\" say what theory promises.",
      jacobian_accuracy(kTestedStep, 1e-6), jacobian_accuracy(kTestedStep, 1.0)));

  Table table{{"method", "symplectic", "defect", "reversible", "reversal", "keeps H", "energy",
               "order promised", "order", "error h", "h/2", "h/4", "h/8"},
              {}};
  std::vector<StepProperties> measured;
  for (const std::string_view method : integrator_names()) {
    measured.push_back(stored_properties(experiments.store, method));
    table.rows.push_back(properties_row(measured.back(), promise_of(method)));
  }
  report.table(table, "One step of each method.", "known-steps.csv");
  return judge(measured);
}

}  // namespace tremolo::known
