// A step of several bodies that may be in contact, solved as one equation.
//
// Each body's equation is M g^2 (d - d_a) = F(x_v + d, g d) (tet_stage.h), where F includes the
// contact forces. Newton's matrix has a diagonal block for each body,
//  M (g^2 + (alpha + drag) g) + dforce/dx + beta g ddamping/dv,
// and terms for contacts and grabs (tet_hand.h): w B w^T, with w the weights of a contact for the
// control points of both its sides. They are kept separate and multiplied one by one in conjugate
// gradients, which run over all bodies at once, preconditioned by the diagonal's blocks. A slender
// body without partners that takes too many directions is factored instead
// (runtime/math/sparse/block_cholesky.h).
//
// The exact derivative is tried first; where it is indefinite, R K R^T is used. Each correction is
// shortened until the residual no longer points back. A step that is not solved is divided into
// two, then into eight steps of the same method. Where even those have no solution (an element
// passes through a flat shape and its rotation jumps), it is divided into eight steps of
// implicit-euler, of one correction each with R K R^T; the momenta of a free body without contact
// are restored.
//
// midpoint and newmark add energy where stiff elements rotate in long steps. The energy of a body
// without partners is therefore checked. A step in which it would have gained, since it last lost
// as much, more than a fiftieth of its largest value is repeated: half by midpoint and half by
// bdf2, which damps motion too fast for the step, and both momenta are restored.
//
// A step also ends where the forces between bodies jump and no correction lowers the residual. The
// residual is then at most a thousandth of these forces, a hundredth after the last correction; the
// step is reported as unsolved.
//
// If all bodies have UnsolvedStep::kTake, a step has at most max_iterations corrections from the
// present positions, none of them shortened. One correction is the linearly implicit step of
// real-time programs, with positive stiffness; with two, the second includes the contacts that the
// first ran into.
//
// If all bodies have kTakeContact and a method that damps, implicit-euler or bdf2, a step with
// contact is solved to a thousandth. A body alone has the corrections of any step, because its
// friction needs them: the limits of friction and the points in contact change with each. Forces
// between bodies are not smooth, so that a step of several may take a hundred times as long. It has
// quick corrections with R K R^T, and ends, reported as unsolved, when one does not halve the
// residual and a fifth of it is left at most. Where this fails, or adds more than a twentieth of
// the present energy, the step is taken again as two corrections of implicit-euler from the present
// positions, then divided into two and four such steps.
//
// Bodies of one island use the same method, so that their forces on each other are opposite. If
// their methods differ, or not all have the previous step that bdf2 needs, it is implicit-euler.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "runtime/bodies/tets/contact/tet_contact.h"
#include "runtime/bodies/tets/motion/tet_body.h"
#include "runtime/math/thread_pool.h"

namespace tremolo {

// A body of the island.
struct TetMember {
  TetBody* body = nullptr;
  TetContact* contact = nullptr;  // null: no contact; its partners are members of the island
};

class TetIsland {
 public:
  // pool: divides the bodies among threads; null: no threads. It must outlive the island. Results
  // do not depend on the number of threads.
  explicit TetIsland(ThreadPool* pool = nullptr) : pool_(pool) {}
  // Reserves memory for this number of bodies and contacts; more is allocated when it is first
  // needed.
  void reserve(std::size_t bodies, std::size_t touches);

  // Takes one step of all bodies, which have the same step; one report each. On failure (converged
  // is false) all states are as before.
  void step(std::span<const TetMember> members, std::span<TetStepReport> reports);

 private:
  // One side of a contact or a grab.
  struct TouchEnd {
    std::uint32_t coupling = 0;
    // Its weights in a body's control points.
    FoldedPoint point;
    Eigen::Vector3d part;  // the search direction there
  };
  // A contact or a grab, by the numbers of its ends.
  struct Coupling {
    std::uint32_t own = 0, other = kNoEnd;  // other is kNoEnd for fixed obstacles and for grabs
    Eigen::Matrix3d block;
  };
  static constexpr std::uint32_t kNoEnd = ~std::uint32_t{0};

  template <class Body>
  void for_each(std::size_t count, const Body& body) {
    if (pool_ != nullptr)
      pool_->run(count, [&body](std::size_t i, unsigned) { body(i); });
    else
      for (std::size_t i = 0; i < count; ++i) body(i);
  }
  TetMethod common_method() const;
  bool make_step(TetMethod method, double h);
  void end_step();
  bool make_linear_step(double h);
  enum class PartKind { kMethod, kContact, kLinear };
  bool make_parts(int parts, PartKind kind);
  void begin_bdf2_again();
  bool make_any_step();
  TetBody* watched(TetMethod method) const;
  bool energy_is_good(TetBody& body);
  bool make_damped_step(TetBody& body, double h);
  bool make_watched_step(TetMethod method, double h);
  bool solve_stage();
  double contact_energy() const;
  double island_energy() const;
  bool adds_little(double before) const;
  bool make_contact_step(double h, bool last);
  bool contact_is_taken() const;
  bool at_kink(double size, double share) const;
  bool touching() const;
  double find_residual();
  void set_stops(double least);
  double size_of_forces() const;
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
  bool bounded_ = false;                // all bodies take the result of max_iterations
  bool watch_contact_ = false;          // a stage with contact may end unsolved
  bool met_contact_ = false;            // it had contact
  bool took_unsolved_ = false;          // it ended unsolved
  // Of the start of the step, J; the first is known if it ended unsolved.
  double start_energy_ = 0.0, start_contact_energy_ = 0.0;
  TetStepReport report_;
  std::vector<Coupling> couplings_;  // body by body: contacts, then the grab
  std::vector<TouchEnd> ends_;       // body by body
  std::vector<std::uint32_t> first_coupling_, first_end_, next_end_;
  std::vector<double> squares_, stops_;  // |r|^2 and its stopping value, of each body
  std::vector<double> curvatures_;       // p.A p, of each body with the contacts of its own points
  std::vector<SearchSizes> sizes_;
};

}  // namespace tremolo
