// A body as Python has it: alone or in a world, with its state as arrays that can be written.
#pragma once

#include <atomic>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "runtime/apps/python/module/model_class.h"
#include "runtime/contact_body.h"

namespace tremolo::python {

// The choices that a body was made with; copies and pickles make it again.
struct BodyOptions {
  std::string integrator{kDefaultIntegrator};
  IntegratorOptions method;
  FrameKind frame = FrameKind::kFixed;
};

// A load in time of the body: a reduced vector, forces on vertices, or a factor of the model's
// default load.
struct BodyLoad {
  Signal signal;  // its table is the one below
  std::shared_ptr<const SignalTable> table;
  std::variant<Eigen::VectorXd, DefaultLoad, double> force;
};

// Raises: a body of that name was removed from its world.
[[noreturn]] void refuse_removed(const std::string& name);

class BodyHandle : public std::enable_shared_from_this<BodyHandle> {
 public:
  // A body alone.
  BodyHandle(PyModelPointer model, BodyOptions options, ContactBody body);
  // A body of a world, which `world` keeps alive.
  BodyHandle(PyModelPointer model, std::shared_ptr<void> world, ContactBody& body,
             std::atomic<bool>& used);
  // The body gets what was written into its arrays.
  ~BodyHandle();

  // The body for one call, which refuses all others meanwhile. It has the q and p of the arrays;
  // raises if these are not finite, and they are then the body's again.
  class Call {
   public:
    explicit Call(BodyHandle& handle) : used_(*handle.used_, handle.world_ ? "world" : "body") {
      handle.push_state();
    }

   private:
    InUse used_;
  };

  // Raises if the body was removed from its world, as all functions that need it.
  ContactBody& body() {
    if (body_ == nullptr) refuse_removed(ended_);
    return *body_;
  }
  // The body, of that name, was removed from its world. ended(): the name; empty: it is there.
  void end(const std::string& name) {
    body_ = nullptr;
    ended_ = name;
  }
  const std::string& ended() const { return ended_; }
  const PyModelPointer& model() const { return model_; }
  bool in_world() const { return world_ != nullptr; }
  void refuse_in_world(const char* what) const;
  const BodyOptions& options() const { return options_; }

  // Arrays of the state, r each, float64; writing into them changes the state of the next call.
  // They keep the handle.
  py::array q() { return view_of(0); }
  py::array p() { return view_of(1); }
  // Arrays -> body, if they were written; body -> arrays.
  void push_state();
  void pull_state();

  void add_load(const BodyLoad& load);
  void clear_loads();
  const std::vector<BodyLoad>& loads() const { return loads_; }
  // Runs grab(ContactBody) -> Result of the grab's number; a body without contact gets it.
  using Grab = std::function<Result<std::size_t>(ContactBody&)>;
  std::size_t grab(const Grab& grab);
  void enable_grabs();
  bool has_grabs_enabled() const { return grabs_; }

  StepReport last_report;

 private:
  py::array view_of(py::ssize_t row);

  PyModelPointer model_;
  std::shared_ptr<void> world_;
  std::optional<ContactBody> own_;
  ContactBody* body_;  // null: it was removed
  std::string ended_;
  std::atomic<bool> own_used_ = false;
  std::atomic<bool>* used_;
  BodyOptions options_;
  std::vector<BodyLoad> loads_;
  bool grabs_ = false;
  py::array_t<double> state_;  // 2 x r: q, p
};

using BodyPointer = std::shared_ptr<BodyHandle>;

BodyPointer make_body(const PyModelPointer& model, const BodyOptions& options);
py::dict report_dict(const StepReport& report);

// Functions of the class that deal with loads and grabs.
using BodyClass = py::class_<BodyHandle, BodyPointer>;
void add_loads_of_body(BodyClass& c);
// For pickles.
py::tuple tuple_of_load(const BodyLoad& load);
BodyLoad load_of_tuple(const py::tuple& tuple);

}  // namespace tremolo::python
