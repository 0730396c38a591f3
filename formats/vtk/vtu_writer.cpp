#include "formats/vtk/vtu_writer.h"

#include <cmath>
#include <cstdint>
#include <cstring>
#include <numbers>

#include "formats/file/atomic_file.h"
#include "formats/file/base64.h"
#include "formats/file/stored_values.h"

namespace tremolo {
namespace {

// VTK's numbers of the kinds (vtkCellType.h).
constexpr std::uint8_t kTriangle = 5;
constexpr std::uint8_t kTetrahedron = 10;
constexpr std::uint8_t kQuadraticTetrahedron = 24;

constexpr const char* kVtuHead =
    "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" "
    "byte_order=\"LittleEndian\" header_type=\"UInt64\">\n<UnstructuredGrid>\n";
constexpr const char* kVtuEnd = "</Piece>\n</UnstructuredGrid>\n</VTKFile>\n";

struct Cells {
  std::span<const VertexId> nodes;
  std::size_t nodes_of_one;
  std::uint8_t type;
  std::size_t count() const { return nodes.size() / nodes_of_one; }
};

// One DataArray: the number of its bytes and the bytes, together in base64.
template <class T>
Status write_array(AtomicFile& file, const std::string& attributes, std::span<const T> values) {
  std::string bytes;
  append_bytes(bytes, std::uint64_t{values.size_bytes()});
  append_bytes(bytes, values.data(), values.size());
  Status status = file.write("<DataArray " + attributes + " format=\"binary\">");
  if (status) status = file.write(encode_base64(bytes));
  if (status) status = file.write("</DataArray>\n");
  return status;
}

std::string mode_name(Eigen::Index mode, Eigen::Index modes) {
  const std::string number = std::to_string(mode + 1);
  const std::size_t width = std::max<std::size_t>(2, std::to_string(modes).size());
  return "mode_" + std::string(width - number.size(), '0') + number;
}

Status write_frequencies(AtomicFile& file, const Eigen::VectorXd& lambda) {
  const Eigen::VectorXd hertz = lambda.cwiseSqrt() / (2.0 * std::numbers::pi);
  Status status = file.write("<FieldData>\n");
  if (status)
    status = write_array(file,
                         "type=\"Float64\" Name=\"frequency_hz\" NumberOfTuples=\"" +
                             std::to_string(hertz.size()) + "\"",
                         std::span(hertz.data(), hertz.size()));
  if (status) status = file.write("</FieldData>\n");
  return status;
}

Status write_modes(AtomicFile& file, const BasisRows& rows) {
  Status status = file.write("<PointData>\n");
  for (Eigen::Index mode = 0; status && mode < rows.cols(); ++mode) {
    const Eigen::VectorXd column = rows.col(mode);
    status = write_array(
        file,
        "type=\"Float64\" Name=\"" + mode_name(mode, rows.cols()) + "\" NumberOfComponents=\"3\"",
        std::span(column.data(), column.size()));
  }
  if (status) status = file.write("</PointData>\n");
  return status;
}

Status write_cells(AtomicFile& file, const Cells& cells) {
  std::vector<std::int64_t> offsets(cells.count());
  for (std::size_t c = 0; c < offsets.size(); ++c) offsets[c] = (c + 1) * cells.nodes_of_one;
  const std::vector<std::uint8_t> types(cells.count(), cells.type);
  Status status = file.write("<Cells>\n");
  if (status) status = write_array(file, "type=\"Int32\" Name=\"connectivity\"", cells.nodes);
  if (status)
    status = write_array(file, "type=\"Int64\" Name=\"offsets\"",
                         std::span<const std::int64_t>(offsets));
  if (status)
    status =
        write_array(file, "type=\"UInt8\" Name=\"types\"", std::span<const std::uint8_t>(types));
  if (status) status = file.write("</Cells>\n");
  return status;
}

Status write_vtu(const std::string& path, const std::vector<Eigen::Vector3d>& points,
                 const Cells& cells, const BasisRows& rows, const Eigen::VectorXd& lambda) {
  static_assert(sizeof(Eigen::Vector3d) == 3 * sizeof(double));
  Result<AtomicFile> created = AtomicFile::create(path);
  if (!created) return created.error();
  AtomicFile& file = *created;
  Status status = file.write(kVtuHead);
  if (status) status = write_frequencies(file, lambda);
  if (status)
    status = file.write("<Piece NumberOfPoints=\"" + std::to_string(points.size()) +
                        "\" NumberOfCells=\"" + std::to_string(cells.count()) + "\">\n");
  if (status) status = write_modes(file, rows);
  if (status) status = file.write("<Points>\n");
  if (status)
    status = write_array(file, "type=\"Float64\" Name=\"Points\" NumberOfComponents=\"3\"",
                         std::span<const double>(points.empty() ? nullptr : points.front().data(),
                                                 3 * points.size()));
  if (status) status = file.write("</Points>\n");
  if (status) status = write_cells(file, cells);
  if (status) status = file.write(kVtuEnd);
  return status ? file.commit() : status;
}

// The corners of all cells, in order.
template <class Cell>
std::span<const VertexId> corners(std::span<const Cell> cells) {
  static_assert(sizeof(Cell) == std::tuple_size_v<Cell> * sizeof(VertexId));
  return {cells.empty() ? nullptr : cells.front().data(), cells.size() * std::tuple_size_v<Cell>};
}

}  // namespace

std::vector<QuadraticCell> quadratic_cells(const TetMesh& mesh) {
  constexpr std::size_t kOrder[6] = {0, 3, 1, 2, 4, 5};  // ours of VTK's 01, 12, 02, 03, 13, 23
  std::vector<QuadraticCell> cells;
  for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t) {
    QuadraticCell cell;
    for (std::size_t c = 0; c < 4; ++c) cell[c] = mesh.tetrahedra[t][c];
    for (std::size_t e = 0; e < 6; ++e) cell[4 + e] = mesh.edge_points[t][kOrder[e]];
    cells.push_back(cell);
  }
  return cells;
}

