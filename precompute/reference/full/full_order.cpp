#include "precompute/reference/full/full_order.h"

#include <algorithm>

#include "common/parallel.h"
#include "precompute/problem/point_mass.h"
#include "precompute/problem/rigid_motion.h"
#include "precompute/system/failure.h"

namespace tremolo {
namespace {

constexpr std::size_t kChunk = 256;  // elements, nodes or rows per task of a thread

template <class Body>
void in_chunks(std::size_t count, unsigned threads, const Body& body) {
  parallel_for((count + kChunk - 1) / kChunk, threads, [&](std::size_t chunk) {
    const std::size_t last = std::min(count, (chunk + 1) * kChunk);
    for (std::size_t i = chunk * kChunk; i < last; ++i) body(i);
  });
}

// Writes a 3x3 block into the rows of a node; held components are skipped.
void write_block(const FullOrder& body, int node, int block, const Eigen::Matrix3d& sum,
                 std::vector<double>& values) {
  const Unknowns& unknowns = body.unknowns;
  const int row_dof = 3 * unknowns.map.vertex_of_node[node];
  const int column_dof = 3 * unknowns.map.vertex_of_node[body.pattern.node[block]];
  for (int x = 0; x < 3; ++x) {
    const int row = unknowns.of_dof[row_dof + x];
    if (row < 0) continue;
    double* entry = values.data() + body.pattern.start[row] + body.pattern.offset[block];
    for (int y = 0; y < 3; ++y)
      if (unknowns.of_dof[column_dof + y] >= 0) *entry++ = sum(x, y);
  }
}

// Assembles a matrix: each block is the sum of its `part_of(element, a, b)`.
template <class PartOf>
void assemble_blocks(const FullOrder& body, const PartOf& part_of, std::vector<double>& values) {
  const Pattern& pattern = body.pattern;
  values.resize(pattern.column.size());
  in_chunks(body.unknowns.map.nodes(), body.threads, [&](std::size_t n) {
    const int node = static_cast<int>(n);
    for (int block = pattern.block[node]; block < pattern.block[node + 1]; ++block) {
      Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
      for (int at = pattern.begin[block]; at < pattern.begin[block + 1]; ++at) {
        const ElementPart part = pattern.element_part(at);
        sum += part_of(part.element, part.i, part.j);
      }
      write_block(body, node, block, sum, values);
    }
  });
}

void assemble_mass(FullOrder& body, MassKind kind) {
  assemble_blocks(
      body,
      [&](std::size_t e, int a, int b) {
        return Eigen::Matrix3d(element_mass(body.solid, e, a, b, kind) *
                               Eigen::Matrix3d::Identity());
      },
      body.mass);
  if (body.solid.point_mass.empty()) return;
  for (Eigen::Index i = 0; i < body.size(); ++i)
    for (int at = body.pattern.start[i]; at < body.pattern.start[i + 1]; ++at)
      if (body.pattern.column[at] == i)
        body.mass[at] += body.solid.point_mass[body.unknowns.dof[i] / 3];
}

// Displacements and their change in the step, of all vertices, 3n.
Field all_from(const FullOrder& body, const Vector& u) {
  Field field = expand(body.unknowns, u);
  if (body.support.from.size() > 0) field += body.support.from;
  return field;
}
Field all_by(const FullOrder& body, const Vector& d) {
  Field field = expand(body.unknowns, d);
  if (body.support.by.size() > 0) field += body.support.by;
  return field;
}

// The sum of value_of(element), the same for any number of threads.
template <class ValueOf>
double sum_over_elements(const FullOrder& body, const ValueOf& value_of) {
  const std::size_t count = body.solid.elements.size();
  std::vector<double> sums((count + kChunk - 1) / kChunk, 0.0);
  parallel_for(sums.size(), body.threads, [&](std::size_t chunk) {
    const std::size_t last = std::min(count, (chunk + 1) * kChunk);
    for (std::size_t e = chunk * kChunk; e < last; ++e) sums[chunk] += value_of(e);
  });
  double total = 0;
  for (double sum : sums) total += sum;
  return total;
}

// In a free body all three components of each node are unknowns, so rows agree with the dof map.
void find_rigid_motions(const Problem& problem, FullOrder& body) {
  constexpr const char* kDoing = "find the rigid motions";
  const LocalDofs local = local_dofs(problem.mesh, body.unknowns.map, 0);
  const auto size = static_cast<PetscInt>(body.size());
  PetscMatrix mass;
  check_petsc(MatCreateSeqAIJWithArrays(PETSC_COMM_WORLD, size, size, body.pattern.start.data(),
                                        body.pattern.column.data(), body.mass.data(), mass.out()),
              kDoing);
  body.rigid = rigid_modes(problem.mesh, problem.report.part_of_vertex,
                           static_cast<int>(problem.report.parts), local, mass.get());
  body.mass_rigid = multiply(mass.get(), body.rigid);
}

}  // namespace

FullOrder make_full_order(const Problem& problem, MassKind kind, unsigned threads) {
  if (mpi_ranks() > 1)
    throw Failure({ErrorKind::kUsage,
                   "the reference works in one process: start it without mpiexec, with --threads"});
  FullOrder body{make_solid(problem.mesh, problem.materials), {}, {}, {}, {}, {}, {}, threads};
  body.solid.point_mass = mass_of_vertices(problem.point_masses, problem.mesh.vertices.size());
  body.unknowns = make_unknowns(problem.mesh, problem.fixed, problem.held);
  body.pattern = make_pattern(problem.mesh, body.unknowns);
  assemble_mass(body, kind);
  const Vector rest = Vector::Zero(body.size());
  segment_tangent(body, {{1.0, 1.0}}, rest, rest, body.stiffness);
  body.rigid.resize(body.size(), 0);
  body.mass_rigid.resize(body.size(), 0);
  if (problem.free_body) find_rigid_motions(problem, body);
  return body;
}

SparseRows rows_of(const FullOrder& body, const std::vector<double>& values) {
  return {static_cast<int>(body.size()), body.pattern.start.data(), body.pattern.column.data(),
          values.data()};
}

Vector multiply(const FullOrder& body, const std::vector<double>& values, const Vector& x) {
  Vector y(x.size());
  in_chunks(x.size(), body.threads, [&](std::size_t row) {
    double sum = 0;
    for (int at = body.pattern.start[row]; at < body.pattern.start[row + 1]; ++at)
      sum += values[at] * x[body.pattern.column[at]];
    y[row] = sum;
  });
  return y;
}

double potential_energy(const FullOrder& body, const Vector& u) {
  Field field = all_from(body, u);
  if (body.support.by.size() > 0) field += body.support.by;
  return sum_over_elements(body,
                           [&](std::size_t e) { return element_energy(body.solid, e, field); });
}

double strain_change_work(const FullOrder& body, const Vector& u, const Vector& d) {
  const Field from = all_from(body, u), by = all_by(body, d);
  return sum_over_elements(
      body, [&](std::size_t e) { return element_strain_change_work(body.solid, e, from, by); });
}

Vector segment_force(const FullOrder& body, const std::vector<SegmentPoint>& points,
                     const Vector& u, const Vector& d) {
  const Field from = all_from(body, u), by = all_by(body, d);
  std::vector<NodeForces> parts(body.solid.elements.size());
  in_chunks(parts.size(), body.threads,
            [&](std::size_t e) { parts[e] = element_force(body.solid, e, points, from, by); });
  const Pattern& pattern = body.pattern;
  Vector force(body.size());
  in_chunks(body.unknowns.map.nodes(), body.threads, [&](std::size_t n) {
    const int block = pattern.self(static_cast<int>(n));
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (int at = pattern.begin[block]; at < pattern.begin[block + 1]; ++at) {
      const ElementPart part = pattern.element_part(at);
      sum += parts[part.element].col(part.j);
    }
    for (int x = 0; x < 3; ++x) {
      const int unknown = body.unknowns.of_dof[3 * body.unknowns.map.vertex_of_node[n] + x];
      if (unknown >= 0) force[unknown] = sum[x];
    }
  });
  return force;
}

Field held_force(const FullOrder& body, const std::vector<SegmentPoint>& points, const Vector& u,
                 const Vector& d) {
  const Field from = all_from(body, u), by = all_by(body, d);
  const std::vector<int>& of_dof = body.unknowns.of_dof;
  Field force = Field::Zero(of_dof.size());
  for (std::size_t e = 0; e < body.solid.elements.size(); ++e) {
    const ElementNodes nodes = element_nodes(body.solid.mesh, e);
    const auto held = [&](VertexId v) { return of_dof[3 * static_cast<std::size_t>(v)] < 0; };
    if (std::none_of(nodes.begin(), nodes.end(), held)) continue;
    const NodeForces part = element_force(body.solid, e, points, from, by);
    for (int a = 0; a < nodes.count; ++a)
      if (held(nodes[a])) force.segment<3>(3 * Eigen::Index{nodes[a]}) += part.col(a);
  }
  return force;
}

void segment_tangent(const FullOrder& body, const std::vector<SegmentPoint>& points,
                     const Vector& u, const Vector& d, std::vector<double>& values) {
  const Field from = all_from(body, u), by = all_by(body, d);
  const std::size_t blocks = element_blocks(body.solid.order());
  std::vector<Eigen::Matrix3d> parts(body.solid.elements.size() * blocks);
  const auto of_element = [&](std::size_t e) {
    return std::span(parts).subspan(e * blocks, blocks);
  };
  in_chunks(body.solid.elements.size(), body.threads, [&](std::size_t e) {
    element_tangent(body.solid, e, points, from, by, of_element(e));
  });
  assemble_blocks(
      body,
      [&](std::size_t e, int a, int b) {
        const std::span<const Eigen::Matrix3d> part = of_element(e);
        return a <= b ? part[element_block(a, b)]
                      : Eigen::Matrix3d(part[element_block(b, a)].transpose());
      },
      values);
}

void remove_rigid_motion(const FullOrder& body, Vector& u) {
  if (body.rigid.cols() > 0) u -= body.rigid * (body.mass_rigid.transpose() * u);
}

void remove_rigid_force(const FullOrder& body, Vector& force) {
  if (body.rigid.cols() > 0) force -= body.mass_rigid * (body.rigid.transpose() * force);
}

Vector deforming_load(const FullOrder& body, const Vector& load) {
  constexpr double kRounding = 1e-12;
  Vector left = load;
  remove_rigid_force(body, left);
  if (left.norm() <= kRounding * load.norm()) left.setZero();
  return left;
}

double largest_displacement(const FullOrder& body, const std::vector<VertexId>& vertices,
                            const Vector& u) {
  double largest = 0;
  for (const VertexId v : vertices) {
    Eigen::Vector3d displacement = Eigen::Vector3d::Zero();
    for (int axis = 0; axis < 3; ++axis)
      if (const int unknown = body.unknowns.of_dof[3 * v + axis]; unknown >= 0)
        displacement[axis] = u[unknown];
    largest = std::max(largest, displacement.norm());
  }
  return largest;
}

Vector point_load(const FullOrder& body, const DefaultLoad& load) {
  Vector field = Vector::Zero(body.unknowns.of_dof.size());
  for (std::size_t i = 0; i < load.vertices.size(); ++i)
    field.segment<3>(3 * Eigen::Index{load.vertices[i]}) += load.forces[i];
  return restrict_to(body.unknowns, field);
}

Vector gravity_load(const FullOrder& body, const Eigen::Vector3d& gravity) {
  const Solid& solid = body.solid;
  Vector field = Vector::Zero(body.unknowns.of_dof.size());
  const double share = weight_share(solid.order());
  for (std::size_t e = 0; e < solid.elements.size(); ++e)
    for (VertexId v : element_nodes(solid.mesh, e))
      field.segment<3>(3 * Eigen::Index{v}) +=
          (share * solid.density(e) * solid.elements[e].volume) * gravity;
  for (std::size_t v = 0; v < solid.point_mass.size(); ++v)
    field.segment<3>(3 * static_cast<Eigen::Index>(v)) += solid.point_mass[v] * gravity;
  return restrict_to(body.unknowns, field);
}

}  // namespace tremolo
