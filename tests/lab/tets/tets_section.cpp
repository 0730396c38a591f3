#include "tests/lab/tets/tets_section.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "runtime/apps/tremolo/output/tell.h"
#include "tests/lab/tets/body_runs.h"

namespace tremolo::tets {
namespace {

constexpr int kBarCells[] = {1, 2, 3, 4};
constexpr int kLinearCells[] = {6, 8};  // so that linear bars take as long as fine quadratic ones
constexpr int kReferenceCells = 5;
constexpr double kYoungs[] = {2e5, 1e6};  // Pa
constexpr double kMushroomYoung = 2e6, kCoilYoung = 2e7;
constexpr double kErrors[] = {0.2, 0.1, 0.05, 0.02};
constexpr double kDefaultError = 0.05;
constexpr double kEqualLook = 0.002;

// One row of the table. error: against the reference, not a number where there is none; look,
// ratio: distance from, and time over that of, the fully quadratic run of the same mesh.
struct Row {
  BodyCase what;
  BodyRun run;
  double error = std::numeric_limits<double>::quiet_NaN();
  double look = std::numeric_limits<double>::quiet_NaN(), ratio = look;
};

std::string edges_name(const BodyCase& c) {
  if (c.kind == DegreeKind::kAdaptive) return fmt::format("adaptive, {:g} %", 100.0 * c.error);
  return c.kind == DegreeKind::kLinear ? "linear" : "quadratic";
}

double size_of(ShapeKind kind) {
  return make_shape(kind, 1).size;
}

// Short runs are repeated more often.
int turns_of(const std::vector<BodyCase>& cases) {
  return cases.front().shape == ShapeKind::kBar && cases.front().cells <= 2 ? 9 : 3;
}

std::vector<Row> stored_rows(const Store& store, const std::vector<BodyCase>& cases, int turns) {
  const BodyCase& first = cases.front();
  std::string edges;
  for (const BodyCase& c : cases) edges += (edges.empty() ? "" : "; ") + edges_name(c);
  const nlohmann::json key = {
      {"experiment", "tets"}, {"version", 4},         {"shape", shape_name(first.shape)},
      {"cells", first.cells}, {"young", first.young}, {"edges", edges},
      {"turns", turns},       {"steps", kRunSteps},   {"step", kRunStep}};
  const std::string name = fmt::format("tets-{}-{}-{:.0f}-{}", shape_name(first.shape), first.cells,
                                       first.young, cases.size());
  tell("tremolo: {} of {} cells, {:g} Pa: {}\n", shape_name(first.shape), first.cells, first.young,
       edges);
  BodyRuns group = store.get_as<BodyRuns>(name, key, [&] { return run_by_turns(cases, turns); });
  std::vector<Row> rows;
  for (std::size_t i = 0; i < cases.size(); ++i)
    rows.push_back({cases[i], std::move(group.runs[i])});
  return rows;
}

// Quadratic, linear and adaptive edges on one mesh.
std::vector<Row> mesh_rows(const Store& store, ShapeKind shape, int cells, double young) {
  std::vector<BodyCase> cases = {{shape, cells, young, DegreeKind::kQuadratic},
                                 {shape, cells, young, DegreeKind::kLinear}};
  for (const double error : kErrors)
    cases.push_back({shape, cells, young, DegreeKind::kAdaptive, error});
  std::vector<Row> rows = stored_rows(store, cases, turns_of(cases));
  const double size = size_of(shape);
  for (Row& row : rows) {
    row.look = run_distance(row.run, rows.front().run, size);
    row.ratio = middle_ratio(row.run, rows.front().run);
  }
  return rows;
}

std::vector<Row> bar_rows(const Store& store, double young) {
  const BodyRun reference =
      stored_rows(store, {{ShapeKind::kBar, kReferenceCells, young, DegreeKind::kQuadratic}}, 1)
          .front()
          .run;
  std::vector<Row> rows;
  for (const int cells : kBarCells)
    for (Row& row : mesh_rows(store, ShapeKind::kBar, cells, young)) rows.push_back(std::move(row));
  for (const int cells : kLinearCells)
    rows.push_back(
        stored_rows(store, {{ShapeKind::kBar, cells, young, DegreeKind::kLinear}}, 1).front());
  for (Row& row : rows) row.error = run_distance(row.run, reference, size_of(ShapeKind::kBar));
  return rows;
}

// The error of linear elements at the same time a step, between their meshes on straight lines of
// logarithms; outside of them that of the nearest.
double linear_error_at(const std::vector<Row>& rows, double seconds) {
  std::vector<std::pair<double, double>> curve;
  for (const Row& row : rows)
    if (row.what.kind == DegreeKind::kLinear)
      curve.emplace_back(std::log(middle_time(row.run)), std::log(row.error));
  const double t = std::log(seconds);
  if (t <= curve.front().first) return std::exp(curve.front().second);
  for (std::size_t i = 1; i < curve.size(); ++i) {
    const auto& [t0, e0] = curve[i - 1];
    const auto& [t1, e1] = curve[i];
    if (t <= t1) return std::exp(e0 + (e1 - e0) * (t - t0) / (t1 - t0));
  }
  return std::exp(curve.back().second);
}

void add_rows(const std::vector<Row>& rows, Table& table) {
  for (const Row& row : rows)
    table.rows.push_back(
        {shape_name(row.what.shape), cell(row.what.young), cell(row.run.elements),
         edges_name(row.what), cell(1e3 * middle_time(row.run) / kRunSteps, 3), cell(row.ratio, 3),
         cell(100.0 * row.run.share, 3), cell(100.0 * row.run.bent, 3), cell(100.0 * row.error, 3),
         cell(100.0 * row.look, 3), cell(row.run.switched), cell(row.run.switch_energy, 2),
         cell(1e-6 * row.run.bytes, 3), cell(row.run.failed)});
}

// The fastest threshold that looks equal on the rows' last mesh with adaptive edges.
Criterion saving(const std::vector<Row>& rows, const std::string& what, double bound) {
  int cells = 0;
  for (const Row& row : rows)
    if (row.what.kind == DegreeKind::kAdaptive) cells = row.what.cells;
  double best = std::numeric_limits<double>::infinity();
  std::string who = "no threshold looks equal";
  for (const Row& row : rows) {
    if (row.what.cells != cells || row.what.kind != DegreeKind::kAdaptive) continue;
    if (row.look > kEqualLook || row.ratio >= best) continue;
    best = row.ratio;
    who = fmt::format("{}, {:.3g} % off", edges_name(row.what), 100.0 * row.look);
  }
  return at_most(what +
                     ": time of adaptive edges over quadratic ones where the surface is at most "
                     "0.2 % off theirs",
                 best, bound, who);
}

Criterion accuracy(const std::vector<Row>& rows) {
  double worst = std::numeric_limits<double>::infinity();
  std::string who;
  for (const Row& row : rows) {
    if (row.what.kind != DegreeKind::kAdaptive || row.what.error != kDefaultError) continue;
    const double ratio = linear_error_at(rows, middle_time(row.run)) / row.error;
    if (ratio >= worst) continue;
    worst = ratio;
    who = fmt::format("{:.0f} elements", row.run.elements);
  }
  return {fmt::format("bar, {:g} Pa: error of linear elements over that of adaptive ones (5 %) at "
                      "equal time, the smallest of the meshes",
                      rows.front().what.young),
          ">= 5", fmt::format("{:.3g} ({})", worst, who), worst >= 5.0};
}

Criterion never_slower(const std::vector<Row>& rows) {
  double worst = 0.0;
  std::string who;
  for (const Row& row : rows) {
    if (row.what.kind != DegreeKind::kAdaptive || row.ratio <= worst) continue;
    worst = row.ratio;
    who = fmt::format("{}, {:.0f} elements, {:g} Pa, {}", shape_name(row.what.shape),
                      row.run.elements, row.what.young, edges_name(row.what));
  }
  return at_most(
      "all bodies and thresholds: time of adaptive edges over quadratic ones, the "
      "largest",
      worst, 1.05, who);
}

void add_text(Report& report) {
  report.section("Bodies of tetrahedra whose edges choose their degree");
  report.paragraph(fmt::format(
      "Bodies held at one end fall under their own weight for {} steps of 1/60 s, `bdf2`: a bar "
      "that bends along all of its length, a mushroom of whose elements three quarters are a cap "
      "that does not bend, and a coil, curved at rest, that twists everywhere. Error: of 17 x 3 x "
      "3 points over all steps, root mean square, in % of the length, against a quadratic bar of "
      "{} x {} x {} cells; look: that of points of the surface against the quadratic body of the "
      "same mesh. The percentage behind `adaptive` is `error`, of the energy that deforms the "
      "body. "
      "Bent: edges whose control point is off the mean of its ends by more than 0.1 % of their "
      "length, the mean over the steps.",
      kRunSteps, 4 * kReferenceCells, kReferenceCells, kReferenceCells));
}

}  // namespace

std::vector<Criterion> add_tets_section(Report& report, const Store& store) {
  add_text(report);
  std::vector<Row> all;
  std::vector<Criterion> criteria;
  for (const double young : kYoungs) {
    std::vector<Row> rows = bar_rows(store, young);
    criteria.push_back(saving(rows, fmt::format("fine bar, {:g} Pa", young), 0.75));
    criteria.push_back(accuracy(rows));
    std::move(rows.begin(), rows.end(), std::back_inserter(all));
  }
  std::vector<Row> mushroom = mesh_rows(store, ShapeKind::kMushroom, 2, kMushroomYoung);
  criteria.push_back(saving(mushroom, "mushroom", 0.6));
  criteria.push_back(at_most("mushroom, quadratic: share of edges that bend",
                             mushroom.front().run.bent, 1.0 / 3.0, {}, "1/3"));
  std::move(mushroom.begin(), mushroom.end(), std::back_inserter(all));
  std::vector<Row> coil = mesh_rows(store, ShapeKind::kCoil, 1, kCoilYoung);
  std::move(coil.begin(), coil.end(), std::back_inserter(all));
  criteria.push_back(never_slower(all));
  Table table{{"body", "E, Pa", "elements", "edges", "ms a step", "over quadratic", "% quadratic",
               "% bent", "error, %", "look, %", "switches", "J taken", "MB", "not solved"},
              {}};
  add_rows(all, table);
  report.table(table,
               "Processor time of one thread, the middle one of several turns; cases of one mesh "
               "were run by turns, `over quadratic` is the middle one of the turns' ratios.",
               "tets.csv", 3);
  report.criteria(criteria);
  return criteria;
}

}  // namespace tremolo::tets
