// A step of several bodies that may touch each other, as one equation.
//
// Each body's equation is M g^2 (d - d_a) = F(x_v + d, g d) (tet_stage.h), F with the forces of its
// contact. Newton's matrix is block-diagonal,
//   M (g^2 + (alpha + drag) g) + dforce/dx + beta g ddamping/dv    of each body,
// and the touches and hands (tet_hand.h): with w the shares of a touch in the control points of
// both its sides, w B w^T. They stay as they are and are multiplied one by one in conjugate
// gradients, which run over all bodies at once, preconditioned by the diagonal's blocks; a body by
// itself that takes too many directions, a slender one, is factored instead
// (runtime/sparse/block_cholesky.h). First with the exact derivative; where that is indefinite,
// with R K R^T. Each correction is shortened until the residual no longer points back. A step that
// is not solved is cut into two, then eight of the same method; where even those have no solution
// (an element goes through a flat shape and its rotation jumps), into eight of implicit-euler, of
// one correction each with R K R^T; of a free body that touches nothing the momenta are restored.
//
// midpoint and newmark add energy where stiff elements turn in long steps. The energy of a body by
// itself is therefore watched: a step in which it would have gained, since it last lost as much,
// more than a fiftieth of the largest that it had is taken again, half by midpoint and half by
// bdf2, which damps what is too fast for the step, and both momenta are restored.
//
// A step also ends where the forces between bodies jump and no correction makes the residual
// smaller, which is then a thousandth of them at most, a hundredth after the last correction; it is
// told as unsolved.
//
// Where all bodies have UnsolvedStep::kTake, a step is max_iterations corrections at most, from
// where the bodies are, none of them shortened: the linearly implicit step of real-time programs
// for one, whose stiffness is positive; with two, what the first ran into is known to the second.
//
// Where all bodies have kTakeContact and a method that damps, implicit-euler or bdf2, a step in
// which something touches is such a step of implicit-euler: two corrections with R K R^T. Solving
// it to the end takes a hundred times as long, since the forces of touches have corners, and where
// elements are crushed there may be no solution near. A step that adds to the energy more than a
// twentieth of what there is then is cut into two, then four of the same kind.
//
// Bodies of one island take the same method, so that what one gives the other takes: where methods
// differ, or not all have the step before that bdf2 needs, implicit-euler.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "runtime/tets/contact/tet_contact.h"
#include "runtime/tets/motion/tet_body.h"
#include "runtime/threads/thread_pool.h"

namespace tremolo {

// contact: null where a body touches nothing. Its partners are members of the island.
struct TetMember {
  TetBody* body = nullptr;
  TetContact* contact = nullptr;
};

class TetIsland {
 public:
  // pool: shares the bodies among threads; null: none. Must outlive it. What comes out does not
  // depend on the number of threads.
  explicit TetIsland(ThreadPool* pool = nullptr) : pool_(pool) {}
  // Takes memory for so many bodies and touches; more is taken when it is first needed.
  void reserve(std::size_t bodies, std::size_t touches);

  // Takes all bodies one step further, which is the same for all; a report each. Where it fails
  // (converged is false), all states are as before.
  void step(std::span<const TetMember> members, std::span<TetStepReport> reports);

 private:
  // One side of a touch or a hand: its share in a body's control points. part: what the search's
  // direction is there.
  struct TouchEnd {
    std::uint32_t coupling = 0;
    FoldedPoint point;
    Eigen::Vector3d part;
  };
  // A touch or a hand: its ends' numbers, other is kNoEnd of what stands still and of hands.
  struct Coupling {
    std::uint32_t own = 0, other = kNoEnd;
    Eigen::Matrix3d block;
  };
  static constexpr std::uint32_t kNoEnd = ~std::uint32_t{0};

  template <class Body>
  void for_each(std::size_t count, const Body& body);
  TetMethod common_method() const;
  bool make_step(TetMethod method, double h);
  bool make_linear_step(double h);
  enum class PartKind { kMethod, kContact, kLinear };
  bool make_parts(int parts, PartKind kind);
  bool make_any_step();
  TetBody* watched(TetMethod method) const;
  bool energy_is_good(TetBody& body);
  bool make_damped_step(TetBody& body, double h);
  bool make_watched_step(TetMethod method, double h);
  bool solve_stage();
  double island_energy() const;
  bool make_contact_step(double h, bool last);
  bool contact_is_taken() const;
  bool at_kink(double size, double share) const;
  bool touching() const;
  double find_residual();
  bool small_enough() const;
  void find_correction(bool exact, double tolerance);
  bool search(double tolerance);
  std::span<const TetTouch> touches_of(std::size_t member) const;
  void number_ends();
  void find_couplings();
  void find_ends(std::uint32_t member);
  void find_hand_end(std::uint32_t member);
  void add_images(std::uint32_t member);
  bool take_correction(double& size);
  void take_whole(double& size);

  ThreadPool* pool_;
  std::span<const TetMember> members_;  // in a step
  bool bounded_ = false;                // all take what max_iterations find
  bool watch_contact_ = false;          // a stage is given up where something touches
  bool met_contact_ = false;            // one was
  TetStepReport report_;
  std::vector<Coupling> couplings_;  // body by body: touches, then the hand
  std::vector<TouchEnd> ends_;       // body by body
  std::vector<std::uint32_t> first_coupling_, first_end_, next_end_;
  std::vector<double> squares_, stops_;  // |r|^2 and where to stop, of each body
  std::vector<double> curvatures_;       // p.A p, of each body with the touches of its own points
  std::vector<SearchSizes> sizes_;
};

}  // namespace tremolo
