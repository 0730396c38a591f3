// tremolo_model_*: loading and reading a model from C.
#include <algorithm>
#include <span>

#include "runtime/c/c_api.h"

namespace {

using tremolo::Model;
using tremolo::Status;
using tremolo::Success;
using tremolo::c_api::need;
using tremolo::c_api::need_buffer;
using tremolo::c_api::with;

// Stores the model returned by load() -> Result<Model::Pointer>. source: its origin, for the error.
template <class Load>
tremolo_status load_model(tremolo::c_api::Argument source, tremolo_model** model, Load&& load) {
  return tremolo::c_api::guarded([&]() -> Status {
    if (Status s = need({source, {model, "the place for the model"}}); !s) return s;
    tremolo::Result<Model::Pointer> loaded = load();
    if (!loaded) return loaded.error();
    *model = new tremolo_model{std::move(*loaded)};
    return Success{};
  });
}

// Fills a buffer of `needed` numbers: write(model) puts them there.
template <class Write>
tremolo_status fill(const tremolo_model* model, const void* out, std::size_t length,
                    std::size_t needed, Write&& write) {
  return with(model, [&](const Model& known) -> Status {
    if (Status s = need_buffer(out, length, needed); !s) return s;
    write(known);
    return Success{};
  });
}

}  // namespace

tremolo_status tremolo_model_load(const char* path, int32_t modes, tremolo_model** model) {
  return load_model({path, "the path"}, model, [&] { return Model::load(path, {.modes = modes}); });
}

tremolo_status tremolo_model_load_hull(const char* path, int32_t modes, tremolo_model** model) {
  return load_model({path, "the path"}, model,
                    [&] { return Model::load(path, {.modes = modes, .hull = true}); });
}

tremolo_status tremolo_model_load_memory(const void* bytes, size_t size, int32_t modes,
                                         tremolo_model** model) {
  return load_model({bytes, "the memory"}, model, [&] {
    const std::span<const std::byte> span(static_cast<const std::byte*>(bytes), size);
    return Model::load_from_memory(span, {.modes = modes});
  });
}

void tremolo_model_release(tremolo_model* model) {
  delete model;
}

size_t tremolo_model_modes(const tremolo_model* model) {
  return model == nullptr ? 0 : static_cast<size_t>(model->pointer->modes());
}

size_t tremolo_model_surface_vertices(const tremolo_model* model) {
  return model == nullptr ? 0 : model->pointer->drawn().rest.size();
}

size_t tremolo_model_triangles(const tremolo_model* model) {
  return model == nullptr ? 0 : model->pointer->drawn().triangles.size();
}

tremolo_status tremolo_model_frequencies(const tremolo_model* model, double* out, size_t length) {
  return fill(model, out, length, tremolo_model_modes(model), [&](const Model& known) {
    const Eigen::VectorXd frequencies = known.frequencies_hz();
    std::copy(frequencies.begin(), frequencies.end(), out);
  });
}

tremolo_status tremolo_model_triangle_corners(const tremolo_model* model, uint32_t* out,
                                              size_t length) {
  return with(model, [&](const Model& known) {
    return tremolo::c_api::fill_buffer(known.drawn().triangles, out, length);
  });
}

size_t tremolo_model_columns(const tremolo_model* model) {
  if (model == nullptr) return 0;
  const tremolo::DrawnSurface drawn = model->pointer->drawn();
  return static_cast<size_t>(drawn.rows.cols() + drawn.response.cols());
}

tremolo_status tremolo_model_rest(const tremolo_model* model, float* out, size_t length) {
  return fill(model, out, length, 3 * tremolo_model_surface_vertices(model),
              [&](const Model& known) {
                for (const Eigen::Vector3d& x : known.drawn().rest)
                  for (const double value : x) *out++ = static_cast<float>(value);
              });
}

tremolo_status tremolo_model_basis(const tremolo_model* model, float* out, size_t length) {
  const std::size_t needed =
      3 * tremolo_model_surface_vertices(model) * tremolo_model_columns(model);
  return fill(model, out, length, needed, [&](const Model& known) {
    const tremolo::DrawnSurface drawn = known.drawn();
    for (Eigen::Index row = 0; row < drawn.rows.rows(); row += 3)
      for (const tremolo::BasisRows* rows : {&drawn.rows, &drawn.response})
        for (Eigen::Index k = 0; k < rows->cols(); ++k)
          for (Eigen::Index axis = 0; axis < 3; ++axis)
            *out++ = static_cast<float>((*rows)(row + axis, k));
  });
}

tremolo_status tremolo_model_surface_ids(const tremolo_model* model, uint32_t* out, size_t length) {
  return fill(model, out, length, tremolo_model_surface_vertices(model), [&](const Model& known) {
    for (const tremolo::VertexId id : known.drawn().mesh_vertices)
      *out++ = static_cast<uint32_t>(id);
  });
}
