#include "runtime/apps/tremolo/start/start_state.h"

#include <filesystem>
#include <vector>

#include "formats/file/input_file.h"
#include "runtime/scene/scene_start.h"
#include "runtime/scene/selection.h"

namespace tremolo {
namespace {

Result<Eigen::VectorXd> displaced_shape(const StartDisplacement& displacement, const Model& model) {
  const Result<std::vector<VertexId>> vertices = vertices_of(displacement.where, model);
  if (!vertices) return vertices.error();
  Hold hold{Eigen::MatrixXd::Zero(3, model.modes()), displacement.by};
  for (const VertexId id : *vertices) {
    const Result<VertexRows> rows = model.vertex(id);
    if (!rows) return content_error(rows.error().message);
    hold.rows += rows->rows / static_cast<double>(vertices->size());
  }
  return standing_shape(model.potential(), Eigen::VectorXd::Zero(model.modes()), hold);
}

}  // namespace

Result<State> start_state(const std::string& text, const Model& model,
                          const Eigen::VectorXd& force) {
  const Eigen::VectorXd zero = Eigen::VectorXd::Zero(model.modes());
  if (text.empty()) return State{zero, zero};
  const auto with_text = [&text](Error error) {
    error.message = "--start " + text + ": " + error.message;
    return error;
  };
  if (text == kStaticStart) {
    if (force.isZero(0.0))
      return with_text(
          content_error("no load acts at t = 0 (a sine begins with zero): the body would stand in "
                        "its rest shape"));
    const Result<Eigen::VectorXd> q = standing_shape(model.potential(), force);
    if (!q) return with_text(q.error());
    return State{*q, zero};
  }
  if (const auto displacement = start_displacement(text)) {
    const Result<Eigen::VectorXd> q = displaced_shape(*displacement, model);
    if (!q) return with_text(q.error());
    return State{*q, zero};
  }
  const StartRow row = start_row(text);
  std::error_code ignored;
  if (!std::filesystem::exists(row.path, ignored) && text.find('=') != std::string::npos)
    return with_text(
        usage_error("expected VERTEX|SELECTOR=X,Y,Z, three finite numbers in m, static, or "
                    "a file of rows; there is no such file"));
  const Result<std::string> csv = read_whole_file(row.path);
  if (!csv) return csv.error();
  return parse_state_row(*csv, row.path, row.time, model.modes());
}

}  // namespace tremolo
