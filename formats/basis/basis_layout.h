// The bytes of a basis file, versions 1.0 to 1.3. docs/basis-format.md is the same in prose;
// change both or neither.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace tremolo::basis_layout {

inline constexpr std::array<char, 8> kMagic = {'T', 'R', 'E', 'M', 'O', 'L', 'O', '\0'};
inline constexpr std::uint16_t kMajor = 1;  // a reader refuses another major
inline constexpr std::uint16_t kMinor = 0;  // of a full file
// Of a compact or a linear file: what is new in it makes a reader of 1.0 refuse it.
inline constexpr std::uint16_t kMinorEncoded = 1;
// Of a file with a render surface, whatever else it is.
inline constexpr std::uint16_t kMinorRender = 2;
// Of a file of quadratic elements, whatever else it is.
inline constexpr std::uint16_t kMinorQuadratic = 3;
inline constexpr std::size_t kAlignment = 64;
// Where the next section may begin, behind one that ends at `offset`.
constexpr std::size_t aligned(std::size_t offset) {
  return (offset + kAlignment - 1) / kAlignment * kAlignment;
}
inline constexpr std::uint32_t kMaxSections = 256;

// Header, 64 bytes at offset 0; everything little-endian.
inline constexpr std::size_t kHeaderSize = 64;
namespace header {
inline constexpr std::size_t kMagicAt = 0;        // 8 characters
inline constexpr std::size_t kMajorAt = 8;        // u16
inline constexpr std::size_t kMinorAt = 10;       // u16
inline constexpr std::size_t kSectionsAt = 12;    // u32, number of table entries
inline constexpr std::size_t kFileSizeAt = 16;    // u64, bytes of the whole file
inline constexpr std::size_t kTableHashAt = 24;   // u64, XXH3-64 of the table
inline constexpr std::size_t kReservedAt = 32;    // 24 bytes, zero
inline constexpr std::size_t kHeaderHashAt = 56;  // u64, XXH3-64 of bytes 0..55
}  // namespace header

// Table: one 64-byte entry a section, directly behind the header.
inline constexpr std::size_t kEntrySize = 64;
namespace entry {
inline constexpr std::size_t kNameAt = 0;      // 16 characters, padded with zeros
inline constexpr std::size_t kTypeAt = 16;     // u32, ElementType
inline constexpr std::size_t kFlagsAt = 20;    // u32, bit 0: critical; others zero
inline constexpr std::size_t kOffsetAt = 24;   // u64, from the start of the file, multiple of 64
inline constexpr std::size_t kSizeAt = 32;     // u64, bytes = rows * columns * element size
inline constexpr std::size_t kRowsAt = 40;     // u64
inline constexpr std::size_t kColumnsAt = 48;  // u64
inline constexpr std::size_t kHashAt = 56;     // u64, XXH3-64 of the section's bytes
}  // namespace entry
inline constexpr std::size_t kNameSize = 16;
inline constexpr std::uint32_t kCritical = 1;

// kF32 and kI16 are of version 1.1.
enum class ElementType : std::uint32_t {
  kU8 = 1,
  kU32 = 2,
  kU64 = 3,
  kF64 = 4,
  kF32 = 5,
  kI16 = 6
};

// Bytes of one element; 0 for an unknown type.
constexpr std::size_t element_size(ElementType type) {
  switch (type) {
    case ElementType::kU8:
      return 1;
    case ElementType::kI16:
      return 2;
    case ElementType::kF32:
    case ElementType::kU32:
      return 4;
    case ElementType::kU64:
    case ElementType::kF64:
      return 8;
  }
  return 0;
}

// The element type of which a section's values are in memory.
template <class T>
inline constexpr ElementType kTypeOf{};
template <>
inline constexpr ElementType kTypeOf<std::uint8_t> = ElementType::kU8;
template <>
inline constexpr ElementType kTypeOf<std::uint32_t> = ElementType::kU32;
template <>
inline constexpr ElementType kTypeOf<std::uint64_t> = ElementType::kU64;
template <>
inline constexpr ElementType kTypeOf<double> = ElementType::kF64;
template <>
inline constexpr ElementType kTypeOf<float> = ElementType::kF32;
template <>
inline constexpr ElementType kTypeOf<std::int16_t> = ElementType::kI16;

