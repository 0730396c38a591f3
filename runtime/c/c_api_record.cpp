// C functions tremolo_recorder_*: record moving bodies and write files.
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "runtime/c/record_c_api.h"
#include "runtime/io/exchange/animation_writer.h"
#include "runtime/io/page/document.h"

namespace {

using tremolo::Animation;
using tremolo::Pose;
using tremolo::Result;
using tremolo::Status;
using tremolo::Success;
using tremolo::c_api::recording;

Status keep_track(const Result<std::size_t>& added, size_t* track) {
  if (!added) return added.error();
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
  return recording(recorder,
                   {{body, "the body"}, {name, "the name"}, {track, "the place for the track"}},
                   [&](tremolo_recorder& known) {
                     return keep_track(known.recording.add(body->body, name), track);
                   });
}

tremolo_status tremolo_recorder_add_model(tremolo_recorder* recorder, const tremolo_model* model,
                                          const char* name, size_t* track) {
  return recording(recorder,
                   {{model, "the model"}, {name, "the name"}, {track, "the place for the track"}},
                   [&](tremolo_recorder& known) {
                     return keep_track(known.recording.add(model->pointer, name), track);
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
    if (const std::size_t modes = known.recording.coordinates(track); length < modes)
      all.resize(modes);
    Pose pose;
    if (position != nullptr) pose.position = Eigen::Vector3d(position);
    if (quaternion != nullptr)
      pose.rotation =
          Eigen::Quaterniond(quaternion[0], quaternion[1], quaternion[2], quaternion[3]);
    return known.recording.record(track, all, std::span(&pose, 1));
  });
}

tremolo_status tremolo_recorder_end_track(tremolo_recorder* recorder, size_t track) {
  return recording(recorder, {},
                   [&](tremolo_recorder& known) { return known.recording.end(track); });
}

tremolo_status tremolo_recorder_write(tremolo_recorder* recorder, const char* path) {
  return recording(recorder, {{path, "the path"}}, [&](tremolo_recorder& known) -> Status {
    Result<Animation> animation = known.recording.animation();
    if (!animation) return animation.error();
    tremolo::widen_planes(*animation);
    const std::string_view name(path);
    const bool page = name.ends_with(".html");
    if (page || name.ends_with(".glb"))
      if (const auto described = tremolo::describe_by_modes(*animation); !described)
        return described.error();
    if (page) {
      const auto written = tremolo::write_motion_page(path, *animation);
      return written ? Status(Success{}) : Status(written.error());
    }
    const auto written = tremolo::write_animation(path, *animation);
    return written ? Status(Success{}) : Status(written.error());
  });
}
