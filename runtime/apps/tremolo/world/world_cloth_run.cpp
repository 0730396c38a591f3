#include "runtime/apps/tremolo/world/world_cloth_run.h"

#include <cmath>
#include <iterator>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "runtime/apps/tremolo/measure/cloth_log.h"
#include "runtime/apps/tremolo/output/tell.h"
#include "runtime/apps/tremolo/output/text_values.h"
#include "runtime/apps/tremolo/world/guest_report.h"
#include "runtime/energy_bound.h"

namespace tremolo {
namespace {

constexpr const char* kClothColumns =
    "t,kinetic,elastic,contact,total,gravity,wind,support,contact_given,restitution,friction,"
    "damping,method,px,py,pz,lx,ly,lz,penetration";

}  // namespace

double WorldClothRun::Account::turnover() const {
  double sum = 0.0;
  for (const double part : {work.gravity, work.wind, work.pins, work.damped, given, restitution,
                            friction, hand, joint, load, work.numerical})
    sum += std::abs(part);
  return sum;
}

Result<WorldClothRun> WorldClothRun::create(const MixedFile& mixed, const WorldGuests& guests,
                                            std::int64_t first) {
  WorldClothRun run;
  run.mixed_ = &mixed;
  run.guests_ = &guests;
  const std::int64_t steps = std::llround(mixed.file.scene.duration / mixed.file.scene.step);
  for (std::size_t i = 0; i < mixed.cloths.size(); ++i) {
    const ClothSceneBody& body = mixed.cloths[i];
    const GuestEnergy& start = guests.at_start[guests.of_cloth(i)];
    Watched& watched = run.watched_.emplace_back();
    watched.at_start = start.kinetic + start.elastic;
    watched.outputs = outputs_of_body(mixed.file.outputs, body.name());
    watched.frames = Frames(watched.outputs, {first, steps});
    if (Status s = make_run_folder(watched.outputs.out); !s) return s.error();
    if (Status s = take(watched.probes,
                        GuestProbes::create(*guests.guests, guests.of_cloth(i), body.probes));
        !s)
      return Error{s.error().kind, "body '" + body.name() + "': " + s.error().message};
    const std::string columns = kClothColumns + std::string(kHeldColumns);
    if (Status s = take(watched.table, CsvTable::create(table_path(watched.outputs),
                                                        columns + watched.probes.columns()));
        !s)
      return s.error();
  }
  return run;
}

WorldClothRun::Account WorldClothRun::account_of(std::size_t i) const {
  const ClothBody& body = step_of(i).body();
  const ContactSums& sums = guests_->guests->sums(number(i));
  return {.kinetic = body.kinetic_energy(),
          .elastic = body.elastic_energy(),
          .contact = guests_->guests->account(number(i)).energy,
          .work = body.work(),
          .given = sums.given,
          .restitution = 0.0 - sums.lost,
          .friction = 0.0 - sums.friction_loss,
          .hand = sums.hand,
          .joint = sums.joint,
          .load = guests_->guests->load_work(number(i))};
}

void WorldClothRun::watch(std::size_t i, bool first) {
  Watched& watched = watched_[i];
  const ClothBody& body = step_of(i).body();
  watched.now = account_of(i);
  watched.momenta_now = body.momenta();
  if (first) watched.momenta_start = watched.momenta_now;
  const Account& now = watched.now;
  watched.balance.observe(now.total(), now.total() - watched.at_start - now.by_causes(),
                          now.turnover());
  if (watched.exit_code != 0) return;
  const double own = now.kinetic + now.elastic;
  if (guests_->guests->failed(number(i)))
    watched.give_up(body.time());
  else if (!std::isfinite(own) || own > kEnergyBound * (watched.at_start + now.turnover()))
    watched.leave_bound(own, body.time());
}

Status WorldClothRun::write(std::size_t i) {
  Watched& watched = watched_[i];
  const ClothBody& body = step_of(i).body();
  if (watched.table.is_written() && body.steps() % watched.outputs.every == 0) {
    const Account& now = watched.now;
    const Momenta& momenta = watched.momenta_now;
    auto out = std::back_inserter(watched.table.row());
    fmt::format_to(out, "{:.9g}", body.time());
    for (const double value :
         {now.kinetic, now.elastic, now.contact, now.total(), now.work.gravity, now.work.wind,
          now.work.pins, now.given, now.restitution, now.friction, -now.work.damped,
          now.work.numerical, momenta.linear.x(), momenta.linear.y(), momenta.linear.z(),
          momenta.angular.x(), momenta.angular.y(), momenta.angular.z(),
          guests_->guests->penetration_max(number(i))})
      fmt::format_to(out, ",{:.12g}", value);
    for (const double value : further_values(*guests_->guests, number(i), watched.probes))
      fmt::format_to(out, ",{:.12g}", value);
    if (Status s = watched.table.end_row(); !s) return s;
  }
  if (!watched.frames.due(body.steps())) return Success{};
  return watched.frames.write(body.time(), [&body](const std::string& path) {
    return write_cloth_surface(body.model().parts(), body.state().x, path);
  });
}

Status WorldClothRun::observe() {
  for (std::size_t i = 0; i < watched_.size(); ++i) {
    if (watched_[i].exit_code != 0) continue;
    watch(i, !started_);
    if (Status s = write(i); !s) return s;
  }
  started_ = true;
  return Success{};
}

void WorldClothRun::ended(RunEnding& ending) const {
  for (std::size_t i = 0; i < watched_.size(); ++i)
    ending.take(mixed_->cloths[i].name(), watched_[i]);
}

Status WorldClothRun::finish() {
  for (Watched& one : watched_)
    if (Status s = finish_files(one.outputs, one.frames, one.table, one.files); !s) return s;
  return Success{};
}

nlohmann::ordered_json WorldClothRun::body_json(std::size_t i) const {
  const Watched& watched = watched_[i];
  const ClothBody& body = step_of(i).body();
  const ClothParts& parts = body.model().parts();
  const Account& now = watched.now;
  nlohmann::ordered_json json = {
      {"body", body.cloth().name},
      {"kind", "cloth"},
      {"integrator", body.integrator()},
      {"particles", parts.particles()},
      {"springs", body.model().springs()},
      {"triangles", parts.triangles.size()},
      {"joined", parts.joined},
      {"mass", body.mass()},
      {"steps", body.steps()},
      {"reached", body.time()},
      {"iterations_per_step",
       number_or_null(static_cast<double>(body.iterations()) / static_cast<double>(body.steps()))},
      {"cut_steps", body.cut_steps()}};
  add_momenta(watched.momenta_start, watched.momenta_now, json);
  json["energy_initial"] = number_or_null(watched.at_start);
  json["energy_final"] = number_or_null(now.total());
  json["energy_max"] = number_or_null(watched.balance.energy_max);
  json["kinetic_final"] = number_or_null(now.kinetic);
  json["elastic_final"] = number_or_null(now.elastic);
  json["energy_by_cause"] = {{"load", number_or_null(now.load)},
                             {"gravity", number_or_null(now.work.gravity)},
                             {"wind", number_or_null(now.work.wind)},
                             {"support", number_or_null(now.work.pins)},
                             {"contact", number_or_null(now.given)},
                             {"friction", number_or_null(now.friction)},
                             {"restitution", number_or_null(now.restitution)},
                             {"damping", number_or_null(0.0 - now.work.damped)},
                             {"hand", number_or_null(now.hand)},
                             {"joint", number_or_null(now.joint)},
                             {"method", number_or_null(now.work.numerical)}};
  json["energy_balance_error"] = number_or_null(watched.balance.error());
  add_guest_contacts(*guests_->guests, number(i), body.options().step, json);
  json["thickness"] = body.cloth().thickness;
  add_ending(watched, json);
  json["files"] = watched.files;
  return json;
}

void WorldClothRun::print() const {
  for (std::size_t i = 0; i < watched_.size(); ++i) {
    const Watched& watched = watched_[i];
    const Account& now = watched.now;
    tell(
        "  {} (cloth, {}): energy {:.6g} -> {:.6g} J; gravity {:.4g}, wind {:.4g}, support {:.4g}, "
        "contact {:.4g}, restitution {:.4g}, friction {:.4g}, hand {:.4g}, joint {:.4g}, load "
        "{:.4g}, damping "
        "{:.4g}, the method itself {:.4g} J; {} contacts, its particles {:.3g} m deep at most\n",
        mixed_->cloths[i].name(), mixed_->cloths[i].scene.integrator, watched.at_start, now.total(),
        now.work.gravity, now.work.wind, now.work.pins, now.given, now.restitution, now.friction,
        now.hand, now.joint, now.load, 0.0 - now.work.damped, now.work.numerical,
        guests_->guests->contacts(number(i)), guests_->guests->penetration_max(number(i)));
    if (!watched.files.empty()) tell("    wrote {}\n", list_files(watched.files));
  }
}

std::vector<std::string> WorldClothRun::files() const {
  std::vector<std::string> files;
  for (const Watched& watched : watched_)
    files.insert(files.end(), watched.files.begin(), watched.files.end());
  return files;
}

}  // namespace tremolo
