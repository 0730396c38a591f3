#include "runtime/apps/tremolo/run/recorder.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <span>
#include <utility>

#include <fmt/format.h>

#include "common/processor.h"
#include "formats/file/atomic_file.h"
#include "formats/surface/surface_writer.h"
#include "runtime/apps/tremolo/run/run_files.h"
#include "runtime/scene/selection.h"

namespace tremolo {

void look_at(const Body& body, Moment& moment) {
  moment.steps = body.steps();
  moment.time = body.time();
  moment.state.q = body.state().q;
  moment.state.p.resize(moment.state.q.size());
  body.integrator().synchronized_momentum(body.state(), moment.state.p);
  moment.work = body.work();
  moment.dissipated = body.dissipated();
  moment.iterations = body.iterations();
  moment.halved_steps = body.halved_steps();
  moment.loaded = body.load_to_come();
  moment.split = body.integrator().split();
  moment.bound = body.energy_bound();
}

March::March(Body& body, std::size_t block)
    : body_(body), moments_(std::max<std::size_t>(block, 1)) {
  for (Moment& moment : moments_) look_at(body, moment);
}

std::span<const Moment> March::advance(std::int64_t last) {
  std::size_t made = 0;
  const double before = processor_time();
  while (made < moments_.size() && body_.steps() < last && !failed_) {
    const StepReport report = body_.step();
    ++tried_;
    if (report.converged)
      look_at(body_, moments_[made++]);
    else
      failed_ = report;
  }
  seconds_ += processor_time() - before;
  return std::span(moments_).first(made);
}

double March::microseconds_per_step() const {
  return 1e6 * seconds_ / static_cast<double>(std::max<std::int64_t>(tried_, 1));
}

namespace {

bool read_index(std::string_view text, int& value) {
  const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc{} && stop == text.data() + text.size() && value >= 0;
}

// The vertices of ids and selectors, each once, in the order named.
Result<std::vector<int>> probes_of(const std::vector<std::string>& texts, const Model& model) {
  std::vector<int> probes;
  for (const std::string& text : texts) {
    const Result<std::vector<VertexId>> vertices = vertices_of(text, model);
    if (!vertices) return Error{vertices.error().kind, "--probe: " + vertices.error().message};
    for (const VertexId id : *vertices)
      if (std::find(probes.begin(), probes.end(), id) == probes.end()) probes.push_back(id);
  }
  return probes;
}

}  // namespace

Result<std::vector<int>> coordinates_of(const std::vector<std::string>& texts, Eigen::Index modes) {
  std::vector<int> coordinates;
  for (const std::string& text : texts) {
    int first = 0, last = static_cast<int>(modes) - 1;
    const std::size_t dash = text.find('-', 1);
    const bool good =
        text == "all" || (dash == std::string::npos ? read_index(text, first)
                                                    : read_index(text.substr(0, dash), first) &&
                                                          read_index(text.substr(dash + 1), last));
    if (!good || first > last)
      return usage_error("coordinate '" + text + "': expected a number, a range as in 0-5, or all");
    if (text != "all" && dash == std::string::npos) last = first;
    if (last >= modes)
      return content_error(
          fmt::format("coordinate {}: the model has {}, counted from 0", last, modes));
    for (int i = first; i <= last; ++i)
      if (std::find(coordinates.begin(), coordinates.end(), i) == coordinates.end())
        coordinates.push_back(i);
  }
  return coordinates;
}

Result<RecordedColumns> recorded_columns(const SceneColumns& columns, const Model& model) {
  RecordedColumns recorded;
  recorded.velocities = columns.velocities;
  if (Status s = take(recorded.coordinates, coordinates_of(columns.coordinates, model.modes())); !s)
    return s.error();
  if (Status s = take(recorded.probes, probes_of(columns.probes, model)); !s) return s.error();
  return recorded;
}

namespace {

constexpr std::size_t kPiece = std::size_t{1} << 16;  // bytes; a write a few hundred rows

}  // namespace

Result<Recorder> Recorder::create(const Model& model, const RecordedColumns& columns,
                                  const std::string& path, bool parked) {
  Recorder recorder;
  recorder.parked_ = parked;
  recorder.columns_ = columns;
  recorder.text_ = "t,kinetic,potential,total,high_band,work,dissipated";
  for (const std::string& name : columns.further) recorder.text_ += ',' + name;
  for (const int i : columns.coordinates) recorder.text_ += fmt::format(",q{}", i);
  if (columns.velocities)
    for (const int i : columns.coordinates) recorder.text_ += fmt::format(",p{}", i);
  for (const int vertex : columns.probes) {
    Result<VertexRows> rows = model.vertex(vertex);
    if (!rows) return rows.error();
    recorder.text_ += fmt::format(",u{0}x,u{0}y,u{0}z", vertex);
    if (columns.velocities) recorder.text_ += fmt::format(",v{0}x,v{0}y,v{0}z", vertex);
    recorder.probes_.push_back({vertex, std::move(rows->rows)});
  }
  recorder.text_ += '\n';
  if (path.empty()) return recorder;
  Result<AtomicFile> file = AtomicFile::create(path);
  if (!file) return file.error();
  recorder.file_.emplace(std::move(*file));
  if (parked) recorder.file_->park();
  return recorder;
}

Status Recorder::record(const Moment& moment, const Energy& energy,
                        std::span<const double> further) {
  if (!file_) return Success{};
  auto out = std::back_inserter(text_);
  fmt::format_to(out, "{:.9g},{:.10g},{:.10g},{:.12g},{:.10g},{:.10g},{:.10g}", moment.time,
                 energy.kinetic, energy.potential, energy.total(), energy.high_band, moment.work,
                 moment.dissipated);
  for (const double value : further) fmt::format_to(out, ",{:.12g}", value);
  const auto& [q, p] = moment.state;
  for (const int i : columns_.coordinates) fmt::format_to(out, ",{:.10g}", q[i]);
  if (columns_.velocities)
    for (const int i : columns_.coordinates) fmt::format_to(out, ",{:.10g}", p[i]);
  for (const Probe& probe : probes_) {
    const Eigen::Vector3d u = probe.rows * q;
    fmt::format_to(out, ",{:.8g},{:.8g},{:.8g}", u.x(), u.y(), u.z());
    if (!columns_.velocities) continue;
    const Eigen::Vector3d v = probe.rows * p;
    fmt::format_to(out, ",{:.8g},{:.8g},{:.8g}", v.x(), v.y(), v.z());
  }
  text_ += '\n';
  return text_.size() < kPiece ? Status(Success{}) : flush();
}

Status Recorder::flush() {
  if (!file_ || text_.empty()) return Success{};
  const Status status = file_->write(text_);
  text_.clear();
  if (parked_) file_->park();
  return status;
}

Status Recorder::finish() {
  if (!file_) return Success{};
  if (Status status = flush(); !status) return status;
  return file_->commit();
}

namespace {

namespace fs = std::filesystem;

// The author's surface where the body is now.
Status write_render_shape(const Body& body, const std::string& path, const std::string& materials) {
  RenderSurface surface = body.model().render()->surface;
  const std::size_t count = 3 * surface.vertices.size();
  surface.normals.resize(surface.vertices.size());
  std::vector<float> positions(count);  // of the normals; those that are written are exact
  const Status normals = body.surface(positions, std::span(surface.normals[0].data(), count));
  if (!normals) return normals;
  const Status exact = body.surface_positions(std::span<double>(surface.vertices[0].data(), count));
  if (!exact) return exact;
  return write_render_surface(path, surface, materials);
}

}  // namespace

Status write_shape(const Body& body, const std::string& path, const std::string& materials) {
  if (body.model().render() != nullptr) return write_render_shape(body, path, materials);
  SurfaceMesh surface;
  surface.vertices.resize(body.model().surface().vertex_ids.size());
  surface.triangles = body.model().triangles();
  // Eigen's fixed-size vectors are contiguous.
  const std::span<double> flat(surface.vertices.empty() ? nullptr : surface.vertices[0].data(),
                               3 * surface.vertices.size());
  if (Status status = body.surface_positions(flat); !status) return status;
  return write_surface(path, surface);
}

bool Frames::due(std::int64_t steps) const {
  if (written_ >= outputs_.surfaces) return false;
  return steps >= std::llround(static_cast<double>(steps_) * (written_ + 1) / outputs_.surfaces);
}

Status Frames::keep(const std::string& path, Status status) {
  if (status) files_.push_back(path);
  return status;
}

Status Frames::write(const Body& body, double time) {
  const std::string name = frame_name(written_, time, outputs_.surface_format);
  const std::string path = (fs::path(outputs_.out) / name).string();
  list_ += fmt::format("{},{:.9g},{}\n", written_, time, name);
  ++written_;
  return keep(path, write_shape(body, path, kMaterialsName));
}

Status Frames::finish(const Model& model) {
  if (written_ == 0) return Success{};
  const std::string list = (fs::path(outputs_.out) / kFramesName).string();
  if (Status status = keep(list, write_file(list, list_)); !status) return status;
  if (outputs_.surface_format != "obj" || model.render() == nullptr) return Success{};
  const std::string materials = (fs::path(outputs_.out) / kMaterialsName).string();
  return keep(materials, write_file(materials, material_library(model.render()->surface)));
}

}  // namespace tremolo
