#include "runtime/apps/tremolo/run/body_files.h"

#include <filesystem>

#include "formats/file/atomic_file.h"
#include "formats/surface/surface_writer.h"
#include "runtime/apps/tremolo/output/plot.h"
#include "runtime/apps/tremolo/run/run_body.h"
#include "runtime/apps/tremolo/run/run_files.h"

namespace tremolo {
namespace {

namespace fs = std::filesystem;

// Adds to positions the response to the moment's forces that the body itself does not show: a body
// in the moment's state has its coordinates, but need not have taken its step.
void add_missing_response(const Moment& moment, const Body& body, const BasisRows& response,
                          std::span<double> positions) {
  if (response.cols() == 0) return;
  const Eigen::VectorXd missing =
      moment.place_forces - body.shown().tail(moment.place_forces.size());
  if (missing.isZero(0.0)) return;
  Eigen::Map<Eigen::VectorXd>(positions.data(), std::ssize(positions)) +=
      response.cast<double>() * missing;
}

// The author's surface where the body is now. Its normals are those of U q.
Status write_render_shape(const Moment& moment, const Body& body, const std::string& path,
                          const std::string& materials) {
  RenderSurface surface = body.model().render()->surface;
  const std::size_t count = 3 * surface.vertices.size();
  surface.normals.resize(surface.vertices.size());
  std::vector<float> positions(count);  // of the normals; those that are written are exact
  const Status normals = body.surface(positions, std::span(surface.normals[0].data(), count));
  if (!normals) return normals;
  const std::span<double> flat(surface.vertices[0].data(), count);
  if (Status s = body.surface_positions(flat); !s) return s;
  add_missing_response(moment, body, body.model().drawn().response, flat);
  return write_render_surface(path, surface, materials);
}

// Writes the present shape of `body` as it is drawn: its render surface, else the boundary.
// materials: the name of the .mtl file that an .obj refers to.
Status write_shape(const Moment& moment, const Body& body, const std::string& path,
                   const std::string& materials) {
  if (body.model().render() != nullptr) return write_render_shape(moment, body, path, materials);
  SurfaceMesh surface;
  surface.vertices.resize(body.model().surface().vertex_ids.size());
  surface.triangles = body.model().triangles();
  // Eigen's fixed-size vectors are contiguous.
  const std::span<double> flat(surface.vertices.empty() ? nullptr : surface.vertices[0].data(),
                               3 * surface.vertices.size());
  if (Status status = body.surface_positions(flat); !status) return status;
  add_missing_response(moment, body, body.model().drawn().response, flat);
  return write_surface(path, surface);
}

}  // namespace

Result<BodyFiles> BodyFiles::create(const SceneOutputs& outputs, const RecordedColumns& columns,
                                    const Model& model, StepRange steps, bool parked) {
  if (Status s = make_run_folder(outputs.out); !s) return s.error();
  Result<Recorder> recorder = Recorder::create(model, columns, table_path(outputs), parked);
  if (!recorder) return value_error(recorder.error());
  return BodyFiles(outputs, std::move(*recorder), steps);
}

Status BodyFiles::write_surface(const Moment& moment, const Body& body) {
  if (!frames_.due(moment.steps)) return Success{};
  return frames_.write(moment.time, [&](const std::string& path) {
    return write_shape(moment, body, path, kMaterialsName);
  });
}

Status BodyFiles::finish(const Model& model, const std::string& label,
                         std::vector<std::string>& files) {
  if (folder().empty()) return Success{};
  if (Status s = frames_.finish(); !s) return s;
  files = frames_.files();
  if (!files.empty() && outputs_.surface_format == "obj" && model.render() != nullptr) {
    const std::string materials = (fs::path(folder()) / kMaterialsName).string();
    if (Status s = write_file(materials, material_library(model.render()->surface)); !s) return s;
    files.push_back(materials);
  }
  if (Status s = recorder_.finish(); !s) return s;
  files.push_back(table_path(outputs_));
  if (!outputs_.plot || label.empty()) return Success{};
  return plot_run({label, files.back()}, folder(), files);
}

}  // namespace tremolo
