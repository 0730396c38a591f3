// A basis file in memory becomes a model: what an engine does with a file from the network.
#include "runtime/bodies/reduced/surface/surface.h"
#include "runtime/model.h"
#include "tests/fuzz/harness.h"

void tremolo::fuzz::read_input(std::string_view bytes) {
  const Result<Model::Pointer> loaded =
      Model::load_from_memory(std::as_bytes(std::span(bytes.data(), bytes.size())));
  check_error(loaded);
  if (!loaded) return;
  const Model& model = **loaded;
  if (!(model.explicit_step_limit() > 0)) finding("a model without a step limit");
  for (const VertexId id : {VertexId{0}, static_cast<VertexId>(model.vertex_count() - 1)})
    if (const Result<VertexRows> rows = model.vertex(id); rows && !rows->rows.allFinite())
      finding("rows that are not finite");
  model.surface_basis();
}
