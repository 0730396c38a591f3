// The class tremolo.Model: a loaded basis file and where it came from.
#pragma once

#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "runtime/apps/python/module/convert.h"
#include "runtime/model.h"

namespace tremolo::python {

// Buffers of one evaluation of the potential.
struct PotentialScratch {
  PotentialWorkspace workspace;
  Evaluation result;
  Eigen::VectorXd q;  // r
};

// Scratch of calls that are over, for the next ones; several threads may evaluate at once.
class ScratchPool {
 public:
  std::unique_ptr<PotentialScratch> take(const Potential& potential, unsigned uses);
  void give_back(std::unique_ptr<PotentialScratch> scratch);

 private:
  std::mutex mutex_;
  std::vector<std::unique_ptr<PotentialScratch>> free_;
};

struct PyModel {
  Model::Pointer model;
  ModelOptions options;
  std::string path;              // absolute; empty: made of `bytes`
  std::string bytes;             // a basis file in memory; empty: loaded from `path`
  ScratchPool points, tangents;  // without and with kUseTangent
};

using PyModelPointer = std::shared_ptr<PyModel>;

// Errors as exceptions.
PyModelPointer load_model(const std::string& path, const ModelOptions& options);
PyModelPointer load_model_of_bytes(std::string bytes, const ModelOptions& options);

// The vertices that `at` names: an id, several ids, or a selector on the boundary.
std::vector<VertexId> vertices_at(py::handle at, const Model& model);

// Model.response and Model.backbone.
void add_curves(py::class_<PyModel, PyModelPointer>& model);

}  // namespace tremolo::python
