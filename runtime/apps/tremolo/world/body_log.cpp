#include "runtime/apps/tremolo/world/body_log.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "common/energy.h"
#include "runtime/apps/tremolo/run/run_body.h"
#include "runtime/apps/tremolo/world/world_commands.h"
#include "runtime/contact/solve/contact_step.h"
#include "runtime/energy_bound.h"

namespace tremolo {
namespace {

constexpr std::int64_t kStepsBetweenShapes = 10;
constexpr std::size_t kMostOpen = 64;  // files of one run

const std::vector<std::string> kFurther = {"load",
                                           "support",
                                           "gravity",
                                           "contact",
                                           "friction",
                                           "damping",
                                           "x",
                                           "y",
                                           "z",
                                           "qw",
                                           "qx",
                                           "qy",
                                           "qz",
                                           "px",
                                           "py",
                                           "pz",
                                           "lx",
                                           "ly",
                                           "lz",
                                           "restitution",
                                           "hand",
                                           "contact_energy",
                                           "contact_force",
                                           "joint",
                                           "contact_fx",
                                           "contact_fy",
                                           "contact_fz",
                                           "hand_fx",
                                           "hand_fy",
                                           "hand_fz"};

// The mean forces of contact and of hands on the body in the last step, N, world.
struct TouchForces {
  Eigen::Vector3d contact = Eigen::Vector3d::Zero(), hands = contact;
};

TouchForces touch_forces(const SceneWorld& world, std::size_t body) {
  TouchForces forces;
  const ContactBody& known = world.body(body);
  forces.contact = known.contact_account().impulse_vector / known.options().step;
  for (const Grip& grip : known.grips()) forces.hands += grip.force;
  return forces;
}

BodyPlace place_of(const SceneWorld& world, std::size_t body) {
  return {world.body(body).pose(), world.momenta(body)};
}

// Energy exchanged, J, the sum over all causes without sign.
double turnover(const EnergyAccount& account) {
  double sum = 0.0;
  for (const double cause :
       {account.load, account.support, account.gravity, account.contact_given, account.restitution,
        account.friction, account.hand, account.joint, account.damping})
    sum += std::abs(cause);
  return sum;
}

Result<RecordedColumns> columns_of(const SceneBody& body, const Model& model) {
  SceneColumns asked = body.columns;
  if (model.modes() == 0) asked.coordinates.clear();
  Result<RecordedColumns> columns = recorded_columns(asked, model);
  if (!columns) return value_error(columns.error());
  columns->further = kFurther;
  for (const int probe : columns->probes)
    if (const Result<VertexRows> rows = model.vertex(probe); !rows)
      return value_error(rows.error());
  return columns;
}

}  // namespace

Status check_columns(const SceneWorld& world) {
  bool asked = false, any = false;
  for (std::size_t i = 0; i < world.size(); ++i) {
    const SceneBody& body = world.scene().bodies[i];
    const Model& model = world.body(i).model();
    if (const Result<RecordedColumns> columns = columns_of(body, model); !columns)
      return Error{columns.error().kind, "body '" + body.name + "': " + columns.error().message};
    asked = asked || !body.columns.coordinates.empty();
    any = any || (!body.columns.coordinates.empty() && model.modes() > 0);
  }
  if (asked && !any)
    return usage_error(
        "coordinates are asked for, and no body has any: rigid bodies, tetrahedra and cloth have "
        "none, --probe records their vertices");
  return Success{};
}

Result<BodyLog> BodyLog::create(const SceneFile& file, const SceneWorld& world, std::size_t body,
                                SharedLooks& shared) {
  const SceneBody& known = world.scene().bodies[body];
  const Model& model = world.body(body).model();
  const Result<RecordedColumns> columns = columns_of(known, model);
  if (!columns) return columns.error();
  const std::int64_t steps = std::llround(file.scene.duration / file.scene.step);
  Result<BodyFiles> files =
      BodyFiles::create(outputs_of_body(file.outputs, known.name), *columns, model,
                        {world.steps(), steps}, world.size() > kMostOpen);
  if (!files) return files.error();
  const auto looks = shared.looks.find(&model);
  const ShapeLooks& first =
      looks != shared.looks.end()
          ? looks->second
          : shared.looks.try_emplace(&model, model, kStepsBetweenShapes, steps).first->second;
  BodyLog log(body, std::move(*files), first, shared);
  log.report_.name = known.name;
  log.report_.model = solid_name(known);
  log.report_.integrator = known.integrator;
  log.report_.size = surface_size(model);
  if (const ContactStep* contact = world.body(body).contact())
    log.report_.rounding =
        energy_at_rest(contact->surface().mass, log.report_.size, world.step_size());
  log.report_.start = place_of(world, body);
  return log;
}

BodyLog::BodyLog(std::size_t body, BodyFiles files, const ShapeLooks& looks, SharedLooks& shared)
    : body_(body), files_(std::move(files)), shape_looks_(looks), shared_(&shared) {}

Status BodyLog::observe(const SceneWorld& world) {
  const ContactBody& body = world.body(body_);
  look_at(body, moment_);
  const EnergyAccount account = world.account(body_);
  report_.account = account;
  report_.balance.observe(account.total(), account.remainder(), turnover(account));
  if (const ContactStep* contact = body.contact(); contact != nullptr && !world.asleep(body_))
    report_.rounding_of_springs += contact->record().rounding;
  report_.slip_max = larger(report_.slip_max, body.contact_account().slip);
  if (shape_looks_.due(moment_.steps, moment_.state.q)) note_shape(world);
  // The drawn surface can be at its deepest only if the contact points are.
  if (world.penetration_max(body_) > deepest_) note_depth(world);
  rebound_.observe(world, body_);
  if (files_.row_due(moment_.steps)) {
    const auto [pose, momenta] = place_of(world, body_);
    const TouchForces touching = touch_forces(world, body_);
    const Eigen::Quaterniond& turn = pose.rotation;
    further_ = {account.load,
                account.support,
                account.gravity,
                account.contact_given,
                account.friction,
                account.damping,
                pose.position.x(),
                pose.position.y(),
                pose.position.z(),
                turn.w(),
                turn.x(),
                turn.y(),
                turn.z(),
                momenta.linear.x(),
                momenta.linear.y(),
                momenta.linear.z(),
                momenta.angular.x(),
                momenta.angular.y(),
                momenta.angular.z(),
                account.restitution,
                account.hand,
                account.contact,
                body.contact_account().impulse / body.options().step,
                account.joint,
                touching.contact.x(),
                touching.contact.y(),
                touching.contact.z(),
                touching.hands.x(),
                touching.hands.y(),
                touching.hands.z()};
    if (Status s = files_.write_row(moment_, body.energy(), further_); !s) return s;
  }
  if (Status s = files_.write_surface(moment_, body); !s) return s;
  // Energy stored in contact is not yet energy of the body.
  const double own = account.total() - account.contact;
  const double rounding = report_.rounding + report_.rounding_of_springs;
  if (!(own <= rounding) && !moment_.bound.sound(own))
    report_.leave_bound(account.total(), moment_.time);
  return Success{};
}

void BodyLog::note_shape(const SceneWorld& world) {
  const ContactBody& body = world.body(body_);
  const Eigen::VectorXd& q = body.state().q;
  // Nothing is known of stretches here.
  if (shape_looks_.can_exceed(q, report_.farthest.distance, {-HUGE_VAL, HUGE_VAL})) {
    const VertexBlock& surface = body.model().surface();
    const Eigen::VectorXd moved = surface.rows * q;
    for (std::size_t v = 0; v < surface.rest.size(); ++v)
      report_.note_farthest({moved.segment<3>(3 * v).norm(), surface.vertex_ids[v]}, moment_.time);
  }
  note_depth(world);
}

void BodyLog::note_depth(const SceneWorld& world) {
  deepest_ = world.penetration_max(body_);
  // A sleeping body has not moved since the last measurement.
  if (world.asleep(body_)) return;
  report_.penetration_surface_max =
      std::max(report_.penetration_surface_max, depth_.measure(world, body_, shared_->near));
}

// Checks the methods whose energy balances to rounding. A run that ended early has its own reason.
void BodyLog::judge_balance() {
  const std::string& method = report_.integrator;
  if (method != "avf" && method != "ep2" && method != "ep4") return;
  const EnergyBalance& balance = report_.balance;
  if (report_.exit_code != 0 || balance.remainder_max <= kBalanceBound * balance.most() ||
      balance.remainder_max <= report_.rounding + report_.rounding_of_springs)
    return;
  report_.exit_code = exit_code(ErrorKind::kBound);
  report_.reason = fmt::format(
      "the energy balance has an error of {:.3g} J, more than {:g} of the {:.3g} J that were "
      "there or were given",
      balance.remainder_max, kBalanceBound, balance.most());
}

Status BodyLog::finish(const SceneWorld& world) {
  const ContactBody& body = world.body(body_);
  look_at(body, moment_);
  note_shape(world);
  report_.take_end(moment_);
  report_.rebound = rebound_.ratio();
  report_.end = place_of(world, body_);
  report_.account = world.account(body_);
  report_.reached = static_cast<double>(report_.steps) * world.step_size();
  report_.energy_initial = report_.account.at_start;
  report_.energy_final = report_.account.total();
  report_.high_band_final = body.energy().high_band;
  report_.work = report_.account.given() - report_.account.damping;
  report_.dissipated = -report_.account.damping;
  report_.penetration_max = world.penetration_max(body_);
  report_.contact_speed_max = world.contact_speed_max(body_);
  report_.passed_through = world.passed_through(body_);
  report_.contacts = world.contacts(body_);
  report_.asleep = world.asleep(body_);
  report_.begins_within = world.begins_within(body_);
  if (body.contact() != nullptr) {
    report_.friction_held_steps = body.contact()->record().held_steps;
    const std::vector<SceneCollider>& colliders = world.scene().colliders;
    for (std::size_t c = 0; c < colliders.size(); ++c)
      report_.collider_impulses.emplace_back(colliders[c].name, world.collider_impulse(body_, c));
  }
  judge_balance();
  return files_.finish(body.model(), report_.name, report_.files);
}

}  // namespace tremolo
