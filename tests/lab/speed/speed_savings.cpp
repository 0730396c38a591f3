// Savings by leaving out parts that a scene does not need: one row for each, with and without.
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <random>

#include <fmt/format.h>

#include "common/packed_index.h"
#include "formats/basis/basis_reader.h"
#include "formats/basis/basis_writer.h"
#include "runtime/bodies/reduced/surface/surface.h"
#include "runtime/model.h"
#include "tests/lab/speed/speed.h"
#include "tests/lab/work/failure.h"

namespace tremolo::bench {
namespace {

constexpr std::size_t kModes = 30;

// value: with the saving; baseline: without.
void add_saving(SpeedSection& section, std::string what, double value, double baseline,
                const char* unit, std::string how) {
  section.rows.push_back({.what = std::move(what),
                          .value = value,
                          .unit = unit,
                          .baseline = baseline,
                          .note = std::move(how)});
}

// A model whose coefficients are all there and of no meaning: the time does not depend on them.
BasisData dense_data(std::size_t r) {
  std::mt19937 engine(6);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  BasisData data;
  data.vertex_count = 1;
  data.lambda = Eigen::VectorXd::LinSpaced(static_cast<Eigen::Index>(r), 100.0, 1e6);
  data.cubic.resize(triple_count(r));
  data.quartic.resize(quad_count(r));
  for (double& c : data.cubic) c = uniform(engine);
  for (double& c : data.quartic) c = uniform(engine);
  data.surface.vertex_ids = {0};
  data.surface.rest = {Eigen::Vector3d::Zero()};
  data.surface.rows = BasisRows::Zero(3, r);
  return data;
}

// Evaluation of `want` for a model that outlives it.
Work evaluation(const Model& model, unsigned want) {
  const Potential& potential = model.potential();
  return [&potential, want, q = Eigen::VectorXd::Constant(model.modes(), 1e-3).eval(),
          workspace = potential.make_workspace(), out = potential.make_evaluation()]() mutable {
    potential.evaluate(q, want, workspace, out);
  };
}

// Force and tangent of `modes` coordinates read these unique entries.
double coefficient_bytes(std::size_t modes) {
  return 8.0 * static_cast<double>(triple_count(modes) + quad_count(modes));
}

void add_evaluation_rows(SpeedSection& section) {
  const BasisData data = dense_data(kModes);
  const Model::Pointer full = or_fail(Model::from_data(data));
  const Model::Pointer half = or_fail(Model::from_data(data, {.modes = kModes / 2}));
  const Model::Pointer linear = or_fail(Model::from_data(data, {.linear = true}));
  constexpr unsigned kBoth = kWantForce | kWantTangent;
  std::vector<double> us =
      by_turns({evaluation(*full, kBoth | kWantEnergy), evaluation(*full, kBoth),
                evaluation(*full, kWantForce), evaluation(*full, kWantForce | kWantEnergy),
                evaluation(*half, kWantForce), evaluation(*linear, kWantForce)},
               60, 60);
  for (double& time : us) time *= 1e6;
  const double bytes = coefficient_bytes(kModes);
  add_saving(section, "force without tangent, r = 30", us[2], us[1], "us",
             "automatic: explicit methods ask for the force alone");
  add_saving(section, "force without energy, r = 30", us[2], us[3], "us",
             "automatic: energy is evaluated when Body::energy is called");
  add_saving(section, "force + tangent without energy, r = 30", us[1], us[0], "us",
             "automatic, as above");
  add_saving(section, "force of 15 of 30 coordinates", us[4], us[2], "us",
             "--modes 15, ModelOptions::modes");
  add_saving(section, "coefficients kept of 15 of 30 coordinates", coefficient_bytes(kModes / 2),
             bytes, "bytes", "--modes 15: the leading entries are a prefix");
  add_saving(section, "force of a linear scene, r = 30", us[5], us[2], "us",
             "run --linear, ModelOptions::linear");
  add_saving(section, "coefficients of the file read by a linear scene, r = 30", 0.0, bytes,
             "bytes",
             "run --linear does not read them; precompute --linear does not make them, nor the "
             "derivatives");
}

// Bytes of the file that this process has read: those that the kernel reports as mapped in. Zero
// where it says nothing.
double touched_bytes(const std::string& path) {
  std::ifstream maps("/proc/self/smaps");
  const std::string name = std::filesystem::absolute(path).lexically_normal().string();
  bool ours = false;
  double bytes = 0.0;
  for (std::string line; std::getline(maps, line);) {
    const bool header = line.find('-') < line.find(' ') && line.find(':') > line.find(' ');
    if (header) ours = line.ends_with(name);
    double kilobytes = 0.0;
    if (ours && std::sscanf(line.c_str(), "Rss: %lf kB", &kilobytes) == 1)
      bytes += 1024.0 * kilobytes;
  }
  return bytes;
}

// Loads a model; inside: a vertex to ask for then, or none.
Work loading(const std::string& path, const ModelOptions& options, VertexId inside = -1) {
  return [=] {
    const Model::Pointer model = or_fail(Model::load(path, options));
    if (inside >= 0) or_fail(model->vertex(inside));
  };
}

double section_bytes(const BasisReader& reader, std::initializer_list<std::string_view> names) {
  double bytes = 0.0;
  for (const BasisSection& section : reader.sections())
    if (std::find(names.begin(), names.end(), section.name) != names.end())
      bytes += static_cast<double>(section.size);
  return bytes;
}

void add_loading_rows(const std::string& path, SpeedSection& section) {
  namespace layout = basis_layout;
  const BasisReader reader = or_fail(BasisReader::open(path));
  const std::string name = std::filesystem::path(path).stem().string();
  const auto size = static_cast<double>(std::filesystem::file_size(path));
  const BasisData data = or_fail(read_basis(path));
  const VertexId inside = data.interior.vertex_ids.empty() ? -1 : data.interior.vertex_ids[0];

  // The reader has read the head of the file; the model maps it a second time.
  const double before = touched_bytes(path);
  const Model::Pointer model = or_fail(Model::load(path));
  const double touched = touched_bytes(path) - before;
  add_saving(section, name + ": bytes of the sections that loading reads",
             size - section_bytes(reader, {layout::kInteriorIds, layout::kInteriorRest,
                                           layout::kInteriorBasis, layout::kFixedIds,
                                           layout::kSingularValues, layout::kProvenance}),
             size, "bytes",
             fmt::format("automatic: a section is read on first use; the kernel has mapped in "
                         "{:.0f} bytes, in runs of pages",
                         touched));
  std::vector<double> us =
      by_turns({loading(path, {}), loading(path, {}, inside),
                [&] { or_fail(Model::from_data(or_fail(read_basis(path)))); },
                loading(path, {.linear = true}),
                loading(path, {.modes = static_cast<int>(data.lambda.size() / 2)})},
               1, 15);
  for (double& time : us) time *= 1e6;
  add_saving(section, name + ": loading without the rows inside", us[0], us[1], "us",
             "automatic: read when a vertex inside is asked for");
  add_saving(section, name + ": loading what is shown, not the whole file", us[0], us[2], "us",
             "automatic");
  add_saving(section, name + ": loading a linear scene", us[3], us[0], "us", "run --linear");
  add_saving(section, name + ": loading half of the coordinates", us[4], us[0], "us", "--modes");
  const double row_bytes = 8.0 * static_cast<double>(data.lambda.size());
  add_saving(section, name + ": rows of U in memory, the surface's alone",
             row_bytes * static_cast<double>(data.surface.rows.rows()),
             row_bytes * static_cast<double>(data.surface.rows.rows() + data.interior.rows.rows()),
             "bytes", "automatic, as above");
  const double display =
      static_cast<double>(make_surface_basis(data.surface, data.triangles).bytes());
  add_saving(section, name + ": rows for display of a model that is never shown", 0.0, display,
             "bytes", "automatic: made at the first float positions");
  const auto compact = or_fail(encode_basis(data, BasisEncoding::kCompact));
  add_saving(section, name + ": file", static_cast<double>(compact.size()), size, "bytes",
             "tremolo-precompute --encoding compact");
}

}  // namespace

SpeedSection measure_savings_speed(const Options& options, const MachineProbe&) {
  SpeedSection section;
  section.title = "What a scene does not need";
  section.text =
      "One row a saving: value is with it, the textbook column without it. Bodies at rest, "
      "vertices of bodies that did not move and coefficients that vanish by symmetry have their "
      "rows in the sections on many bodies and on the kernel. Times of loading are of a file in "
      "the cache.";
  add_evaluation_rows(section);
  const std::string model = options.models.empty() ? "horse" : options.models.front();
  const std::filesystem::path path =
      std::filesystem::path(options.models_dir) / (model + ".tremolo");
  add_loading_rows(path.string(), section);
  return section;
}

}  // namespace tremolo::bench
