// The sections of a render surface -> RenderBlock.
#include <algorithm>

#include "formats/basis/basis_reader.h"

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
  RenderSurface& surface = block.surface;
  const Result<std::span<const double>> rest = reader.doubles(kRenderRest);
  if (!rest) return rest.error();
  surface.vertices.resize(rest->size() / 3);
  for (std::size_t v = 0; v < surface.vertices.size(); ++v)
    surface.vertices[v] = Eigen::Map<const Eigen::Vector3d>(rest->data() + 3 * v);
  Result<BasisRows> rows = reader.basis_rows(kRenderBasis);
  if (!rows) return rows.error();
  block.rows = std::move(*rows);
  Result<Eigen::VectorXd> scales = reader.column_scales();
  if (!scales) return scales.error();
  block.column_scales = std::move(*scales);
  const auto anchors = reader.indices(kRenderAnchors, reader.dimensions().vertices);
  if (!anchors) return anchors.error();
  block.anchors.assign(anchors->begin(), anchors->end());
  return Success{};
}

Status read_faces(BasisReader& reader, RenderSurface& surface) {
  const auto corners = reader.indices(kRenderTriangles, surface.vertices.size());
  if (!corners) return corners.error();
  surface.triangles.resize(corners->size() / 3);
  for (std::size_t t = 0; t < surface.triangles.size(); ++t)
    for (std::size_t corner = 0; corner < 3; ++corner)
      surface.triangles[t][corner] = static_cast<VertexId>((*corners)[3 * t + corner]);
  const auto take = [&reader](std::string_view names_in, std::string_view indices_in,
                              std::vector<std::string>& names,
                              std::vector<std::uint32_t>& indices) -> Status {
    Result<std::vector<std::string>> found = read_names(reader, names_in);
    if (!found) return found.error();
    names = std::move(*found);
    const auto values = reader.indices(indices_in, names.size());
    if (!values) return values.error();
    indices.assign(values->begin(), values->end());
    return Success{};
  };
  if (Status s = take(kObjectNames, kRenderObjects, surface.objects, surface.object_of); !s)
    return s;
  return take(kMaterialNames, kRenderMaterials, surface.materials, surface.material_of);
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

bool are_names(const std::vector<std::string>& names) {
  return !names.empty() && std::none_of(names.begin(), names.end(), [](const std::string& name) {
    return name.find('\0') != std::string::npos;
  });
}

bool all_below(const std::vector<std::uint32_t>& indices, std::size_t bound) {
  return std::all_of(indices.begin(), indices.end(), [&](std::uint32_t i) { return i < bound; });
}

bool is_below(VertexId id, std::uint64_t bound) {
  return id >= 0 && static_cast<std::uint64_t>(id) < bound;
}

}  // namespace

bool fits(const RenderBlock& render, Eigen::Index r, std::uint64_t n) {
  const RenderSurface& surface = render.surface;
  const std::size_t count = surface.vertices.size();
  const std::size_t triangles = surface.triangles.size();
  if (count == 0 || count > kMaxVertices || triangles > 4 * kMaxVertices) return false;
  const auto one_each_or_none = [count](std::size_t size) { return size == 0 || size == count; };
  if (render.rows.rows() != static_cast<Eigen::Index>(3 * count) || render.rows.cols() != r ||
      render.anchors.size() != count || !one_each_or_none(surface.normals.size()) ||
      !one_each_or_none(surface.uvs.size()) || !one_each_or_none(surface.colours.size()) ||
      surface.object_of.size() != triangles || surface.material_of.size() != triangles ||
      !are_names(surface.objects) || !are_names(surface.materials))
    return false;
  const auto is_corner = [count](VertexId id) { return is_below(id, count); };
  return std::all_of(render.anchors.begin(), render.anchors.end(),
                     [n](VertexId id) { return is_below(id, n); }) &&
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
  return std::optional<RenderBlock>(std::move(block));
}

}  // namespace tremolo
