// Triangles of a collider, in its own frame.
#pragma once

#include "common/result.h"
#include "runtime/contact/collider.h"
#include "runtime/viewer/shape/triangle_shape.h"

namespace tremolo {

// A ball with its centre at the origin. radius: m.
TriangleShape ball_shape(double radius);

// A disc in the plane z = 0 that faces up. radius: m.
TriangleShape disc_shape(double radius);

// The shape's surface; of a plane a disc of radius `plane_radius`, m; of a grid the surface where
// its distance is zero (runtime/viewer/shape/iso_surface.h), since a collider file keeps no
// triangles.
TriangleShape collider_shape(const Collider& collider, double plane_radius);

}  // namespace tremolo
