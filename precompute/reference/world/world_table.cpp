#include "precompute/reference/world/world_table.h"

#include "common/format_text.h"

namespace tremolo {

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
