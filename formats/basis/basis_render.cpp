// The sections of a render surface -> RenderBlock.
#include <algorithm>
#include <utility>

#include "common/packed_index.h"
#include "formats/basis/basis_reader.h"
#include "formats/surface/flat_rig.h"

namespace tremolo {
namespace {

using namespace basis_layout;

// Texts that each end with a zero byte; at least one.
Result<std::vector<std::string>> read_names(BasisReader& reader, std::string_view section) {
  const Result<std::string_view> text = reader.text(section);
  if (!text) return text.error();
  if (text->empty() || text->back() != '\0')
    return content_error("section '" + std::string(section) + "': a name has no end");
  std::vector<std::string> names;
  for (std::string_view rest = *text; !rest.empty();) {
    const std::size_t end = rest.find('\0');
    names.emplace_back(rest.substr(0, end));
    rest.remove_prefix(end + 1);
  }
  return names;
}

Status read_vertices(BasisReader& reader, RenderBlock& block) {
  if (Status s = take(block.surface.vertices, reader.points(kRenderRest)); !s) return s;
  if (Status s = take(block.rows, reader.basis_rows(kRenderBasis)); !s) return s;
  if (Status s = take(block.column_scales, reader.column_scales()); !s) return s;
  return take(block.anchors, reader.indices(kRenderAnchors, reader.dimensions().vertices));
}

Status read_faces(BasisReader& reader, RenderSurface& surface) {
  if (Status s =
          take(surface.triangles, reader.triangles(kRenderTriangles, surface.vertices.size()));
      !s)
    return s;
  const auto read = [&reader](std::string_view names_in, std::string_view indices_in,
                              std::vector<std::string>& names,
                              std::vector<std::uint32_t>& indices) -> Status {
    if (Status s = take(names, read_names(reader, names_in)); !s) return s;
    return take(indices, reader.indices(indices_in, names.size()));
  };
  if (Status s = read(kObjectNames, kRenderObjects, surface.objects, surface.object_of); !s)
    return s;
  return read(kMaterialNames, kRenderMaterials, surface.materials, surface.material_of);
}

// Rows of a matrix with `Size` columns, if the section is there.
template <int Size>
Status read_vectors(BasisReader& reader, std::string_view section,
                    std::vector<Eigen::Matrix<float, Size, 1>>& vectors) {
  if (!reader.has(section)) return Success{};
  const Result<std::span<const float>> values = reader.floats(section);
  if (!values) return values.error();
  vectors.resize(values->size() / Size);
  for (std::size_t v = 0; v < vectors.size(); ++v)
    vectors[v] = Eigen::Map<const Eigen::Matrix<float, Size, 1>>(values->data() + Size * v);
  return Success{};
}

Status read_colours(BasisReader& reader, std::vector<Colour>& colours) {
  if (!reader.has(kRenderColours)) return Success{};
  const Result<std::span<const std::uint8_t>> values = reader.bytes(kRenderColours);
  if (!values) return values.error();
  colours.resize(values->size() / 4);
  for (std::size_t v = 0; v < colours.size(); ++v)
    std::copy_n(values->data() + 4 * v, 4, colours[v].data());
  return Success{};
}

Status read_sources(BasisReader& reader, RenderSurface& surface) {
  if (!reader.has(kRenderSources)) return Success{};
  if (Status s = take(surface.sources, reader.indices(kRenderSources, surface.vertices.size())); !s)
    return s;
  if (surface.sources_hold()) return Success{};
  return content_error("section '" + std::string(kRenderSources) +
                       "': the vertices of the author's file do not come first, each as itself");
}

template <class T>
Status read_flat(const Result<std::span<const T>>& values, std::vector<T>& out) {
  if (!values) return values.error();
  out.assign(values->begin(), values->end());
  return Success{};
}

Status read_clips(BasisReader& reader, FlatRig& flat) {
  if (!reader.has(kClipNames)) return Success{};
  const Result<std::string_view> names = reader.text(kClipNames);
  if (!names) return names.error();
  flat.clip_names = *names;
  if (Status s = take(flat.clip_frames, reader.indices(kClipFrames, kMaxVertices)); !s) return s;
  if (Status s = read_flat(reader.doubles(kClipTimes), flat.clip_times); !s) return s;
  return read_flat(reader.doubles(kClipPoses), flat.clip_poses);
}

Status read_rig(BasisReader& reader, RenderSurface& surface) {
  if (!reader.has(kBoneNames)) return Success{};
  FlatRig flat;
  const Result<std::string_view> names = reader.text(kBoneNames);
  if (!names) return names.error();
  flat.names = *names;
  const std::uint64_t words = std::uint64_t{kNoBone} + 1;
  if (Status s = take(flat.parents, reader.indices(kBoneParents, words)); !s) return s;
  if (Status s = read_flat(reader.doubles(kBoneEnds), flat.ends); !s) return s;
  if (Status s = take(flat.places, reader.indices(kSkinPlaces, words)); !s) return s;
  if (Status s = read_flat(reader.floats(kSkinWeights), flat.weights); !s) return s;
  if (Status s = read_clips(reader, flat); !s) return s;
  surface.rig = unflatten(flat, surface.vertices.size());
  if (surface.rig != nullptr) return Success{};
  return content_error("section '" + std::string(kBoneNames) +
                       "': bones, weights and clips do not fit each other or the render surface");
}

bool are_names(const std::vector<std::string>& names) {
  return !names.empty() && std::none_of(names.begin(), names.end(), [](const std::string& name) {
    return name.find('\0') != std::string::npos;
  });
}

bool all_below(const std::vector<std::uint32_t>& indices, std::size_t bound) {
  return std::all_of(indices.begin(), indices.end(), [&](std::uint32_t i) { return i < bound; });
}

}  // namespace

bool fits(const RenderBlock& render, Eigen::Index r, std::uint64_t n) {
  const RenderSurface& surface = render.surface;
  const std::size_t count = surface.vertices.size();
  const std::size_t triangles = surface.triangles.size();
  if (count == 0 || count > kMaxVertices || triangles > 4 * kMaxVertices) return false;
  const auto one_each_or_none = [count](std::size_t size) { return size == 0 || size == count; };
  if (std::cmp_not_equal(render.rows.rows(), 3 * count) || render.rows.cols() != r ||
      render.anchors.size() != count || !one_each_or_none(surface.normals.size()) ||
      !one_each_or_none(surface.uvs.size()) || !one_each_or_none(surface.colours.size()) ||
      surface.object_of.size() != triangles || surface.material_of.size() != triangles ||
      !are_names(surface.objects) || !are_names(surface.materials) || !surface.sources_hold() ||
      (surface.rig != nullptr && !rig_holds(*surface.rig, count)))
    return false;
  const auto is_corner = [count](VertexId id) { return is_index(id, count); };
  return std::all_of(render.anchors.begin(), render.anchors.end(),
                     [n](VertexId id) { return is_index(id, n); }) &&
         std::all_of(
             surface.triangles.begin(), surface.triangles.end(),
             [&](const Triangle& t) { return std::all_of(t.begin(), t.end(), is_corner); }) &&
         all_below(surface.object_of, surface.objects.size()) &&
         all_below(surface.material_of, surface.materials.size());
}

Result<std::optional<RenderBlock>> read_render(BasisReader& reader) {
  if (!reader.has(kRenderRest)) return std::optional<RenderBlock>();
  RenderBlock block;
  if (Status s = read_vertices(reader, block); !s) return s.error();
  if (Status s = read_faces(reader, block.surface); !s) return s.error();
  if (Status s = read_vectors(reader, kRenderNormals, block.surface.normals); !s) return s.error();
  if (Status s = read_vectors(reader, kRenderUvs, block.surface.uvs); !s) return s.error();
  if (Status s = read_colours(reader, block.surface.colours); !s) return s.error();
  if (Status s = read_sources(reader, block.surface); !s) return s.error();
  if (Status s = read_rig(reader, block.surface); !s) return s.error();
  return std::optional<RenderBlock>(std::move(block));
}

}  // namespace tremolo