// Section names; basis_sections.cpp has their types and shapes.
inline constexpr std::string_view kDimensions = "dimensions";
inline constexpr std::string_view kTotalMass = "total_mass";
inline constexpr std::string_view kLambda = "lambda";
inline constexpr std::string_view kCubic = "cubic";
inline constexpr std::string_view kQuartic = "quartic";
inline constexpr std::string_view kSurfaceIds = "surface_ids";
inline constexpr std::string_view kSurfaceRest = "surface_rest";
inline constexpr std::string_view kSurfaceBasis = "surface_basis";
inline constexpr std::string_view kTriangles = "triangles";
inline constexpr std::string_view kInteriorIds = "interior_ids";
inline constexpr std::string_view kInteriorRest = "interior_rest";
inline constexpr std::string_view kInteriorBasis = "interior_basis";
inline constexpr std::string_view kFixedIds = "fixed_ids";
inline constexpr std::string_view kLoadIds = "load_ids";
inline constexpr std::string_view kLoadForces = "load_forces";
inline constexpr std::string_view kSingularValues = "singular_values";
inline constexpr std::string_view kProvenance = "provenance";
// Of an imported model: the files .U and .cub that it was made of, byte for byte.
inline constexpr std::string_view kVegaBasis = "vega_basis";
inline constexpr std::string_view kVegaCubic = "vega_cubic";

// Version 1.1, of a compact file.
inline constexpr std::string_view kCoefficientScales = "coef_scales";
inline constexpr std::string_view kBasisScales = "basis_scales";

// Version 1.2, the render surface.
inline constexpr std::string_view kRenderRest = "render_rest";
inline constexpr std::string_view kRenderBasis = "render_basis";
inline constexpr std::string_view kRenderAnchors = "render_anchors";
inline constexpr std::string_view kRenderTriangles = "render_faces";
inline constexpr std::string_view kRenderObjects = "render_object";
inline constexpr std::string_view kRenderMaterials = "render_material";
inline constexpr std::string_view kObjectNames = "object_names";
inline constexpr std::string_view kMaterialNames = "material_names";
inline constexpr std::string_view kRenderNormals = "render_normals";
inline constexpr std::string_view kRenderUvs = "render_uvs";
inline constexpr std::string_view kRenderColours = "render_colours";

// Version 1.3, of quadratic elements.
inline constexpr std::string_view kEdgePoints = "edge_points";

// Optional ones of any version: the body in a moving frame.
inline constexpr std::string_view kInertiaRest = "inertia_rest";
inline constexpr std::string_view kInertiaLinear = "inertia_linear";
inline constexpr std::string_view kInertiaPairs = "inertia_pairs";

// Entries of the section `coef_scales`, in this order.
namespace coefficient_scale {
enum : std::size_t { kCubic, kQuartic, kCount };
}  // namespace coefficient_scale

// Entries of the section `dimensions`, in this order.
namespace dimension {
enum : std::size_t {
  kVertices,         // n
  kTetrahedra,       // m
  kLinearModes,      // k
  kModes,            // r
  kFixed,            // fixed vertices
  kRigid,            // rigid modes left out
  kSurfaceVertices,  // s
  kTriangles,        // t
  kCount
};
}  // namespace dimension

// Entries of the section `inertia_rest`: mass, first moment (3), second moment (3 x 3).
inline constexpr std::uint64_t kRestMoments = 13;

// Above these no file of ours goes; they keep every product of two sizes inside 64 bits.
inline constexpr std::uint64_t kMaxModes = 4096;
inline constexpr std::uint64_t kMaxVertices = 0x7fffffff;

}  // namespace tremolo::basis_layout
