// Reads basis files as values. The files are untrusted (formats/sections/section_file.h).
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/result.h"
#include "formats/basis/basis_data.h"
#include "formats/basis/basis_layout.h"
#include "formats/sections/section_file.h"

namespace tremolo {

using BasisSection = FileSection;

// The section `dimensions`.
struct BasisDimensions {
  std::uint64_t vertices = 0;      // n
  std::uint64_t tetrahedra = 0;    // m
  std::uint64_t linear_modes = 0;  // k
  std::uint64_t modes = 0;         // r
  std::uint64_t fixed = 0;
  std::uint64_t rigid = 0;
  std::uint64_t surface_vertices = 0;  // s
  std::uint64_t triangles = 0;         // t
};

// An open basis file: open() checks header, table and dimensions; a section is checked and its
// checksum verified when it is first requested. Errors are kContent and give the section, the
// offset, the expected and the found value; kSystem if the file cannot be read. The caller must
// lock it for reading from several threads.
class BasisReader {
 public:
  // Maps the file: only the pages in use are read.
  static Result<BasisReader> open(const std::string& path);
  // Borrows the bytes: they must outlive the reader and whatever it returns. `name` is for errors.
  static Result<BasisReader> from_memory(std::span<const std::byte> bytes,
                                         std::string name = "memory");

  const BasisDimensions& dimensions() const { return dimensions_; }
  const std::vector<BasisSection>& sections() const { return file_.sections(); }
  std::uint16_t minor_version() const { return file_.minor_version(); }
  bool has(std::string_view section) const { return file_.has(section); }
  // Coefficients are f32 and basis rows 16 bits with a scale a column, else everything is f64.
  bool compact() const { return has(basis_layout::kBasisScales); }
  // `cubic` and `quartic` are there but empty: V has no such terms.
  bool linear() const { return file_.find(basis_layout::kQuartic)->rows == 0; }

  // The verified contents, as stored in the file. Doubles are finite. Valid while the reader
  // exists. A missing optional section is an error here: call has() first.
  Result<std::span<const double>> doubles(std::string_view section);
  // `cubic` or `quartic` as doubles, whatever the encoding.
  Result<std::vector<double>> coefficients(std::string_view section);
  // The Gram matrix of the strains as in BasisData, whatever the encoding; empty if the file has
  // none. No entry of its diagonal is negative.
  Result<std::vector<double>> strain_gram();
  // Ids, each below `bound`.
  Result<std::span<const std::uint32_t>> indices(std::string_view section, std::uint64_t bound);
  Result<std::string_view> text(std::string_view section);
  // Finite floats, and bytes.
  Result<std::span<const float>> floats(std::string_view section);
  Result<std::span<const std::uint8_t>> bytes(std::string_view section);
  // Points of three coordinates each, finite.
  Result<std::vector<Eigen::Vector3d>> points(std::string_view section);
  // Triples of indices below `bound`.
  Result<std::vector<Triangle>> triangles(std::string_view section, std::uint64_t bound);

  // A block of vertices: `ids`, `rest` and `basis` are section names. All columns of the basis, as
  // doubles whatever the encoding.
  Result<VertexBlock> vertex_block(std::string_view ids, std::string_view rest,
                                   std::string_view basis);
  // Order of the elements that the model was made of: 2 if the file has edge points.
  int order() const { return has(basis_layout::kEdgePoints) ? 2 : 1; }

  // The rows of a basis alone, in the same form.
  Result<BasisRows> basis_rows(std::string_view basis);
  // r, of a compact file; else none.
  Result<Eigen::VectorXd> column_scales();

  // The checksum of every section, used or not.
  Status verify_all() { return file_.verify_all(); }

 private:
  explicit BasisReader(SectionFile file) : file_(std::move(file)) {}
  static Result<BasisReader> checked(Result<SectionFile> file);
  Status read_dimensions();
  basis_layout::SectionSizes sizes() const;
  Status check_shapes() const;
  Result<std::span<const double>> scales(std::string_view section);

  SectionFile file_;
  BasisDimensions dimensions_;
};

// Parts of the file, checked beyond their shape: lambda is positive and ascending.
Result<Eigen::VectorXd> read_lambda(BasisReader& reader);
// The boundary, indices into the ids of the surface's block.
Result<std::vector<Triangle>> read_triangles(BasisReader& reader);
Result<DefaultLoad> read_default_load(BasisReader& reader);
// Ascending by their points; none of a model of linear elements.
Result<std::vector<MeshEdge>> read_edges(BasisReader& reader);
// nullopt: the file has none. Errors also for an index out of range and names without an end.
Result<std::optional<RenderBlock>> read_render(BasisReader& reader);
Result<std::optional<InertiaIntegrals>> read_inertia(BasisReader& reader);

// Empty if the file has none. kContent for an index out of range or a mass that is not positive.
Result<MassElements> read_elements(BasisReader& reader);

// Without the rows of the inner vertices; no points if the file has none. kContent for a point that
// is not a vertex or not unique, or at the default load if there is none.
Result<LocalResponse> read_response(BasisReader& reader);
// Those of the vertices inside; the file must have a response.
Result<BasisRows> read_response_inside(BasisReader& reader);

// The files of an imported model; empty for another model.
Result<VegaFiles> read_vega_files(BasisReader& reader);

// Everything in the file except the files of an imported model, which only an export needs.
Result<BasisData> read_basis(BasisReader& reader);
Result<BasisData> read_basis(const std::string& path);

}  // namespace tremolo
