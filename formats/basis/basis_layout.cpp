#include "formats/basis/basis_layout.h"

#include "common/packed_index.h"

namespace tremolo::basis_layout {

std::vector<SectionShape> section_shapes(const SectionSizes& sizes) {
  constexpr ElementType u8 = ElementType::kU8, u32 = ElementType::kU32, u64 = ElementType::kU64,
                        f32 = ElementType::kF32, f64 = ElementType::kF64;
  const ElementType coefficient = sizes.compact ? f32 : f64;
  const ElementType basis = sizes.compact ? ElementType::kI16 : f64;
  const auto& [r, s, inner, t, fixed, l, v, w, edges, m, p, compact, linear] = sizes;
  const std::uint64_t cubic = linear ? 0 : triple_count(r);
  const std::uint64_t quartic = linear ? 0 : quad_count(r);
  const std::uint64_t strains = pair_count(strain_terms(r));
  constexpr bool yes = true, no = false;
  return {
      {kDimensions, u64, dimension::kCount, 1, yes},
      {kTotalMass, f64, 1, 1},
      {kLambda, f64, r, 1, yes},
      {kCoefficientScales, f64, coefficient_scale::kCount, 1, compact, kBasisScales},
      {kBasisScales, f64, r, 1, compact, kCoefficientScales},
      {kCubic, coefficient, cubic, 1, yes},
      {kQuartic, coefficient, quartic, 1, yes},
      {kEdgePoints, u32, edges, 3, edges > 0},
      {kStrainScale, f64, 1, 1, no, kStrainGram},
      {kStrainGram, coefficient, strains, 1, no, compact ? kStrainScale : kStrainGram},
      {kLoadIds, u32, l, 1, no, kLoadForces},
      {kLoadForces, f64, l, 3, no, kLoadIds},
      {kSurfaceIds, u32, s, 1, yes},
      {kTriangles, u32, t, 3, yes},
      {kSurfaceRest, f64, s, 3, yes},
      {kSurfaceBasis, basis, 3 * s, r, yes},
      {kInertiaRest, f64, kRestMoments, 1, no, kInertiaLinear},
      {kInertiaLinear, f64, r, 12, no, kInertiaPairs},
      {kInertiaPairs, f64, pair_count(r), 9, no, kInertiaRest},
      {kTetrahedra, u32, m, 4, no, kTetrahedronMasses},
      {kTetrahedronMasses, f64, m, 1, no, kTetrahedra},
      // The first eight of the render surface need each other in a circle.
      {kRenderRest, f64, v, 3, no, kRenderBasis},
      {kRenderBasis, basis, 3 * v, r, no, kRenderAnchors},
      {kRenderAnchors, u32, v, 1, no, kRenderTriangles},
      {kRenderTriangles, u32, w, 3, no, kRenderObjects},
      {kRenderObjects, u32, w, 1, no, kRenderMaterials},
      {kRenderMaterials, u32, w, 1, no, kObjectNames},
      {kObjectNames, u8, kAnyRows, 1, no, kMaterialNames},
      {kMaterialNames, u8, kAnyRows, 1, no, kRenderRest},
      {kRenderNormals, f32, v, 3, no, kRenderRest},
      {kRenderUvs, f32, v, 2, no, kRenderRest},
      {kRenderColours, u8, v, 4, no, kRenderRest},
      {kRenderSources, u32, v, 1, no, kRenderRest},
      {kBoneNames, u8, kAnyRows, 1, no, kBoneParents},
      {kBoneParents, u32, kAnyRows, 1, no, kBoneEnds},
      {kBoneEnds, f64, kAnyRows, 6, no, kSkinPlaces},
      {kSkinPlaces, u32, kAnyRows, 2, no, kSkinWeights},
      {kSkinWeights, f32, kAnyRows, 1, no, kBoneNames},
      {kClipNames, u8, kAnyRows, 1, no, kClipFrames},
      {kClipFrames, u32, kAnyRows, 1, no, kClipTimes},
      {kClipTimes, f64, kAnyRows, 1, no, kClipPoses},
      {kClipPoses, f64, kAnyRows, 7, no, kBoneNames},
      {kInteriorIds, u32, inner, 1},
      {kInteriorRest, f64, inner, 3},
      {kInteriorBasis, basis, 3 * inner, r},
      {kResponseAt, u32, p, 1, no, kResponseSurface},
      {kResponseSurface, f64, 3 * s, 3 * p, no, kResponseAt},
      {kResponseRender, f64, 3 * v, 3 * p, no, kResponseAt},
      {kResponseInterior, f64, 3 * inner, 3 * p, no, kResponseAt},
      {kFixedIds, u32, fixed, 1},
      {kSingularValues, f64, kAnyRows, 1},
      {kProvenance, u8, kAnyRows, 1},
      {kVegaBasis, u8, kAnyRows, 1},
      {kVegaCubic, u8, kAnyRows, 1},
  };
}

}  // namespace tremolo::basis_layout
