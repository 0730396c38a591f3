// C functions tremolo_model_* about the render surface.

#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include "runtime/c/c_api.h"

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

// C functions tremolo_body_*: rays, grabs at any point of the surface, pins.

namespace {

using Eigen::Vector3d;
using tremolo::ContactBody;
using tremolo::Result;
using tremolo::SurfaceKind;
using tremolo::SurfacePlace;

Status keep(const Result<std::size_t>& number, uint64_t* hand) {
  if (!number) return number.error();
  *hand = *number;
  return Success{};
}

SurfacePlace place_of(uint32_t triangle, const double weights[3]) {
  return {SurfaceKind::kDrawn, triangle, Vector3d(weights)};
}

}  // namespace

tremolo_status tremolo_body_coordinates(const tremolo_body* body, double* out, size_t length) {
  return with(body, [&](const ContactBody& known) {
    return tremolo::c_api::fill_buffer(known.shown(), out, length);
  });
}

tremolo_status tremolo_body_pick(const tremolo_body* body, const double origin[3],
                                 const double direction[3], tremolo_hit* hit) {
  return with(body, {{origin, "the origin"}, {direction, "the direction"}, {hit, "the hit"}},
              [&](const ContactBody& known) -> Status {
                const auto found = known.pick(Vector3d(origin), Vector3d(direction));
                if (!found) return found.error();
                *hit = {};
                if (!*found) return Success{};
                hit->found = 1;
                hit->triangle = static_cast<uint32_t>((*found)->place.triangle);
                hit->vertex = static_cast<uint32_t>((*found)->vertex);
                std::copy_n((*found)->place.weights.data(), 3, hit->weights);
                std::copy_n((*found)->point.data(), 3, hit->point);
                hit->distance = (*found)->distance;
                return Success{};
              });
}

tremolo_status tremolo_body_grab_at(tremolo_body* body, uint32_t triangle, const double weights[3],
                                    double stiffness, double damping, uint64_t* hand) {
  return with(body, {{weights, "the weights"}, {hand, "the place for the hand"}},
              [&](ContactBody& known) {
                return keep(known.grab(place_of(triangle, weights), stiffness, damping), hand);
              });
}

tremolo_status tremolo_body_pin(tremolo_body* body, uint32_t vertex, uint64_t* hand) {
  return with(body, {{hand, "the place for the hand"}}, [&](ContactBody& known) -> Status {
    const Result<tremolo::VertexId> id = tremolo::c_api::to_vertex(vertex);
    if (!id) return id.error();
    return keep(known.pin(*id), hand);
  });
}

tremolo_status tremolo_body_pin_at(tremolo_body* body, uint32_t triangle, const double weights[3],
                                   uint64_t* hand) {
  return with(
      body, {{weights, "the weights"}, {hand, "the place for the hand"}},
      [&](ContactBody& known) { return keep(known.pin(place_of(triangle, weights)), hand); });
}