Status write_modes_vtu(const std::string& path, const std::vector<Eigen::Vector3d>& points,
                       std::span<const Tetrahedron> cells, const BasisRows& rows,
                       const Eigen::VectorXd& lambda) {
  return write_vtu(path, points, {corners(cells), 4, kTetrahedron}, rows, lambda);
}

Status write_modes_vtu(const std::string& path, const std::vector<Eigen::Vector3d>& points,
                       std::span<const QuadraticCell> cells, const BasisRows& rows,
                       const Eigen::VectorXd& lambda) {
  return write_vtu(path, points, {corners(cells), 10, kQuadraticTetrahedron}, rows, lambda);
}

Status write_modes_vtu(const std::string& path, const std::vector<Eigen::Vector3d>& points,
                       std::span<const Triangle> cells, const BasisRows& rows,
                       const Eigen::VectorXd& lambda) {
  return write_vtu(path, points, {corners(cells), 3, kTriangle}, rows, lambda);
}

Status write_moved_vtu(const std::string& path, std::span<const float> points,
                       std::span<const Triangle> triangles, std::span<const float> displacements) {
  Result<AtomicFile> created = AtomicFile::create(path);
  if (!created) return created.error();
  AtomicFile& file = *created;
  const Cells cells{corners(triangles), 3, kTriangle};
  Status status = file.write(kVtuHead);
  if (status)
    status = file.write("<Piece NumberOfPoints=\"" + std::to_string(points.size() / 3) +
                        "\" NumberOfCells=\"" + std::to_string(cells.count()) +
                        "\">\n<PointData Vectors=\"displacement\">\n");
  if (status)
    status = write_array(file, "type=\"Float32\" Name=\"displacement\" NumberOfComponents=\"3\"",
                         displacements);
  if (status) status = file.write("</PointData>\n<Points>\n");
  if (status)
    status = write_array(file, "type=\"Float32\" Name=\"Points\" NumberOfComponents=\"3\"", points);
  if (status) status = file.write("</Points>\n");
  if (status) status = write_cells(file, cells);
  if (status) status = file.write(kVtuEnd);
  return status ? file.commit() : status;
}

}  // namespace tremolo
