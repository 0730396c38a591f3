// Measurements and output files of a run for one body of tetrahedra.
#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "common/result.h"
#include "runtime/apps/tremolo/output/scene_places.h"
#include "runtime/apps/tremolo/run/log_files.h"
#include "runtime/bodies/tets/motion/tet_sums.h"
#include "runtime/bodies/tets/scene/tet_scene.h"
#include "runtime/io/scenes/nodal_readers.h"
#include "runtime/math/state.h"

namespace tremolo {

// J. switches: energy removed by changes of degree so far.
struct TetsEnergies {
  double kinetic = 0.0, elastic = 0.0, gravity = 0.0, switches = 0.0;
  double total() const { return kinetic + elastic + gravity; }
};

// Measurements of one body in a run.
struct TetsReport {
  TetsEnergies start, end;
  Momenta momenta_start, momenta_end;  // angular: about the centre of mass
  double share = 0.0;                  // of quadratic edges, mean over the steps
  // The largest sum of all elastic forces, and of their torques about the centre, relative to the
  // largest sum of their sizes: the momenta that the elements alone would add.
  double elastic_error = 0.0;
  // The largest change of momentum, and of angular momentum about the centre, summed over steps in
  // which only gravity acted, relative to the largest sums of their sizes; 0: the body never moved.
  double linear_lost = 0.0, angular_lost = 0.0;
  double displacement = 0.0;  // m, of a vertex, largest
  std::int64_t iterations = 0, switched = 0, in_parts = 0, linearised = 0, unsolved = 0,
               guarded = 0;
  std::size_t inverted = 0, inverted_most = 0;  // elements flat or inside out now, and at most
  double jump = 0.0;  // the largest of a change of degree, over an edge's length
  std::vector<std::string> files;

  double momentum_error() const { return std::max({elastic_error, linear_lost, angular_lost}); }
};

// Sums of changes of the momenta without an external cause.
class MomentumLoss {
 public:
  // alone: only gravity acted in the step of h, s, that ends at the body's state.
  void note(const TetBody& body, bool alone);
  const Momenta& now() const { return now_; }
  // The largest sums, over the largest sizes.
  double linear() const { return linear_size_ > 0.0 ? most_linear_ / linear_size_ : 0.0; }
  double angular() const { return angular_size_ > 0.0 ? most_angular_ / angular_size_ : 0.0; }

 private:
  Momenta now_;
  Eigen::Vector3d linear_ = Eigen::Vector3d::Zero(), angular_ = linear_;  // lost, summed
  double linear_size_ = 0.0, angular_size_ = 0.0;
  double most_linear_ = 0.0, most_angular_ = 0.0;
  bool known_ = false;
  Eigen::VectorXd pushed_;  // M v
};

class TetsLog {
 public:
  // Makes the body's folder, out/NAME, if there is an `out`. first: the step at which the run
  // begins. further: names of more columns, ",a,b"; may be empty. Errors: kSystem.
  static Result<TetsLog> create(const TetScene& scene, const TetsKind& kind, std::size_t body,
                                std::int64_t first, const std::string& further = {});

  // Takes the start and then every step. sums: of all steps so far. vertices, normals: of the drawn
  // surface now. touched: forces of others acted on the body in the step. further: values of the
  // further columns.
  Status observe(TetBody& body, const TetStepReport& step, const TetSums& sums,
                 const std::vector<Eigen::Vector3d>& vertices,
                 const std::vector<Eigen::Vector3f>& normals, bool touched,
                 std::span<const double> further = {});
  // Renames the files from their temporary names.
  Status finish();
  const TetsReport& report() const { return report_; }

 private:
  TetsLog(const TetScene& scene, const TetsKind& kind, std::size_t body, std::int64_t first);
  void look(TetBody& body);
  void note_forces(const TetBody& body);
  void note_momenta(const TetBody& body, bool touched);
  Status write_row(const TetBody& body, const TetStepReport& step, std::span<const double> further);

  SceneOutputs outputs_;    // in the body's own folder
  std::int64_t steps_ = 0;  // of the whole run
  std::shared_ptr<const TetSurface> surface_;
  bool held_ = false;  // the mesh has fixed vertices
  TetSystem forces_;   // a separate system, for evaluations between steps
  Eigen::VectorXd force_;
  bool started_ = false;
  double force_sum_ = 0.0, force_size_ = 0.0, torque_sum_ = 0.0, torque_size_ = 0.0;
  MomentumLoss loss_;
  CsvTable table_;
  Frames frames_;
  TetsReport report_;
};

// The name of a kind in scene files.
const char* degree_name(DegreeKind kind);
nlohmann::ordered_json energies_json(const TetsEnergies& e);
// The parts of a body's report that do not depend on what it meets.
nlohmann::ordered_json tets_report_json(const TetSceneBody& wanted, const TetBody& body,
                                        const TetsReport& report);

// A body as `tremolo inspect` shows it.
PlacedBody placed_tets(const TetSceneBody& wanted, const TetSurface& surface, const TetBody& body);

}  // namespace tremolo
