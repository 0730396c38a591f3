// C functions tremolo_model_* about the render surface.
#include <algorithm>
#include <string>
#include <vector>

#include "runtime/c_api/c_api.h"

namespace {

using tremolo::RenderSurface;
using tremolo::Status;
using tremolo::Success;
using tremolo::c_api::need_buffer;
using tremolo::c_api::with;

const RenderSurface* surface_of(const tremolo_model* model) {
  if (model == nullptr || model->pointer->render() == nullptr) return nullptr;
  return &model->pointer->render()->surface;
}

const char* name_at(const std::vector<std::string>& names, size_t index) {
  return index < names.size() ? names[index].c_str() : nullptr;
}

// Copies a member of the render surface, `width` numbers an entry.
template <class Entry, class Number>
tremolo_status copy_out(const tremolo_model* model, std::vector<Entry> RenderSurface::*member,
                        size_t width, const char* what, Number* out, size_t length) {
  return with(model, [&](const tremolo::Model&) -> Status {
    const RenderSurface* surface = surface_of(model);
    if (surface == nullptr || ((surface->*member).empty() && !surface->triangles.empty()))
      return tremolo::usage_error(std::string("the drawn surface has no ") + what);
    const std::vector<Entry>& entries = surface->*member;
    if (Status s = need_buffer(out, length, width * entries.size()); !s) return s;
    static_assert(sizeof(Entry) % sizeof(Number) == 0);
    const auto* numbers = reinterpret_cast<const Number*>(entries.data());
    std::copy_n(numbers, length, out);
    return Success{};
  });
}

}  // namespace

int32_t tremolo_model_has_render(const tremolo_model* model) {
  return surface_of(model) != nullptr ? 1 : 0;
}

int32_t tremolo_model_has_uvs(const tremolo_model* model) {
  const RenderSurface* surface = surface_of(model);
  return surface != nullptr && !surface->uvs.empty() ? 1 : 0;
}

int32_t tremolo_model_has_colours(const tremolo_model* model) {
  const RenderSurface* surface = surface_of(model);
  return surface != nullptr && !surface->colours.empty() ? 1 : 0;
}

size_t tremolo_model_materials(const tremolo_model* model) {
  const RenderSurface* surface = surface_of(model);
  return surface == nullptr ? 0 : surface->materials.size();
}

size_t tremolo_model_objects(const tremolo_model* model) {
  const RenderSurface* surface = surface_of(model);
  return surface == nullptr ? 0 : surface->objects.size();
}

const char* tremolo_model_material_name(const tremolo_model* model, size_t index) {
  const RenderSurface* surface = surface_of(model);
  return surface == nullptr ? nullptr : name_at(surface->materials, index);
}

const char* tremolo_model_object_name(const tremolo_model* model, size_t index) {
  const RenderSurface* surface = surface_of(model);
  return surface == nullptr ? nullptr : name_at(surface->objects, index);
}

tremolo_status tremolo_model_triangle_materials(const tremolo_model* model, uint32_t* out,
                                                size_t length) {
  return copy_out(model, &RenderSurface::material_of, 1, "materials", out, length);
}

tremolo_status tremolo_model_triangle_objects(const tremolo_model* model, uint32_t* out,
                                              size_t length) {
  return copy_out(model, &RenderSurface::object_of, 1, "objects", out, length);
}

tremolo_status tremolo_model_uvs(const tremolo_model* model, float* out, size_t length) {
  return copy_out(model, &RenderSurface::uvs, 2, "texture coordinates", out, length);
}

tremolo_status tremolo_model_colours(const tremolo_model* model, uint8_t* out, size_t length) {
  return copy_out(model, &RenderSurface::colours, 4, "colours", out, length);
}
