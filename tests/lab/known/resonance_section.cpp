#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "runtime/integrator.h"
#include "tests/lab/known/resonance.h"
#include "tests/lab/known/sections.h"
#include "tests/lab/report/chart.h"

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
Result<std::vector<double>> stored_radii(const SectionContext& context, std::string_view method) {
  const Json key = {
      {"experiment", "resonance"}, {"version", 1},      {"method", std::string(method)},
      {"k", kResonanceSlow},       {"points", kPoints}, {"spacing", kSpacing}};
  const Result<Json> json =
      context.store.get(fmt::format("known-resonance-{}", method), key, [&]() -> Result<Json> {
        Json radii = Json::array();
        for (int point = 0; point < kPoints; ++point) {
          const auto map = linear_map(method, product_at(point), kResonanceSlow);
          if (!map) return map.error();
          radii.push_back(*map ? Json(spectral_radius(**map)) : Json());
        }
        return radii;
      });
  if (!json) return json.error();
  std::vector<double> radii;
  for (const Json& value : *json) radii.push_back(to_number(value));
  return radii;
}

// Where r-RESPA is unstable just below n pi.
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

}  // namespace

Criteria add_resonance_section(const SectionContext& context) {
  context.page.section("Known answers: linear resonance");
  context.page.paragraph(
      "q'' = -(omega^2 + k) q with omega = 1, k = 0.03: the fast part and a slow pull. The impulse "
      "method (r-RESPA) turns the fast part exactly and kicks with the slow one; its closed form "
      "is "
      "unstable just below every h omega = n pi. The other curves are the integrators themselves, "
      "run for one step from two tiny displacements: the model is V = q^2/2 + k s^2 q^2/2 with a "
      "slow "
      "coordinate s that stands at 1 (a model's quadratic part is one diagonal, so that the pull "
      "has to come from the quartic part to stand on the slow side of the split). s is explicit, q "
      "implicit: `imexv-linear` kicks with the k and takes omega^2 by the midpoint rule, which "
      "turns "
      "by less than pi a step. Its own limit is that of the kick, h sqrt(k) = 2, here at h omega = "
      "11.5.");
  std::vector<Criterion> criteria;
  Table tongues{{"n", "n pi", "unstable from h omega", "to", "largest radius", "at h omega"}, {}};
  double weakest = std::numeric_limits<double>::infinity();
  for (int n = 1; n <= 3; ++n) {
    const Tongue tongue = tongue_below(n);
    weakest = std::min(weakest, tongue.radius);
    tongues.rows.push_back({std::to_string(n), cell(n * std::numbers::pi, 5), cell(tongue.begin, 5),
                            cell(n * std::numbers::pi, 5), cell(tongue.radius, 5),
                            cell(tongue.at, 5)});
  }
  if (Status s = add_table(context, tongues, "known-resonance-respa.csv",
                           "Resonances of r-RESPA, closed form.");
      !s)
    return s.error();
  criteria.push_back(
      {"resonance, control: r-RESPA is unstable below pi, 2 pi and 3 pi; smallest of "
       "the three spectral radii",
       ">= 1.01", cell(weakest, 4), weakest >= 1.01});

  Chart chart{.title = "one step: the larger |eigenvalue|",
              .x_label = "h omega",
              .y_label = "spectral radius"};
  chart.x_range = {0.0, 10.0};
  chart.y_range = {0.97, 1.2};
  Curve respa{
      .label = "r-RESPA", .x = {}, .y = {}, .style = CurveStyle::kLines, .colour = "#c0392b"};
  for (int point = 0; point < 4 * kPoints; ++point) {
    respa.x.push_back(0.25 * kSpacing * (point + 1));
    respa.y.push_back(spectral_radius(respa_map(respa.x.back(), kResonanceSlow)));
  }
  chart.curves.push_back(respa);
  Table table{{"method", "largest radius - 1 on (0, 10]", "at h omega", "unstable from h omega"},
              {}};
  double worst = 0.0;
  std::string worst_method;
  for (const std::string_view method : integrator_names()) {
    const Result<std::vector<double>> radii = stored_radii(context, method);
    if (!radii) return radii.error();
    Curve curve{.label = std::string(method),
                .x = {},
                .y = *radii,
                .style = CurveStyle::kLines,
                .colour = {}};
    for (int point = 0; point < kPoints; ++point) curve.x.push_back(product_at(point));
    // A failed solve, not-a-number, counts as the worst.
    const auto top = std::max_element(radii->begin(), radii->end(), [](double a, double b) {
      return !std::isnan(a) && (std::isnan(b) || a < b);
    });
    const auto unstable =
        std::find_if(radii->begin(), radii->end(), [](double r) { return !(r <= 1.0 + 1e-8); });
    table.rows.push_back({std::string(method), cell(*top - 1.0, 3),
                          cell(product_at(static_cast<int>(top - radii->begin()))),
                          unstable == radii->end()
                              ? "never"
                              : cell(product_at(static_cast<int>(unstable - radii->begin())))});
    if (std::ranges::count(kStable, method) > 0 && !(*top - 1.0 <= worst)) {
      worst = *top - 1.0;
      worst_method = method;
    }
    if (method == "ep4") curve.style = CurveStyle::kDashes;  // lies on imexv-linear
    if (method == "imexv-linear" || method == "ep4" || method == "verlet")
      chart.curves.push_back(std::move(curve));
  }
  if (Status s = add_table(context, table, "known-resonance.csv",
                           "Each method on the same split. A difference from 1 below 1e-10 is "
                           "rounding.");
      !s)
    return s.error();
  const Result<std::string> svg = draw_svg({chart}, 1, 900, 380);
  if (!svg) return svg.error();
  context.page.figure(
      *svg,
      "r-RESPA leaves 1 in tongues below n pi that widen with h; the methods "
      "with an implicit fast part stay at 1; `imexv-linear` and `ep4` stand for all of them.");
  criteria.push_back(
      at_most("resonance: largest spectral radius - 1 of the methods with an "
              "implicit fast part, h omega <= 10",
              worst, 1e-8, worst_method));
  return criteria;
}

}  // namespace tremolo::known
