#include "precompute/reference/world/whole_frame.h"

#include <Eigen/SVD>

#include "common/text.h"

namespace tremolo {
namespace {

using PerVertex = Eigen::Map<const Eigen::Matrix3Xd>;

PerVertex columns(const Field& field) {
  return {field.data(), 3, field.size() / 3};
}

Field rest_places(const WorldBody& world) {
  const std::vector<Eigen::Vector3d>& rest = world.body.solid.mesh.vertices;
  Field places(3 * static_cast<Eigen::Index>(rest.size()));
  for (std::size_t v = 0; v < rest.size(); ++v)
    places.segment<3>(3 * static_cast<Eigen::Index>(v)) = rest[v];
  return places;
}

}  // namespace

WholeFrame whole_frame(const WorldBody& world, double time, const Field& displacement,
                       const Field& velocity) {
  const Field rest = rest_places(world), places = rest + displacement;
  const Field momentum = whole_mass_times(world, velocity);
  WholeFrame frame;
  frame.linear_momentum = columns(momentum).rowwise().sum();
  for (Eigen::Index v = 0; v < places.size(); v += 3)
    frame.angular_momentum +=
        Eigen::Vector3d(places.segment<3>(v)).cross(Eigen::Vector3d(momentum.segment<3>(v)));
  if (world.path != nullptr) {
    const RigidMotion support = world.path->at(time);
    frame.position = support.position;
    frame.rotation = support.turn;
    return frame;
  }
  const Field weighted = whole_mass_times(world, rest);
  Field ones = Field::Zero(rest.size());
  for (Eigen::Index v = 0; v < ones.size(); v += 3) ones[v] = 1.0;
  const Field mass_of_vertex = whole_mass_times(world, ones);
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  for (Eigen::Index v = 0; v < ones.size(); v += 3)
    centre += mass_of_vertex[v] * Eigen::Vector3d(places.segment<3>(v));
  const double mass = mass_of_vertex.sum();
  centre /= mass;
  const Eigen::Vector3d rest_centre = columns(weighted).rowwise().sum() / mass;
  const Eigen::Matrix3d moment =
      columns(places) * columns(weighted).transpose() - mass * centre * rest_centre.transpose();
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(moment, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Matrix3d left = svd.matrixU();
  if (left.determinant() * svd.matrixV().determinant() < 0) left.col(2) = -left.col(2);
  const Eigen::Matrix3d turn = left * svd.matrixV().transpose();
  frame.rotation = turn;
  frame.position = centre - turn * rest_centre;
  return frame;
}

Field displacement_in(const WholeFrame& frame, const WorldBody& world, const Field& displacement) {
  const Field rest = rest_places(world);
  const Eigen::Matrix3d back = frame.rotation.toRotationMatrix().transpose();
  Field relative(rest.size());
  for (Eigen::Index v = 0; v < rest.size(); v += 3)
    relative.segment<3>(v) =
        back * (rest.segment<3>(v) + displacement.segment<3>(v) - frame.position) -
        rest.segment<3>(v);
  return relative;
}

std::string world_table_head(const std::vector<VertexId>& probes) {
  std::string head =
      "t,kinetic,potential,total,work,dissipated,x,y,z,qw,qx,qy,qz,px,py,pz,lx,ly,lz";
  for (VertexId v : probes)
    for (const char axis : {'x', 'y', 'z'}) head += text(",u%d%c", v, axis);
  return head + "\n";
}

std::string world_table_row(const Motion& motion, const WholeFrame& frame,
                            const std::vector<VertexId>& probes, const Field& relative) {
  std::string row = text("%.9g,%.10g,%.10g,%.12g,%.10g,%.10g", motion.time, motion.kinetic,
                         motion.potential, motion.total(), motion.work, motion.dissipated);
  const Eigen::Quaterniond& q = frame.rotation;
  for (const double value :
       {frame.position.x(), frame.position.y(), frame.position.z(), q.w(), q.x(), q.y(), q.z()})
    row += text(",%.12g", value);
  for (const Eigen::Vector3d& momentum : {frame.linear_momentum, frame.angular_momentum})
    for (const double value : momentum) row += text(",%.12g", value);
  for (VertexId v : probes)
    for (int axis = 0; axis < 3; ++axis)
      row += text(",%.10g", relative[3 * Eigen::Index{v} + axis]);
  return row + "\n";
}

}  // namespace tremolo
