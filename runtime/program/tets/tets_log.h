// What a run measures and writes of one body of tetrahedra.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "common/result.h"
#include "runtime/scene_reader/tets_reader.h"
#include "runtime/tets/scene/tet_scene.h"

namespace tremolo {

// J. switches: what changes of degree took out so far.
struct TetsEnergies {
  double kinetic = 0.0, elastic = 0.0, gravity = 0.0, switches = 0.0;
  double total() const { return kinetic + elastic + gravity; }
};

// share: of quadratic edges, mean over the steps. momentum_error: the largest sum of all elastic
// forces, and of their torques about the centre, over the largest sum of their sizes: what the
// elements alone would add to the momenta. displacement: m, of a vertex, largest. inverted: how
// many elements are flat or inside out now; inverted_most: were at once.
struct TetsReport {
  TetsEnergies start, end;
  double share = 0.0;
  double momentum_error = 0.0;
  double displacement = 0.0;
  std::int64_t iterations = 0, switched = 0, in_parts = 0, linearised = 0, unsolved = 0;
  std::size_t inverted = 0, inverted_most = 0;
  double jump = 0.0;  // the largest of a change of degree, over an edge's length
  std::vector<std::string> files;
};

class TetsLog {
 public:
  // Makes the body's folder, out/NAME, if there is an `out`. Errors: kSystem.
  static Result<TetsLog> create(const TetScene& scene, const TetsKind& kind, std::size_t body);

  // Takes the start and then every step. vertices, normals: of the drawn surface now.
  Status observe(TetBody& body, const TetStepReport& step,
                 const std::vector<Eigen::Vector3d>& vertices,
                 const std::vector<Eigen::Vector3f>& normals);
  // Writes run.csv and frames.csv.
  Status finish();
  const TetsReport& report() const { return report_; }

 private:
  TetsLog(const TetScene& scene, const TetsKind& kind, std::size_t body);
  void look(TetBody& body);
  void note_forces(const TetBody& body);
  void write_row(const TetBody& body, const TetStepReport& step);
  Status write_frame(double time, const std::vector<Eigen::Vector3d>& vertices,
                     const std::vector<Eigen::Vector3f>& normals);

  SceneOutputs outputs_;
  std::string folder_;
  std::int64_t steps_ = 0;  // of the whole run
  std::shared_ptr<const TetSurface> surface_;
  TetSystem forces_;  // of its own, to look at them between steps
  Eigen::VectorXd force_, first_;
  double force_sum_ = 0.0, force_size_ = 0.0, torque_sum_ = 0.0, torque_size_ = 0.0;
  double share_sum_ = 0.0;
  int frames_ = 0;
  std::string table_, list_ = "frame,t,file\n";
  TetsReport report_;
};

}  // namespace tremolo
