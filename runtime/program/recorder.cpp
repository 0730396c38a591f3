#include "runtime/program/recorder.h"

#include <iterator>

#include <fmt/format.h>

#include "formats/atomic_file.h"

namespace tremolo {

Result<Recorder> Recorder::create(const Model& model, std::vector<int> coordinates,
                                  const std::vector<int>& probes) {
  Recorder recorder;
  recorder.text_ = "t,kinetic,potential,total,high_band,work,dissipated";
  for (int i : coordinates) {
    if (i < 0 || i >= model.modes())
      return Error{ErrorKind::kUsage, fmt::format("coordinate {}: the model has {}, counted from 0",
                                                  i, model.modes())};
    recorder.text_ += fmt::format(",q{}", i);
  }
  for (int vertex : probes) {
    Result<VertexRows> rows = model.vertex(vertex);
    if (!rows) return rows.error();
    recorder.text_ += fmt::format(",u{0}x,u{0}y,u{0}z", vertex);
    recorder.probes_.push_back({vertex, std::move(rows->rows)});
  }
  recorder.text_ += '\n';
  recorder.coordinates_ = std::move(coordinates);
  return recorder;
}

void Recorder::record(const Body& body, const Energy& energy) {
  auto out = std::back_inserter(text_);
  fmt::format_to(out, "{:.9g},{:.10g},{:.10g},{:.12g},{:.10g},{:.10g},{:.10g}", body.time(),
                 energy.kinetic, energy.potential, energy.total(), energy.high_band, body.work(),
                 body.dissipated());
  const Eigen::VectorXd& q = body.state().q;
  for (int i : coordinates_) fmt::format_to(out, ",{:.10g}", q[i]);
  for (const Probe& probe : probes_) {
    const Eigen::Vector3d u = probe.rows * q;
    fmt::format_to(out, ",{:.8g},{:.8g},{:.8g}", u.x(), u.y(), u.z());
  }
  text_ += '\n';
}

Status Recorder::write(const std::string& path) const {
  return write_file(path, text_);
}

}  // namespace tremolo
