// The colours of bodies, as --colour names them.
#pragma once

namespace tremolo {

// Their own; the distance of each vertex from its rest position in the body's frame; von Mises'
// stress (runtime/apps/view/shape/surface_stress.h); or the fraction of quadratic edges of
// tetrahedra. The frame of cloths and of tetrahedra is the pose nearest to all of their vertices.
// Bodies on bones keep their own colours, as do those without a known material with kStress, and
// all but bodies of tetrahedra with kDegree.
enum class ColourBy { kBody, kMoved, kStress, kDegree };

}  // namespace tremolo
