#include "runtime/apps/tremolo/world/world_tets_run.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "runtime/apps/tremolo/output/tell.h"
#include "runtime/apps/tremolo/output/text_values.h"
#include "runtime/apps/tremolo/world/guest_report.h"

namespace tremolo {

Result<WorldTetsRun> WorldTetsRun::create(const MixedFile& mixed, const WorldGuests& guests,
                                          std::int64_t first) {
  WorldTetsRun run;
  run.mixed_ = &mixed;
  run.tets_ = &guests;
  TetScene scene;
  scene.bodies = mixed.tets;
  scene.outputs = mixed.file.outputs;
  scene.step = mixed.file.scene.step;
  scene.duration = mixed.file.scene.duration;
  for (std::size_t i = 0; i < mixed.tets.size(); ++i) {
    Result<GuestProbes> probes =
        GuestProbes::create(*guests.guests, i, mixed.tets[i].probes, mixed.tets[i].pose);
    if (!probes)
      return Error{probes.error().kind,
                   "body '" + mixed.tets[i].name + "': " + probes.error().message};
    Result<TetsLog> log =
        TetsLog::create(scene, run.tets_->kind(i), i, first, kHeldColumns + probes->columns());
    if (!log) return log.error();
    run.probes_.push_back(std::move(*probes));
    run.logs_.push_back(std::move(*log));
  }
  run.watched_.resize(run.logs_.size());
  for (std::size_t i = 0; i < run.logs_.size(); ++i) {
    const GuestEnergy& start = guests.at_start[i];
    run.watched_[i].start = {start.kinetic, start.elastic, start.gravity, 0.0};
  }
  return run;
}

// midpoint and newmark add energy where stiff elements rotate in long steps.
void WorldTetsRun::Watched::leave_bound(double own, TetMethod method, double time) {
  RunEnding::leave_bound(own, time);
  const bool adds = method == TetMethod::kMidpoint || method == TetMethod::kNewmark;
  reason += fmt::format("; try a shorter step{}, or a larger beta",
                        adds ? ", `integrator = \"bdf2\"`" : "");
}

// The energy put in is the work of gravity, contact, hands, joints and loads.
void WorldTetsRun::watch(std::size_t i, bool first) {
  Watched& watched = watched_[i];
  TetBody& body = tets_->guests->tets(i)->body();
  watched.now = {body.kinetic_energy(), body.elastic_energy(), body.gravity_energy(),
                 tets_->guests->account(i).energy};
  watched.momenta_now = {body.momentum(), body.angular_momentum()};
  const double own = watched.now.kinetic + watched.now.elastic;
  if (first) watched.momenta_start = watched.momenta_now;
  const ContactSums& sums = tets_->guests->sums(i);
  const double contact = tets_->guests->account(i).energy;
  const bool sound = watched.bound.look(
      own + contact, watched.now.gravity,
      sums.work + sums.hand + sums.joint + tets_->guests->load_work(i) + contact);
  watched.energy_max = std::max(watched.energy_max, watched.now.total());
  if (watched.exit_code != 0) return;
  if (tets_->guests->failed(i))
    watched.give_up(body.time());
  else if (!sound)
    watched.leave_bound(own, body.options().method, body.time());
}

Status WorldTetsRun::observe() {
  for (std::size_t i = 0; i < logs_.size(); ++i) {
    if (watched_[i].exit_code != 0) continue;
    TetBody& body = tets_->guests->tets(i)->body();
    const TetSurface& surface = *tets_->kind(i).surface;
    vertices_.resize(surface.vertices());
    normals_.resize(surface.vertices());
    surface.place(body.positions(), vertices_, normals_);
    watch(i, !started_);
    const TetStep& step = *tets_->guests->tets(i);
    if (Status s = logs_[i].observe(body, step.report(), step.sums(), vertices_, normals_,
                                    tets_->guests->is_pushed(i),
                                    further_values(*tets_->guests, i, probes_[i]));
        !s)
      return s;
  }
  started_ = true;
  return Success{};
}

void WorldTetsRun::ended(RunEnding& ending) const {
  for (std::size_t i = 0; i < watched_.size(); ++i) ending.take(mixed_->tets[i].name, watched_[i]);
}

std::string WorldTetsRun::inverted_text() const {
  std::string text;
  for (std::size_t i = 0; i < logs_.size(); ++i)
    if (const std::size_t count = logs_[i].report().inverted; tets_->guests->failed(i) && count > 0)
      text += fmt::format(
          "; {} elements of '{}' are inside out: it is too soft for its load, or held or pulled at "
          "too few vertices",
          count, mixed_->tets[i].name);
  return text;
}

Status WorldTetsRun::finish() {
  for (TetsLog& log : logs_)
    if (Status s = log.finish(); !s) return s;
  return Success{};
}

nlohmann::ordered_json WorldTetsRun::body_json(std::size_t i) const {
  const Watched& watched = watched_[i];
  const ContactSums& sums = tets_->guests->sums(i);
  const TetBody& body = tets_->guests->tets(i)->body();
  nlohmann::ordered_json json = tets_report_json(mixed_->tets[i], body, logs_[i].report());
  json["kind"] = "tets";
  add_momenta(watched.momenta_start, watched.momenta_now, json);
  json["energy_initial"] = number_or_null(watched.start.total());
  json["energy_final"] = number_or_null(watched.now.total());
  json["energy_max"] = number_or_null(watched.energy_max);
  const double gravity = watched.start.gravity - watched.now.gravity;
  const double load = tets_->guests->load_work(i);
  const double method = watched.now.total() - watched.start.total() - gravity - sums.given +
                        sums.lost + sums.friction_loss - sums.hand - sums.joint - load;
  json["energy_by_cause"] = {{"load", number_or_null(load)},
                             {"gravity", number_or_null(gravity)},
                             {"contact", number_or_null(sums.given)},
                             {"friction", number_or_null(0.0 - sums.friction_loss)},
                             {"restitution", number_or_null(0.0 - sums.lost)},
                             {"hand", number_or_null(sums.hand)},
                             {"joint", number_or_null(sums.joint)},
                             {"method", number_or_null(method)}};
  // All that is not of contact is in `method`; the account of contact closes by itself.
  json["energy_balance_error"] =
      number_or_null(watched.energy_max > 0.0 ? std::abs(sums.error) / watched.energy_max : 0.0);
  add_guest_contacts(*tets_->guests, i, body.options().step, json);
  add_ending(watched, json);
  return json;
}

void WorldTetsRun::print() const {
  for (std::size_t i = 0; i < logs_.size(); ++i) {
    const TetsReport& report = logs_[i].report();
    const ContactSums& sums = tets_->guests->sums(i);
    tell(
        "  {} (tets, {}): energy {:.6g} -> {:.6g} J; contact {:.4g}, restitution {:.4g}, friction "
        "{:.4g}, hand {:.4g}, joint {:.4g}, load {:.4g} J; {} contacts, its points {:.3g} m deep "
        "at most\n",
        mixed_->tets[i].name, tet_method_name(mixed_->tets[i].options.method),
        watched_[i].start.total(), watched_[i].now.total(), sums.given, 0.0 - sums.lost,
        0.0 - sums.friction_loss, sums.hand, sums.joint, tets_->guests->load_work(i),
        tets_->guests->contacts(i), tets_->guests->penetration_max(i));
    if (!report.files.empty()) tell("    wrote {}\n", list_files(report.files));
  }
}

std::vector<std::string> WorldTetsRun::files() const {
  std::vector<std::string> files;
  for (const TetsLog& log : logs_)
    files.insert(files.end(), log.report().files.begin(), log.report().files.end());
  return files;
}

}  // namespace tremolo
