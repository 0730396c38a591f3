#include "formats/basis/basis_writer.h"

#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <span>
#include <utility>

#include "formats/basis/basis_layout.h"
#include "formats/basis/compact_values.h"
#include "formats/sections/section_writer.h"
#include "formats/surface/flat_rig.h"

namespace tremolo {
namespace {

using namespace basis_layout;
// The bytes of the sections that a file gets. They stay where they are in the caller's data.
using Contents = std::map<std::string_view, std::span<const std::byte>>;

// Values in the file that are not in the caller's own arrays.
struct Additions {
  std::array<std::uint64_t, dimension::kCount> dimensions{};
  std::string objects;  // names, each ended by a zero byte
  std::string materials;
  std::array<double, kRestMoments> rest_moments{};  // of inertia_rest
  std::optional<CompactValues> compact;             // nullopt for a full file
  std::optional<FlatRig> rig;                       // of the render surface
};

std::string joined(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text.append(name).push_back('\0');
  return text;
}

bool is_linear(const BasisData& data) {
  return data.cubic.empty() && data.quartic.empty();
}

// Mass, first moment and second moment, row by row.
std::array<double, kRestMoments> rest_moments(const InertiaIntegrals& inertia) {
  std::array<double, kRestMoments> moments{inertia.mass};
  Eigen::Map<Eigen::Vector3d>(moments.data() + 1) = inertia.first_moment;
  Eigen::Map<Eigen::Matrix3d>(moments.data() + 4) = inertia.second_moment;  // symmetric
  return moments;
}

Error does_not_fit(std::string_view what) {
  return content_error("basis data: the size of '" + std::string(what) +
                       "' does not fit the others");
}

// Checks conditions that list_sections() cannot check from the bytes. streamed: the rows are not in
// `data`.
Status check_data(const BasisData& data, bool streamed) {
  const Eigen::Index r = data.lambda.size();
  if (r == 0 || std::cmp_greater(r, kMaxModes)) return does_not_fit("lambda");
  if (data.surface.vertex_ids.size() + data.interior.vertex_ids.size() != data.vertex_count ||
      data.vertex_count > kMaxVertices)
    return does_not_fit("vertex_count");
  if (data.response.at.size() > kMaxResponsePlaces) return does_not_fit("response");
  if (streamed) return Success{};
  for (const auto& [block, name] :
       {std::pair{&data.surface, "surface"}, {&data.interior, "interior"}})
    if (block->rows.rows() != 3 * std::ssize(block->vertex_ids) ||
        (block->rows.rows() > 0 && block->rows.cols() != r))
      return does_not_fit(name);
  if (data.render && !fits(*data.render, r, data.vertex_count)) return does_not_fit("render");
  return Success{};
}

Result<Additions> make_additions(const BasisData& data, BasisEncoding encoding) {
  Additions more;
  more.dimensions[dimension::kVertices] = data.vertex_count;
  more.dimensions[dimension::kTetrahedra] = data.tetrahedron_count;
  more.dimensions[dimension::kLinearModes] = data.linear_mode_count;
  more.dimensions[dimension::kModes] = data.lambda.size();
  more.dimensions[dimension::kFixed] = data.fixed_vertex_count;
  more.dimensions[dimension::kRigid] = data.rigid_mode_count;
  more.dimensions[dimension::kSurfaceVertices] = data.surface.vertex_ids.size();
  more.dimensions[dimension::kTriangles] = data.triangles.size();
  if (data.render) {
    more.objects = joined(data.render->surface.objects);
    more.materials = joined(data.render->surface.materials);
    if (data.render->surface.rig != nullptr) more.rig = flatten(*data.render->surface.rig);
  }
  if (data.inertia) more.rest_moments = rest_moments(*data.inertia);
  if (encoding == BasisEncoding::kFull) return more;
  if (Status status = take(more.compact, compact_values(data)); !status) return status.error();
  return more;
}

void add_rig(const FlatRig& rig, Contents& contents) {
  contents[kBoneNames] = bytes_of(rig.names);
  contents[kBoneParents] = bytes_of(rig.parents);
  contents[kBoneEnds] = bytes_of(rig.ends);
  contents[kSkinPlaces] = bytes_of(rig.places);
  contents[kSkinWeights] = bytes_of(rig.weights);
  if (rig.clip_frames.empty()) return;
  contents[kClipNames] = bytes_of(rig.clip_names);
  contents[kClipFrames] = bytes_of(rig.clip_frames);
  contents[kClipTimes] = bytes_of(rig.clip_times);
  contents[kClipPoses] = bytes_of(rig.clip_poses);
}

void add_render(const RenderBlock& render, const Additions& more, Contents& contents) {
  const RenderSurface& surface = render.surface;
  static_assert(sizeof(Eigen::Vector3f) == 3 * sizeof(float));
  static_assert(sizeof(Eigen::Vector2f) == 2 * sizeof(float));
  contents[kRenderRest] = bytes_of(surface.vertices);
  contents[kRenderBasis] = more.compact ? bytes_of(more.compact->render) : bytes_of(render.rows);
  contents[kRenderAnchors] = bytes_of(render.anchors);
  contents[kRenderTriangles] = bytes_of(surface.triangles);
  contents[kRenderObjects] = bytes_of(surface.object_of);
  contents[kRenderMaterials] = bytes_of(surface.material_of);
  contents[kObjectNames] = bytes_of(more.objects);
  contents[kMaterialNames] = bytes_of(more.materials);
  if (!surface.normals.empty()) contents[kRenderNormals] = bytes_of(surface.normals);
  if (!surface.uvs.empty()) contents[kRenderUvs] = bytes_of(surface.uvs);
  if (!surface.colours.empty()) contents[kRenderColours] = bytes_of(surface.colours);
  if (!surface.sources.empty()) contents[kRenderSources] = bytes_of(surface.sources);
  if (more.rig) add_rig(*more.rig, contents);
}

Contents contents_of(const BasisData& data, const Additions& more) {
  static_assert(sizeof(VertexId) == 4 && sizeof(Eigen::Vector3d) == 3 * sizeof(double));
  Contents contents = {{kDimensions, bytes_of(more.dimensions)},
                       {kTotalMass, bytes_of(std::span(&data.total_mass, 1))},
                       {kLambda, bytes_of(data.lambda)},
                       {kCubic, bytes_of(data.cubic)},
                       {kQuartic, bytes_of(data.quartic)},
                       {kLoadIds, bytes_of(data.load.vertices)},
                       {kLoadForces, bytes_of(data.load.forces)},
                       {kSurfaceIds, bytes_of(data.surface.vertex_ids)},
                       {kTriangles, bytes_of(data.triangles)},
                       {kSurfaceRest, bytes_of(data.surface.rest)},
                       {kSurfaceBasis, bytes_of(data.surface.rows)},
                       {kInteriorIds, bytes_of(data.interior.vertex_ids)},
                       {kInteriorRest, bytes_of(data.interior.rest)},
                       {kInteriorBasis, bytes_of(data.interior.rows)},
                       {kFixedIds, bytes_of(data.fixed_vertices)},
                       {kSingularValues, bytes_of(data.singular_values)},
                       {kProvenance, bytes_of(data.provenance)}};
  if (const auto& compact = more.compact) {
    contents[kCoefficientScales] = bytes_of(compact->coefficient_scales);
    contents[kBasisScales] = bytes_of(compact->basis_scales);
    contents[kCubic] = bytes_of(compact->cubic);
    contents[kQuartic] = bytes_of(compact->quartic);
    if (!compact->strain_gram.empty()) contents[kStrainScale] = bytes_of(compact->strain_scale);
    contents[kSurfaceBasis] = bytes_of(compact->surface);
    contents[kInteriorBasis] = bytes_of(compact->interior);
  }
  if (!data.strain_gram.empty())
    contents[kStrainGram] =
        more.compact ? bytes_of(more.compact->strain_gram) : bytes_of(data.strain_gram);
  static_assert(sizeof(MeshEdge) == 3 * sizeof(VertexId));
  if (!data.edges.empty()) contents[kEdgePoints] = bytes_of(data.edges);
  if (data.render) add_render(*data.render, more, contents);
  if (data.inertia) {
    contents[kInertiaRest] = bytes_of(more.rest_moments);
    contents[kInertiaLinear] = bytes_of(data.inertia->linear);
    contents[kInertiaPairs] = bytes_of(data.inertia->B);
  }
  if (!data.elements.corners.empty()) {
    static_assert(sizeof(Tetrahedron) == 4 * sizeof(VertexId));
    contents[kTetrahedra] = bytes_of(data.elements.corners);
    contents[kTetrahedronMasses] = bytes_of(data.elements.masses);
  }
  if (!data.response.at.empty()) {
    contents[kResponseAt] = bytes_of(data.response.at);
    contents[kResponseSurface] = bytes_of(data.response.surface);
    contents[kResponseInterior] = bytes_of(data.response.interior);
    if (data.render) contents[kResponseRender] = bytes_of(data.response.render);
  }
  if (!data.vega.basis.empty()) contents[kVegaBasis] = bytes_of(data.vega.basis);
  if (!data.vega.cubic.empty()) contents[kVegaCubic] = bytes_of(data.vega.cubic);
  return contents;
}

const RowSource* source_of(std::string_view name, const RowSources* sources) {
  if (sources == nullptr) return nullptr;
  return name == kSurfaceBasis    ? &sources->surface
         : name == kInteriorBasis ? &sources->interior
         : name == kRenderBasis   ? &sources->render
                                  : nullptr;
}

// The rows of a block, kRowsAtOnce vertices at a time.
Status stream_rows(const RowSource& source, const SectionShape& shape, const ByteSink& sink) {
  const std::size_t vertices = shape.rows / 3;
  const std::size_t numbers = 3 * shape.columns;
  std::vector<double> rows(std::min(vertices, kRowsAtOnce) * numbers);
  for (std::size_t first = 0; first < vertices; first += kRowsAtOnce) {
    const std::size_t count = std::min(kRowsAtOnce, vertices - first);
    if (Status status = source(first, count, rows.data()); !status) return status;
    if (Status status = sink(bytes_of(std::span(rows).first(count * numbers))); !status)
      return status;
  }
  return Success{};
}

Result<std::vector<SectionContent>> list_sections(const BasisData& data, const Additions& more,
                                                  const RowSources* sources) {
  const RenderSurface* render = data.render ? &data.render->surface : nullptr;
  const SectionSizes sizes = {.modes = more.dimensions[dimension::kModes],
                              .surface_vertices = data.surface.vertex_ids.size(),
                              .interior_vertices = data.interior.vertex_ids.size(),
                              .triangles = data.triangles.size(),
                              .fixed = data.fixed_vertex_count,
                              .loaded = data.load.vertices.size(),
                              .render_vertices = render ? render->vertices.size() : 0,
                              .render_triangles = render ? render->triangles.size() : 0,
                              .edges = data.edges.size(),
                              .tetrahedra = data.tetrahedron_count,
                              .response_places = data.response.at.size(),
                              .compact = more.compact.has_value(),
                              .linear = is_linear(data)};
  const Contents contents = contents_of(data, more);
  std::vector<SectionContent> sections;
  for (const SectionShape& shape : section_shapes(sizes)) {
    const auto found = contents.find(shape.name);
    if (found == contents.end()) continue;
    SectionContent section{shape, found->second};
    if (shape.rows == kAnyRows) section.shape.rows = section.bytes.size() / section.row_size();
    if (const RowSource* source = source_of(shape.name, sources))
      section.stream = [source, shape](const ByteSink& sink) {
        return stream_rows(*source, shape, sink);
      };
    else if (section.bytes.size() != section.size())
      return does_not_fit(shape.name);
    sections.push_back(std::move(section));
  }
  return sections;
}

// sources: null when the rows are in `data`. use(list) writes the file while the list's data exist.
template <class Use>
auto with_basis_sections(const BasisData& data, BasisEncoding encoding, const RowSources* sources,
                         const Use& use) -> decltype(use(SectionList{})) {
  if (Status status = check_data(data, sources != nullptr); !status) return status.error();
  const Result<Additions> more = make_additions(data, encoding);
  if (!more) return more.error();
  Result<std::vector<SectionContent>> sections = list_sections(data, *more, sources);
  if (!sections) return sections.error();
  const std::uint16_t encoded = more->compact || is_linear(data) ? kMinorEncoded : kMinor;
  const std::uint16_t shown = data.render ? kMinorRender : encoded;
  const std::uint16_t curved = data.edges.empty() ? shown : kMinorQuadratic;
  return use(
      SectionList{kKind, data.strain_gram.empty() ? curved : kMinorStrains, std::move(*sections)});
}

}  // namespace

Result<std::vector<std::byte>> encode_basis(const BasisData& data, BasisEncoding encoding) {
  return with_basis_sections(data, encoding, nullptr,
                             [](const SectionList& list) { return encode_sections(list); });
}

Status write_basis(const std::string& path, const BasisData& data, BasisEncoding encoding) {
  return with_basis_sections(data, encoding, nullptr, [&path](const SectionList& list) {
    return write_sections(path, list);
  });
}

Status write_basis(const std::string& path, const BasisData& data, const RowSources& sources) {
  return with_basis_sections(
      data, BasisEncoding::kFull, &sources,
      [&path](const SectionList& list) { return write_sections(path, list); });
}

}  // namespace tremolo
