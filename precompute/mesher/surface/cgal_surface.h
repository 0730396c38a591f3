// Our surfaces as CGAL's.
#pragma once

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Surface_mesh.h>

#include "common/mesh/surface_mesh.h"

namespace tremolo::cgal {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using SurfaceMesh = CGAL::Surface_mesh<Kernel::Point_3>;

// False if the triangles are not a two-manifold that agrees on its orientation.
bool copy(const tremolo::SurfaceMesh& surface, SurfaceMesh& out);

}  // namespace tremolo::cgal
