#include "formats/basis/basis_reader.h"

#include <utility>

namespace tremolo {

using namespace basis_layout;

Result<BasisReader> BasisReader::open(const std::string& path) {
  return checked(SectionFile::open(path, kKind));
}

Result<BasisReader> BasisReader::from_memory(std::span<const std::byte> bytes, std::string name) {
  return checked(SectionFile::from_memory(bytes, std::move(name), kKind));
}

Result<BasisReader> BasisReader::checked(Result<SectionFile> file) {
  if (!file) return file.error();
  BasisReader reader(std::move(*file));
  if (Status status = reader.read_dimensions(); !status) return status.error();
  if (Status status = reader.check_shapes(); !status) return status.error();
  return reader;
}

Status BasisReader::read_dimensions() {
  const BasisSection* section = file_.find(kDimensions);
  if (section == nullptr || section->rows != dimension::kCount || section->columns != 1)
    return file_.error_at("table", kHeaderSize,
                          "section 'dimensions' is missing or has another shape");
  const auto values = file_.elements<std::uint64_t>(kDimensions);
  if (!values) return values.error();
  const std::span<const std::uint64_t> v = *values;
  dimensions_ = {v[dimension::kVertices],        v[dimension::kTetrahedra],
                 v[dimension::kLinearModes],     v[dimension::kModes],
                 v[dimension::kFixed],           v[dimension::kRigid],
                 v[dimension::kSurfaceVertices], v[dimension::kTriangles]};
  const BasisDimensions& d = dimensions_;
  if (d.modes == 0 || d.modes > kMaxModes || d.vertices == 0 || d.vertices > kMaxVertices ||
      d.surface_vertices > d.vertices || d.fixed > d.vertices || d.triangles > 4 * kMaxVertices)
    return file_.error_at(kDimensions, section->offset, "the dimensions are out of range");
  return Success{};
}

// A section that is missing counts as empty here.
SectionSizes BasisReader::sizes() const {
  const auto rows_of = [this](std::string_view name) {
    const BasisSection* section = file_.find(name);
    return section != nullptr ? section->rows : 0;
  };
  const BasisDimensions& d = dimensions_;
  return {.modes = d.modes,
          .surface_vertices = d.surface_vertices,
          .interior_vertices = d.vertices - d.surface_vertices,
          .triangles = d.triangles,
          .fixed = d.fixed,
          .loaded = rows_of(kLoadIds),
          .render_vertices = rows_of(kRenderRest),
          .render_triangles = rows_of(kRenderTriangles),
          .edges = rows_of(kEdgePoints),
          .tetrahedra = d.tetrahedra,
          .response_places = rows_of(kResponseAt),
          .compact = compact(),
          .linear = has(kQuartic) && linear()};
}

Status BasisReader::check_shapes() const {
  const auto refuse = [this](const std::string& what) {
    return file_.error_at("table", kHeaderSize, what);
  };
  const SectionSizes expected = sizes();
  if (expected.edges > dimensions_.vertices) return refuse("there are more edges than vertices");
  if (expected.render_vertices > kMaxVertices || expected.render_triangles > 4 * kMaxVertices)
    return refuse("the render surface is too large");
  if (expected.response_places > kMaxResponsePlaces)
    return refuse("there are more than " + std::to_string(kMaxResponsePlaces) +
                  " places whose response is kept");
  if (Status status = file_.check_shapes(section_shapes(expected)); !status) return status;
  if (const BasisSection* at = file_.find(kResponseAt); at != nullptr && at->rows == 0)
    return file_.error_at(kResponseAt, at->offset, "a response at no place");
  if (const BasisSection* edges = file_.find(kEdgePoints); edges != nullptr && edges->rows == 0)
    return file_.error_at(kEdgePoints, edges->offset, "quadratic elements without edges");
  if (const BasisSection* render = file_.find(kRenderRest); render != nullptr && render->rows == 0)
    return file_.error_at(kRenderRest, render->offset, "a render surface without vertices");
  return Success{};
}

}  // namespace tremolo
