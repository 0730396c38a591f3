#include "precompute/problem/mechanisms.h"

#include <algorithm>
#include <map>
#include <numeric>

#include "common/mesh/tet_faces.h"
#include "common/union_find.h"
#include "precompute/dense/dense_decompositions.h"

namespace tremolo {
namespace {

// A piece as a rigid body: a point x moves with velocity t + w x (x - middle) / size.
struct Body {
  int piece = 0;
  int tetrahedra = 0;
  std::vector<VertexId> vertices;  // ascending
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  double size = 0;

  Eigen::Matrix<double, 3, 6> velocity(const Eigen::Vector3d& at) const {
    const Eigen::Vector3d x = (at - middle) / size;
    Eigen::Matrix<double, 3, 6> matrix;
    matrix << 1, 0, 0, 0, x.z(), -x.y(), 0, 1, 0, -x.z(), 0, x.x(), 0, 0, 1, x.y(), -x.x(), 0;
    return matrix;
  }
};

// tetrahedra: those of the piece.
Body make_body(const TetMesh& mesh, int piece, const std::vector<int>& tetrahedra) {
  Body body;
  body.piece = piece;
  body.tetrahedra = static_cast<int>(tetrahedra.size());
  for (int t : tetrahedra)
    body.vertices.insert(body.vertices.end(), mesh.tetrahedra[t].begin(), mesh.tetrahedra[t].end());
  std::sort(body.vertices.begin(), body.vertices.end());
  body.vertices.erase(std::unique(body.vertices.begin(), body.vertices.end()), body.vertices.end());
  for (VertexId v : body.vertices) body.middle += mesh.vertices[v];
  body.middle /= static_cast<double>(body.vertices.size());
  for (VertexId v : body.vertices)
    body.size = std::max(body.size, (mesh.vertices[v] - body.middle).norm());
  return body;
}

constexpr int kGround = -1;
// The vertices shared by each pair of bodies a < b.
using Contacts = std::map<std::pair<int, int>, std::vector<VertexId>>;

// Finds the vertices that bodies share; the fixed vertices count as shared with the ground.
Contacts find_contacts(const std::vector<Body>& bodies, const std::vector<VertexId>& fixed) {
  std::map<VertexId, std::vector<int>> owners;
  for (std::size_t b = 0; b < bodies.size(); ++b)
    for (VertexId v : bodies[b].vertices) {
      std::vector<int>& list = owners[v];
      if (list.empty() && std::binary_search(fixed.begin(), fixed.end(), v))
        list.push_back(kGround);
      list.push_back(static_cast<int>(b));
    }
  Contacts contacts;
  for (const auto& [v, list] : owners)
    for (std::size_t j = 1; j < list.size(); ++j)
      for (std::size_t i = 0; i < j; ++i) contacts[{list[i], list[j]}].push_back(v);
  return contacts;
}

// Returns equivalent equations with at most as many rows as columns.
Eigen::MatrixXd compressed(const Eigen::MatrixXd& equations) {
  if (equations.rows() <= equations.cols()) return equations;
  return triangular_factor(equations);
}

// Returns an orthonormal basis of the motions (t, w of each body) that keep all contacts together,
// 6 bodies x d. still: index of a body that is held; -1 if none is.
Eigen::MatrixXd motions_left(const TetMesh& mesh, const std::vector<Body>& bodies,
                             const Contacts& contacts, int still) {
  const auto columns = 6 * static_cast<Eigen::Index>(bodies.size());
  Eigen::Index most = still >= 0 ? 6 : 0;
  for (const auto& [pair, vertices] : contacts)
    most += std::min<Eigen::Index>(3 * static_cast<Eigen::Index>(vertices.size()),
                                   pair.first == kGround ? 6 : 12);
  Eigen::MatrixXd equations = Eigen::MatrixXd::Zero(most, columns);
  Eigen::Index rows = 0;
  const auto add = [&](int a, int b, const Eigen::MatrixXd& block) {
    if (a != kGround) equations.block(rows, 6 * a, block.rows(), 6) = block.leftCols(6);
    equations.block(rows, 6 * b, block.rows(), 6) = block.rightCols(6);
    rows += block.rows();
  };
  if (still >= 0) add(kGround, still, Eigen::MatrixXd::Identity(6, 6));
  for (const auto& [pair, vertices] : contacts) {
    const auto [a, b] = pair;
    const Eigen::Index width = a == kGround ? 6 : 12;
    Eigen::MatrixXd block(3 * static_cast<Eigen::Index>(vertices.size()), width);
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      const auto row = 3 * static_cast<Eigen::Index>(i);
      const Eigen::Vector3d& x = mesh.vertices[vertices[i]];
      if (a != kGround) block.block<3, 6>(row, 0) = -bodies[a].velocity(x);
      block.block<3, 6>(row, width - 6) = bodies[b].velocity(x);
    }
    add(a, b, compressed(block));
  }
  Eigen::MatrixXd square = Eigen::MatrixXd::Zero(columns, columns);
  const Eigen::MatrixXd few = compressed(equations);
  square.topRows(few.rows()) = few;
  const SingularPairs pairs = singular_pairs(square, SingularVectors::kRight);
  // Below this singular value a motion counts as free: a lever arm this short, relative to the
  // piece, is rounding of its coordinates. A body held by little more appears in the eigensolver.
  constexpr double kFreeThreshold = 1e-7;
  return pairs.vectors.rightCols((pairs.values.array() < kFreeThreshold).count());
}

// Returns rotations of `b` relative to `a`, scaled by the smaller one's size; 3 x d.
Eigen::MatrixXd relative_turns(const std::vector<Body>& bodies, const Eigen::MatrixXd& motions,
                               int a, int b) {
  if (a == kGround) return motions.middleRows(6 * b + 3, 3);
  const double size = std::min(bodies[a].size, bodies[b].size);
  return motions.middleRows(6 * b + 3, 3) * (size / bodies[b].size) -
         motions.middleRows(6 * a + 3, 3) * (size / bodies[a].size);
}

// Moves the two vertices that lie farthest apart to the front; on a line these are its ends.
void move_ends_to_front(const TetMesh& mesh, std::vector<VertexId>& vertices) {
  const auto farthest_from = [&](VertexId from, auto begin) {
    return std::max_element(begin, vertices.end(), [&](VertexId a, VertexId b) {
      return (mesh.vertices[a] - mesh.vertices[from]).squaredNorm() <
             (mesh.vertices[b] - mesh.vertices[from]).squaredNorm();
    });
  };
  if (vertices.size() < 2) return;
  std::iter_swap(vertices.begin(), farthest_from(vertices.front(), vertices.begin()));
  std::iter_swap(vertices.begin() + 1, farthest_from(vertices.front(), vertices.begin() + 1));
}

constexpr double kMovingThreshold =
    1e-5;  // threshold for components of a unit motion, far above rounding

std::vector<Joint> moving_joints(const TetMesh& mesh, const std::vector<Body>& bodies,
                                 const Contacts& contacts, const Eigen::MatrixXd& motions) {
  const auto moves = [&](int body) {
    return motions.middleRows(6 * body, 6).norm() > kMovingThreshold;
  };
  std::vector<Joint> joints;
  for (const auto& [pair, vertices] : contacts) {
    const auto [a, b] = pair;
    const SingularPairs turns =
        singular_pairs(relative_turns(bodies, motions, a, b), SingularVectors::kNone);
    const auto count = (turns.values.array() > kMovingThreshold).count();
    if (count == 0) continue;
    const bool a_hangs =
        a != kGround && moves(a) && (!moves(b) || bodies[a].tetrahedra < bodies[b].tetrahedra);
    const int hanging = a_hangs ? a : b, other = a_hangs ? b : a;
    joints.push_back({bodies[hanging].piece, other == kGround ? kGround : bodies[other].piece,
                      vertices, static_cast<int>(count)});
    move_ends_to_front(mesh, joints.back().vertices);
  }
  return joints;
}

}  // namespace

