// C functions tremolo_recorder_*: record moving bodies and write files.
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "runtime/c/c_api.h"
#include "runtime/io/exchange/animation_writer.h"
#include "runtime/io/exchange/recording.h"
#include "runtime/io/page/document.h"

// NOLINTBEGIN(readability-identifier-naming): the names of the C header
struct tremolo_recorder {
  tremolo::Recording recording;
  std::vector<std::size_t> modes = {};  // of each track
};
// NOLINTEND(readability-identifier-naming)

namespace {

using tremolo::Animation;
using tremolo::Pose;
using tremolo::Result;
using tremolo::Status;
using tremolo::Success;
using tremolo::c_api::Argument;

// Runs action(recorder) -> Status; kUsage for NULL, also of a further argument.
template <class Action>
tremolo_status recording(tremolo_recorder* recorder, std::initializer_list<Argument> further,
                         const Action& action) noexcept {
  return tremolo::c_api::guarded([&]() -> Status {
    if (Status s = tremolo::c_api::need({{recorder, "the recorder"}}); !s) return s;
    if (Status s = tremolo::c_api::need(further); !s) return s;
    return action(*recorder);
  });
}

Status keep_track(tremolo_recorder& recorder, const Result<std::size_t>& added,
                  const tremolo::Model& model, size_t* track) {
  if (!added) return added.error();
  recorder.modes.push_back(static_cast<std::size_t>(model.modes()));
  *track = *added;
  return Success{};
}

}  // namespace

tremolo_status tremolo_recorder_create(double rate, tremolo_recorder** recorder) {
  return tremolo::c_api::guarded([&]() -> Status {
    if (Status s = tremolo::c_api::need({{recorder, "the place for the recorder"}}); !s) return s;
    *recorder = new tremolo_recorder{tremolo::Recording(rate)};
    return Success{};
  });
}

void tremolo_recorder_destroy(tremolo_recorder* recorder) {
  delete recorder;
}

tremolo_status tremolo_recorder_add_body(tremolo_recorder* recorder, const tremolo_body* body,
                                         const char* name, size_t* track) {
  return recording(
      recorder, {{body, "the body"}, {name, "the name"}, {track, "the place for the track"}},
      [&](tremolo_recorder& known) {
        return keep_track(known, known.recording.add(body->body, name), body->body.model(), track);
      });
}

tremolo_status tremolo_recorder_add_model(tremolo_recorder* recorder, const tremolo_model* model,
                                          const char* name, size_t* track) {
  return recording(
      recorder, {{model, "the model"}, {name, "the name"}, {track, "the place for the track"}},
      [&](tremolo_recorder& known) {
        return keep_track(known, known.recording.add(model->pointer, name), *model->pointer, track);
      });
}

tremolo_status tremolo_recorder_begin_frame(tremolo_recorder* recorder, double time) {
  return recording(recorder, {},
                   [&](tremolo_recorder& known) { return known.recording.begin_frame(time); });
}

tremolo_status tremolo_recorder_record_body(tremolo_recorder* recorder, size_t track,
                                            const tremolo_body* body) {
  return recording(recorder, {{body, "the body"}}, [&](tremolo_recorder& known) {
    return known.recording.record(track, body->body);
  });
}

tremolo_status tremolo_recorder_record_state(tremolo_recorder* recorder, size_t track,
                                             const double* q, size_t length,
                                             const double position[3], const double quaternion[4]) {
  return recording(recorder, {{q, "the coordinates"}}, [&](tremolo_recorder& known) -> Status {
    std::vector<double> all(q, q + length);
    // A level of detail has fewer than the model.
    if (track < known.modes.size() && length < known.modes[track]) all.resize(known.modes[track]);
    Pose pose;
    if (position != nullptr) pose.position = Eigen::Vector3d(position);
    if (quaternion != nullptr)
      pose.rotation =
          Eigen::Quaterniond(quaternion[0], quaternion[1], quaternion[2], quaternion[3]);
    return known.recording.record(track, all, std::span(&pose, 1));
  });
}

tremolo_status tremolo_recorder_write(tremolo_recorder* recorder, const char* path) {
  return recording(recorder, {{path, "the path"}}, [&](tremolo_recorder& known) -> Status {
    const Result<Animation> animation = known.recording.animation();
    if (!animation) return animation.error();
    if (std::string_view(path).ends_with(".html")) {
      const auto page = tremolo::write_motion_page(path, *animation);
      return page ? Status(Success{}) : Status(page.error());
    }
    const auto written = tremolo::write_animation(path, *animation);
    return written ? Status(Success{}) : Status(written.error());
  });
}
