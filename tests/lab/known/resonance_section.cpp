#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "runtime/integrator.h"
#include "tests/lab/known/known_answers.h"
#include "tests/lab/known/resonance.h"

namespace tremolo::known {
namespace {

using Json = nlohmann::json;

constexpr int kPoints = 1000;  // h omega = 0.01 .. 10
constexpr double kSpacing = 0.01;

// The methods whose step on a linear oscillator is stable for every h when the fast coordinate is
// implicit and the slow one explicit.
constexpr std::string_view kStable[] = {"midpoint",      "newmark", "imexv", "imexv-linear",
                                        "imexv-coupled", "avf",     "ep2",   "ep4"};

double product_at(int point) {
  return kSpacing * (point + 1);
}

// The spectral radius over h omega; not-a-number where a solve failed.
std::vector<double> stored_radii(const Store& store, std::string_view method) {
  const Json key = {
      {"experiment", "resonance"}, {"version", 1},      {"method", std::string(method)},
      {"k", kResonanceSlow},       {"points", kPoints}, {"spacing", kSpacing}};
  const Json json = store.get(fmt::format("known-resonance-{}", method), key, [&] {
    Json radii = Json::array();
    for (int point = 0; point < kPoints; ++point) {
      const auto map = linear_map(method, product_at(point), kResonanceSlow);
      radii.push_back(map ? Json(spectral_radius(*map)) : Json());
    }
    return radii;
  });
  std::vector<double> radii;
  for (const Json& value : json) radii.push_back(to_number(value));
  return radii;
}

// Interval just below n pi in which r-RESPA is unstable.
struct Tongue {
  double begin = 0.0;
  double radius = 1.0;
  double at = 0.0;
};

Tongue tongue_below(int n) {
  const double end = n * std::numbers::pi;
  Tongue tongue{.begin = end, .radius = 1.0, .at = end};
  for (double x = end; x > end - 1.0; x -= 1e-4) {
    const double radius = spectral_radius(respa_map(x, kResonanceSlow));
    if (radius > 1.0 + 1e-9) tongue.begin = x;
    if (radius > tongue.radius) tongue = {tongue.begin, radius, x};
  }
  return tongue;
}

// The table of r-RESPA's resonances. Its criterion is the control: they must be found.
Criterion add_tongues(Report& report) {
  Table table{{"n", "n pi", "unstable from h omega", "to", "largest radius", "at h omega"}, {}};
  double weakest = std::numeric_limits<double>::infinity();
  for (int n = 1; n <= 3; ++n) {
    const Tongue tongue = tongue_below(n);
    weakest = std::min(weakest, tongue.radius);
    const std::string end = cell(n * std::numbers::pi, 5);
    table.rows.push_back({std::to_string(n), end, cell(tongue.begin, 5), end,
                          cell(tongue.radius, 5), cell(tongue.at, 5)});
  }
  report.table(table, "Resonances of r-RESPA, closed form.", "known-resonance-respa.csv");
  return {
      "resonance, control: r-RESPA is unstable below pi, 2 pi and 3 pi; smallest of the three "
      "spectral radii",
      ">= 1.01", cell(weakest, 4), weakest >= 1.01};
}

Curve respa_curve() {
  Curve respa{.label = "r-RESPA", .colour = "#c0392b"};
  for (int point = 0; point < 4 * kPoints; ++point) {
    respa.x.push_back(0.25 * kSpacing * (point + 1));
    respa.y.push_back(spectral_radius(respa_map(respa.x.back(), kResonanceSlow)));
  }
  return respa;
}

// The largest radius of one method, less 1. A failed solve, not-a-number, counts as the largest.
struct Top {
  std::string method;
  double excess = 0.0;
  double at = 0.0;                 // h omega
  std::optional<double> unstable;  // the first h omega with a radius above 1
};

Top top_of(std::string_view method, const std::vector<double>& radii) {
  const auto product = [&](auto place) {
    return product_at(static_cast<int>(place - radii.begin()));
  };
  const auto top = std::ranges::max_element(
      radii, [](double a, double b) { return !std::isnan(a) && (std::isnan(b) || a < b); });
  const auto unstable = std::ranges::find_if(radii, [](double r) { return !(r <= 1.0 + 1e-8); });
  Top result{std::string(method), *top - 1.0, product(top), {}};
  if (unstable != radii.end()) result.unstable = product(unstable);
  return result;
}

Criterion worst_of(const std::vector<Top>& tops) {
  Top worst;
  for (const Top& top : tops)
    if (std::ranges::count(kStable, top.method) > 0 && !(top.excess <= worst.excess)) worst = top;
  return at_most(
      "resonance: largest spectral radius - 1 of the methods with an implicit fast part, h omega "
      "<= 10",
      worst.excess, 1e-8, worst.method);
}

}  // namespace

std::vector<Criterion> add_resonance_section(const Experiments& experiments) {
  Report& report = experiments.report;
  report.section("Known answers: linear resonance");
  report.paragraph(
      "q'' = -(omega^2 + k) q with omega = 1, k = 0.03: the fast part and a slow pull. The impulse "
      "method (r-RESPA) turns the fast part exactly and kicks with the slow one; its closed form "
      "is unstable just below every h omega = n pi. The other curves are the integrators "
      "themselves, run for one step from two tiny displacements: the model is V = q^2/2 + k s^2 "
      "q^2/2 with a slow coordinate s that stands at 1 (a model's quadratic part is one diagonal, "
      "so that the pull has to come from the quartic part to stand on the slow side of the split). "
      "s is explicit, q implicit: `imexv-linear` kicks with the k and takes omega^2 by the "
      "midpoint rule, which turns by less than pi a step. Its own limit is that of the kick, h "
      "sqrt(k) = 2, here at h omega = 11.5.");
  std::vector<Criterion> criteria{add_tongues(report)};
  Chart chart{.title = "one step: the larger |eigenvalue|",
              .x_label = "h omega",
              .y_label = "spectral radius",
              .x_range = {{0.0, 10.0}},
              .y_range = {{0.97, 1.2}},
              .curves = {respa_curve()}};
  Table table{{"method", "largest radius - 1 on (0, 10]", "at h omega", "unstable from h omega"},
              {}};
  std::vector<Top> tops;
  for (const std::string_view method : integrator_names()) {
    const std::vector<double> radii = stored_radii(experiments.store, method);
    tops.push_back(top_of(method, radii));
    const Top& top = tops.back();
    table.rows.push_back({top.method, cell(top.excess, 3), cell(top.at),
                          top.unstable ? cell(*top.unstable) : "never"});
    if (method != "imexv-linear" && method != "ep4" && method != "verlet") continue;
    Curve curve{.label = top.method, .y = radii};
    for (int point = 0; point < kPoints; ++point) curve.x.push_back(product_at(point));
    if (method == "ep4") curve.style = CurveStyle::kDashes;  // lies on imexv-linear
    chart.curves.push_back(std::move(curve));
  }
  report.table(table, "Each method on the same split. A difference from 1 below 1e-10 is rounding.",
               "known-resonance.csv");
  report.figure({chart}, 1, 380,
                "r-RESPA leaves 1 in tongues below n pi that widen with h; the methods with an "
                "implicit fast part stay at 1; `imexv-linear` and `ep4` stand for all of them.");
  criteria.push_back(worst_of(tops));
  return criteria;
}

}  // namespace tremolo::known
