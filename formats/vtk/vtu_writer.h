// Modes for ParaView and meshio: a VTU file (VTK XML unstructured grid) with a vector a point for
// every mode. Needs no XML library.
#pragma once

#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "common/result.h"
#include "formats/basis/basis_data.h"

namespace tremolo {

// points: rest positions, m. rows: 3 x points rows, r columns, kg^-1/2. lambda: r, (rad/s)^2.
// Point data `mode_01`, `mode_02`, ...: the columns; a displacement is one of them times its
// coordinate, kg^1/2 m. Field data `frequency_hz`: r numbers. Arrays are f64 in base64, inside
// their elements. Errors: kSystem of the file.
Status write_modes_vtu(const std::string& path, const std::vector<Eigen::Vector3d>& points,
                       std::span<const Tetrahedron> cells, const BasisRows& rows,
                       const Eigen::VectorXd& lambda);
// Quadratic tetrahedra: corners, then the middles of the edges 01, 12, 02, 03, 13, 23.
using QuadraticCell = std::array<VertexId, 10>;
// Those of a mesh with edge points.
std::vector<QuadraticCell> quadratic_cells(const TetMesh& mesh);
Status write_modes_vtu(const std::string& path, const std::vector<Eigen::Vector3d>& points,
                       std::span<const QuadraticCell> cells, const BasisRows& rows,
                       const Eigen::VectorXd& lambda);
Status write_modes_vtu(const std::string& path, const std::vector<Eigen::Vector3d>& points,
                       std::span<const Triangle> cells, const BasisRows& rows,
                       const Eigen::VectorXd& lambda);

// Writes triangles with displacements. points, displacements: x y z x y z ..., m, f32 in the file;
// displacements is the point data of that name. Errors: kSystem.
Status write_moved_vtu(const std::string& path, std::span<const float> points,
                       std::span<const Triangle> triangles, std::span<const float> displacements);

}  // namespace tremolo
