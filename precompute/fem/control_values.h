// Control values of a quadratic field and its values in the mesh's points (common/mesh/
// edge_points.h): they differ at the edge points, u_m = (c_a + 2 c_ab + c_b) / 4. Files and reports
// have displacements of points; matrices, forces and element loops have control values.
#pragma once

#include "common/mesh/edge_points.h"
#include "formats/basis/basis_data.h"

namespace tremolo {

// Turn control values into displacements, and back. rows: 3n x any number of columns, in the order
// of the mesh's vertices. A linear mesh's rows stay as they are.
void to_displacements(const TetMesh& mesh, BasisRows& rows);
void to_control_values(const TetMesh& mesh, BasisRows& rows);

}  // namespace tremolo
