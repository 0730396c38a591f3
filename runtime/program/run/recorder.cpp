#include "runtime/program/run/recorder.h"

#include <iterator>
#include <utility>

#include <fmt/format.h>

namespace tremolo {
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

}  // namespace tremolo
