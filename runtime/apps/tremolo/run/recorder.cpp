#include "runtime/apps/tremolo/run/recorder.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <iterator>
#include <span>
#include <utility>

#include <fmt/format.h>

#include "runtime/scene/selection.h"

namespace tremolo {

void look_at(const Body& body, Moment& moment) {
  moment.steps = body.counts().steps;
  moment.time = body.time();
  moment.state.q = body.state().q;
  moment.place_forces = body.shown().tail(body.shown().size() - moment.state.q.size());
  moment.state.p.resize(moment.state.q.size());
  body.integrator().synchronized_momentum(body.state(), moment.state.p);
  moment.work = body.sums().work;
  moment.dissipated = body.sums().dissipated;
  moment.iterations = body.counts().iterations;
  moment.halved_steps = body.counts().halved;
  moment.loaded = body.load_to_come();
  moment.split = body.integrator().split();
  moment.bound = body.energy_bound();
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

Result<ShownResponse> ShownResponse::create(const Model& model, int vertex) {
  ShownResponse shown;
  if (model.response_places().empty()) return shown;
  Result<VertexRows> rows = model.response(vertex);
  if (!rows) return rows.error();
  shown.rows_ = std::move(rows->rows);
  return shown;
}

Result<Recorder> Recorder::create(const Model& model, const RecordedColumns& columns,
                                  const std::string& path, bool parked) {
  Recorder recorder;
  recorder.columns_ = columns;
  std::string head = "t,kinetic,potential,total,high_band,work,dissipated";
  for (const std::string& name : columns.further) head += ',' + name;
  for (const int i : columns.coordinates) head += fmt::format(",q{}", i);
  if (columns.velocities)
    for (const int i : columns.coordinates) head += fmt::format(",p{}", i);
  for (const int vertex : columns.probes) {
    Result<VertexRows> rows = model.vertex(vertex);
    if (!rows) return rows.error();
    head += fmt::format(",u{0}x,u{0}y,u{0}z", vertex);
    if (columns.velocities) head += fmt::format(",v{0}x,v{0}y,v{0}z", vertex);
    Result<ShownResponse> response = ShownResponse::create(model, vertex);
    if (!response) return response.error();
    recorder.probes_.push_back({vertex, std::move(rows->rows), std::move(*response)});
  }
  if (Status s = take(recorder.table_, CsvTable::create(path, std::move(head), parked)); !s)
    return s.error();
  return recorder;
}

Status Recorder::record(const Moment& moment, const Energy& energy,
                        std::span<const double> further) {
  if (!table_.is_written()) return Success{};
  auto out = std::back_inserter(table_.row());
  fmt::format_to(out, "{:.9g},{:.10g},{:.10g},{:.12g},{:.10g},{:.10g},{:.10g}", moment.time,
                 energy.kinetic, energy.potential, energy.total(), energy.high_band, moment.work,
                 moment.dissipated);
  for (const double value : further) fmt::format_to(out, ",{:.12g}", value);
  const auto& [q, p] = moment.state;
  for (const int i : columns_.coordinates) fmt::format_to(out, ",{:.10g}", q[i]);
  if (columns_.velocities)
    for (const int i : columns_.coordinates) fmt::format_to(out, ",{:.10g}", p[i]);
  for (const Probe& probe : probes_) {
    const Eigen::Vector3d u = probe.rows * q + probe.response(moment);
    fmt::format_to(out, ",{:.8g},{:.8g},{:.8g}", u.x(), u.y(), u.z());
    if (!columns_.velocities) continue;
    const Eigen::Vector3d v = probe.rows * p;
    fmt::format_to(out, ",{:.8g},{:.8g},{:.8g}", v.x(), v.y(), v.z());
  }
  return table_.end_row();
}

}  // namespace tremolo
