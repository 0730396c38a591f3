// tremolo_model_*: loading and reading a model from C.
#include <algorithm>
#include <span>

#include "runtime/c_api/c_api.h"

namespace {

using tremolo::Status;
using tremolo::Success;
using tremolo::c_api::guarded;
using tremolo::c_api::need;
using tremolo::c_api::need_buffer;

Status keep_model(tremolo::Result<tremolo::Model::Pointer> loaded, tremolo_model** out) {
  if (!loaded) return loaded.error();
  *out = new tremolo_model{std::move(*loaded)};
  return Success{};
}

}  // namespace

tremolo_status tremolo_model_load(const char* path, int32_t modes, tremolo_model** model) {
  return guarded([&]() -> Status {
    if (Status s = need(path, "the path"); !s) return s;
    if (Status s = need(model, "the place for the model"); !s) return s;
    return keep_model(tremolo::Model::load(path, {.modes = modes}), model);
  });
}

tremolo_status tremolo_model_load_hull(const char* path, int32_t modes, tremolo_model** model) {
  return guarded([&]() -> Status {
    if (Status s = need(path, "the path"); !s) return s;
    if (Status s = need(model, "the place for the model"); !s) return s;
    return keep_model(tremolo::Model::load(path, {.modes = modes, .hull = true}), model);
  });
}

tremolo_status tremolo_model_load_memory(const void* bytes, size_t size, int32_t modes,
                                         tremolo_model** model) {
  return guarded([&]() -> Status {
    if (Status s = need(bytes, "the memory"); !s) return s;
    if (Status s = need(model, "the place for the model"); !s) return s;
    const std::span<const std::byte> span(static_cast<const std::byte*>(bytes), size);
    return keep_model(tremolo::Model::load_from_memory(span, {.modes = modes}), model);
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
  return guarded([&]() -> Status {
    if (Status s = need(model, "the model"); !s) return s;
    if (Status s = need_buffer(out, length, tremolo_model_modes(model)); !s) return s;
    const Eigen::VectorXd frequencies = model->pointer->frequencies_hz();
    std::copy(frequencies.begin(), frequencies.end(), out);
    return Success{};
  });
}

tremolo_status tremolo_model_triangle_corners(const tremolo_model* model, uint32_t* out,
                                              size_t length) {
  return guarded([&]() -> Status {
    if (Status s = need(model, "the model"); !s) return s;
    if (Status s = need_buffer(out, length, 3 * tremolo_model_triangles(model)); !s) return s;
    for (const tremolo::Triangle& triangle : model->pointer->drawn().triangles)
      for (const tremolo::VertexId corner : triangle) *out++ = static_cast<uint32_t>(corner);
    return Success{};
  });
}

tremolo_status tremolo_model_surface_ids(const tremolo_model* model, uint32_t* out, size_t length) {
  return guarded([&]() -> Status {
    if (Status s = need(model, "the model"); !s) return s;
    if (Status s = need_buffer(out, length, tremolo_model_surface_vertices(model)); !s) return s;
    for (const tremolo::VertexId id : model->pointer->drawn().mesh_vertices)
      *out++ = static_cast<uint32_t>(id);
    return Success{};
  });
}
