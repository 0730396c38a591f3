// The bytes of a basis file, versions 1.0 to 1.4, that are its own. docs/basis-format.md is the
// same in prose; change both or neither.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include "formats/sections/section_layout.h"

namespace tremolo::basis_layout {

using namespace section_layout;

inline constexpr std::uint16_t kMajor = 1;
inline constexpr FileKind kKind = {
    {'T', 'R', 'E', 'M', 'O', 'L', 'O', '\0'}, kMajor, "a basis file"};
inline constexpr std::uint16_t kMinor = 0;  // of a full file
// Version of a compact or a linear file: a reader of 1.0 refuses it for its new sections.
inline constexpr std::uint16_t kMinorEncoded = 1;
// Version of a file with a render surface, whatever else it is.
inline constexpr std::uint16_t kMinorRender = 2;
// Version of a file of quadratic elements, whatever else it is.
inline constexpr std::uint16_t kMinorQuadratic = 3;
// Version of a file with the strains' Gram matrix, whatever else it is.
inline constexpr std::uint16_t kMinorStrains = 4;

// Section names; basis_layout.cpp has their types and shapes.
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
// An imported model keeps the files .U and .cub that it was made of, byte for byte.
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
// Optional, of any version with a render surface: its vertices in the author's file.
inline constexpr std::string_view kRenderSources = "render_sources";
// Optional as well: the skeleton of the author's file (formats/surface/flat_rig.h).
inline constexpr std::string_view kBoneNames = "bone_names";
inline constexpr std::string_view kBoneParents = "bone_parents";
inline constexpr std::string_view kBoneEnds = "bone_ends";
inline constexpr std::string_view kSkinPlaces = "skin_places";
inline constexpr std::string_view kSkinWeights = "skin_weights";
inline constexpr std::string_view kClipNames = "clip_names";
inline constexpr std::string_view kClipFrames = "clip_frames";
inline constexpr std::string_view kClipTimes = "clip_times";
inline constexpr std::string_view kClipPoses = "clip_poses";
// Of a skeleton without a parent.
inline constexpr std::uint32_t kNoBone = 0xffffffff;

// Version 1.3, of quadratic elements.
inline constexpr std::string_view kEdgePoints = "edge_points";

// Version 1.4, of stiffness damping.
inline constexpr std::string_view kStrainGram = "strain_gram";
inline constexpr std::string_view kStrainScale = "strain_scale";  // of a compact file

// Optional ones of any version: the body in a moving frame.
inline constexpr std::string_view kInertiaRest = "inertia_rest";
inline constexpr std::string_view kInertiaLinear = "inertia_linear";
inline constexpr std::string_view kInertiaPairs = "inertia_pairs";
// Optional too: the tetrahedra and their masses, for bodies whose mass is divided among bones.
inline constexpr std::string_view kTetrahedra = "tetrahedra";
inline constexpr std::string_view kTetrahedronMasses = "tetra_masses";

// Optional too: the response of the body to forces at some points, as far as the basis does not
// represent it.
inline constexpr std::string_view kResponseAt = "response_at";
inline constexpr std::string_view kResponseSurface = "response_surface";
inline constexpr std::string_view kResponseInterior = "response_inside";
inline constexpr std::string_view kResponseRender = "response_render";

// Entry of the section `response_at` for the default load.
inline constexpr std::uint32_t kDefaultLoadPlace = 0xffffffff;

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

// Limits above all files that this program writes; they keep every product of two sizes inside 64
// bits.
inline constexpr std::uint64_t kMaxModes = 4096;
inline constexpr std::uint64_t kMaxVertices = 0x7fffffff;
inline constexpr std::uint64_t kMaxResponsePlaces = 256;

}  // namespace tremolo::basis_layout

namespace tremolo::basis_layout {

// Which sections a basis file has, of which type and shape: the reader checks a file by this table,
// the writer writes by it, and docs/basis-format.md is the same in prose.

// The numbers of one file that its shapes are made of.
struct SectionSizes {
  std::uint64_t modes = 0;              // r
  std::uint64_t surface_vertices = 0;   // s
  std::uint64_t interior_vertices = 0;  // n - s
  std::uint64_t triangles = 0;          // t
  std::uint64_t fixed = 0;
  std::uint64_t loaded = 0;            // l, vertices of the default load
  std::uint64_t render_vertices = 0;   // v
  std::uint64_t render_triangles = 0;  // w
  std::uint64_t edges = 0;             // of a quadratic mesh
  std::uint64_t tetrahedra = 0;        // m
  std::uint64_t response_places = 0;   // p
  bool compact = false;                // coefficients are f32, basis rows i16
  bool linear = false;                 // there are no cubic and no quartic terms
};

// All possible sections in the order of writing: those that a runtime reads come first, the
// interior and the provenance last. The sizes are at most kMaxModes and four times kMaxVertices.
std::vector<SectionShape> section_shapes(const SectionSizes& sizes);

}  // namespace tremolo::basis_layout
