// Forces at the vertices for which a model has a response (Model::response()). Their values at the
// end of the last step give the shape W f that is shown on top of U q.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "common/load_signal.h"
#include "common/state_stream.h"
#include "runtime/model.h"

namespace tremolo {

class PlaceForces {
 public:
  explicit PlaceForces(std::size_t places);

  bool none() const { return now_.size() == 0; }  // there are no places
  // f, N, 3 per place, along the body's axes.
  const Eigen::VectorXd& now() const { return now_; }

  // force: N, along the world's axes, times the signal. steps: number of further steps if positive;
  // else the force acts as long as the signal lasts. place: index of the vertex in
  // Model::response_places().
  void add(const Signal& signal, Eigen::Index place, const Eigen::Vector3d& force, int steps);
  // The same for forces on vertices: as one force at the default load's place if they are a
  // multiple of that load, else one at each vertex that is a place.
  void add(const Signal& signal, const Model& model, const DefaultLoad& load, int steps);
  void clear();
  void clear_applied();  // those with steps

  // Sets now() to the forces at the end of the step from `time` to `time` + `step`. turn(place)
  // returns the rotation from the body's axes there to the world's, 3 x 3.
  template <class Turn>
  void end_step(double time, double step, const Turn& turn) {
    now_.setZero();
    for (Force& force : forces_) {
      const double share = force.steps > 0 ? 1.0 : sample_signal(force.signal, time, step).end;
      if (share != 0.0) push(force.place, turn(force.place).transpose() * (share * force.force));
      // A force whose steps are over has -1; 0 is one that its signal ends.
      if (force.steps > 0 && --force.steps == 0) force.steps = -1;
    }
    std::erase_if(forces_, [](const Force& force) { return force.steps < 0; });
  }
  // Adds to now(); force: N, along the body's axes.
  void push(Eigen::Index place, const Eigen::Vector3d& force) {
    now_.segment<3>(3 * place) += force;
  }

  // Saves or restores the forces with steps; forces that a signal ends are unchanged.
  void carry(StateStream& stream);

 private:
  struct Force {
    Signal signal;
    Eigen::Index place = 0;
    Eigen::Vector3d force = Eigen::Vector3d::Zero();
    int steps = 0;
  };

  std::vector<Force> forces_;
  Eigen::VectorXd now_;
};

// The forces at the model's places that stand for a load, as PlaceForces::add() takes it: N, 3 per
// place, along the body's axes.
Eigen::VectorXd place_forces_of(const Model& model, const DefaultLoad& load);

}  // namespace tremolo