Pieces rigid_pieces(const TetMesh& mesh) {
  std::vector<int> parent(mesh.tetrahedra.size());
  std::iota(parent.begin(), parent.end(), 0);
  for_each_face(mesh, [&](std::span<const std::size_t> sides) {
    for (const std::size_t side : sides)
      join_sets(parent, static_cast<int>(sides.front() / 4), static_cast<int>(side / 4));
  });
  Pieces pieces;
  pieces.of_tetrahedron.resize(parent.size());
  for (int t = 0; t < static_cast<int>(parent.size()); ++t) {
    // The root is the first tetrahedron of its piece, so it is numbered before the others.
    const int root = root_of(parent, t);
    pieces.of_tetrahedron[t] = root == t ? pieces.count++ : pieces.of_tetrahedron[root];
  }
  return pieces;
}

std::vector<Mechanism> find_mechanisms(const TetMesh& mesh, const MeshReport& report,
                                       const Pieces& pieces, const std::vector<VertexId>& fixed,
                                       bool free_body) {
  std::vector<std::vector<int>> tetrahedra(pieces.count);
  for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t)
    tetrahedra[pieces.of_tetrahedron[t]].push_back(static_cast<int>(t));
  std::vector<std::vector<int>> pieces_of(report.parts);
  for (int piece = 0; piece < pieces.count; ++piece)
    pieces_of[report.part_of_vertex[mesh.tetrahedra[tetrahedra[piece][0]][0]]].push_back(piece);
  std::vector<Mechanism> mechanisms;
  for (int part = 0; part < static_cast<int>(report.parts); ++part) {
    const auto count = static_cast<int>(pieces_of[part].size());
    if (count < 2 || count > kMostPieces) continue;
    std::vector<Body> bodies;
    for (int piece : pieces_of[part]) bodies.push_back(make_body(mesh, piece, tetrahedra[piece]));
    const Contacts contacts = find_contacts(bodies, fixed);
    const auto largest =
        std::max_element(bodies.begin(), bodies.end(),
                         [](const Body& a, const Body& b) { return a.tetrahedra < b.tetrahedra; });
    // Holding one piece removes exactly the six rigid motions.
    const int still = free_body ? static_cast<int>(largest - bodies.begin()) : -1;
    const Eigen::MatrixXd motions = motions_left(mesh, bodies, contacts, still);
    if (motions.cols() > 0)
      mechanisms.push_back(
          {part, static_cast<int>(motions.cols()), moving_joints(mesh, bodies, contacts, motions)});
  }
  return mechanisms;
}

}  // namespace tremolo
