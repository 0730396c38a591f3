#include "runtime/apps/tremolo/run/watch.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

namespace tremolo {
namespace {

// The CSV's temporary file can be followed so closely.
constexpr std::chrono::seconds kFlushEvery{1};

// Steps between two measurements of the shape: it moves by the slow modes, and a measurement costs
// more than a step. With a fortieth of the slowest mode's period it misses 0.3 % of the amplitude
// at most.
std::int64_t steps_between_shapes(const Body& body) {
  constexpr std::int64_t kLeast = 10;
  const double slowest = std::sqrt(std::max(body.model().lambda()(0), 0.0));  // rad/s
  const double steps = 2 * std::numbers::pi / 40 / slowest / body.options().step;
  return steps < 1e6 ? std::max(kLeast, static_cast<std::int64_t>(steps)) : kLeast;
}

// Any method without a momentum of its own kind will do: the copy is never stepped.
Result<Body> make_seen(const Body& body, const SplitOptions& split) {
  IntegratorOptions settings;
  settings.step = body.options().step;
  settings.split = split;
  return Body::create(body.model().shared_from_this(), "verlet", settings);
}

}  // namespace

Result<Watch> Watch::create(const BodyScene& scene, const SceneWorld& world, std::int64_t block,
                            const int* first_probe, std::int64_t steps, BodyFiles files,
                            RunReport& report) {
  const Body& body = world.body(0);
  Result<Body> seen = make_seen(body, scene.body().options.split);
  if (!seen) return seen.error();
  Watch watch(scene, std::move(*seen), steps, std::move(files), report);
  watch.moments_.resize(static_cast<std::size_t>(block));
  for (Moment& moment : watch.moments_) look_at(body, moment);
  if (first_probe != nullptr) {
    Result<VertexRows> rows = body.model().vertex(*first_probe);
    if (!rows) return rows.error();
    watch.probe_ = std::move(rows->rows);
    if (Status s = take(watch.probe_response_, ShownResponse::create(body.model(), *first_probe));
        !s)
      return s.error();
  }
  const SceneOutputs& outputs = scene.file.outputs;
  if (!outputs.wav.empty())
    if (Status s =
            take(watch.sound_, WorldSound::create(outputs.listen, world, outputs.sound_steps));
        !s)
      return error_of_body(s.error(), world.name(0));
  return watch;
}

Watch::Watch(const BodyScene& scene, Body seen, std::int64_t steps, BodyFiles files,
             RunReport& report)
    : scene_(&scene),
      report_(&report),
      seen_(std::move(seen)),
      files_(std::move(files)),
      stretch_(std::make_unique<SurfaceStretch>(seen_.model())),
      shape_looks_(seen_.model(), steps_between_shapes(seen_), steps) {
  report_->size = surface_size(seen_.model());
}

void Watch::note(const SceneWorld& world) {
  if (!world.failed(0)) look_at(world.body(0), moments_[noted_++]);
}

Status Watch::look(const SceneWorld& world, std::span<const SceneWorld::Failure> failures,
                   WorldEnding& ending) {
  Result<bool> inside = true;
  for (const Moment& moment : std::span(moments_).first(std::exchange(noted_, 0))) {
    inside = observe(moment);
    if (!inside) return inside.error();
    if (!*inside) break;
  }
  if (*inside && !failures.empty()) report_->give_up(failures.front().report, world.body(0).time());
  ending.exit_code = report_->exit_code;
  ending.reason = report_->reason;
  const auto now = std::chrono::steady_clock::now();
  if (now - flushed_ <= kFlushEvery) return Success{};
  flushed_ = now;
  return files_.flush();
}

// False: the orbit has left its energy bound, and the report says so.
Result<bool> Watch::observe(const Moment& moment) {
  note_split(moment);
  Energy energy;
  if (seen_.set_state(moment.state.q, moment.state.p))
    energy = seen_.energy();
  else
    energy.potential = std::numeric_limits<double>::quiet_NaN();
  note_energy(moment, energy);
  if (files_.row_due(moment.steps))
    if (Status status = files_.write_row(moment, energy); !status) return status.error();
  if (Status status = files_.write_surface(moment, seen_); !status) return status.error();
  const bool inside = moment.bound.sound(energy.total());
  if (!inside) report_->leave_bound(energy.total(), moment.time);
  // At rest the shape does not change.
  const bool due = shape_looks_.due(moment.steps, moment.state.q);
  if (due && (moment.steps > 0 || !scene_->start.empty())) note_shape(moment);
  if (probe_.cols() > 0)
    report_->largest_probe = std::max(report_->largest_probe,
                                      (probe_ * moment.state.q + probe_response_(moment)).norm());
  if (sound_)
    sound_->add(moment.steps,
                [&moment](std::size_t) -> const Eigen::VectorXd& { return moment.state.q; });
  last_ = moment;
  return inside;
}

void Watch::note_energy(const Moment& moment, const Energy& energy) {
  drift_.observe(energy.total(), moment.work, moment.dissipated, moment.loaded);
  report_->energy_put_in = std::max(report_->energy_put_in, report_->energy_initial + moment.work);
  // At the start it is the energy that is there.
  if (moment.loaded || was_loaded_) report_->energy_reference = energy.total();
  was_loaded_ = moment.loaded;
  report_->energy_final = energy.total();
  report_->high_band_final = energy.high_band;
}

void Watch::note_split(const Moment& moment) {
  if (moment.steps > 0 && last_.split && moment.split && last_.split->low != moment.split->low)
    report_->moves.push_back({last_.time, last_.split->low, moment.split->low});
}

void Watch::note_shape(const Moment& moment) {
  shape_seen_ = moment.steps;
  if (!shape_looks_.can_exceed(moment.state.q, report_->farthest.distance, report_->stretch))
    return;
  const StretchRange now = stretch_->measure(seen_);
  report_->stretch.smallest = std::min(report_->stretch.smallest, now.smallest);
  report_->stretch.largest = std::max(report_->stretch.largest, now.largest);
  if (report_->squeezed_at < 0 && now.smallest < kSofteningStretch)
    report_->squeezed_at = moment.time;
  report_->note_farthest(stretch_->farthest(), moment.time);
}

Status Watch::finish() {
  if (last_.steps > 0 && shape_seen_ != last_.steps) note_shape(last_);
  report_->take_end(last_);
  report_->energy_drift_max = drift_.worst();
  if (sound_)
    if (Status status = sound_->write(scene_->file.outputs.wav); !status) return status;
  const bool whole = report_->signal == 0;
  return files_.finish(seen_.model(), whole ? report_->integrator : "", report_->files);
}

}  // namespace tremolo
