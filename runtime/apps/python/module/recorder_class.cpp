// The class tremolo.Recorder: motions of bodies as files of other programs.
#include <cmath>
#include <string_view>
#include <utility>

#include "runtime/apps/python/module/body_handle.h"
#include "runtime/io/exchange/animation_writer.h"
#include "runtime/io/exchange/recording.h"
#include "runtime/io/page/document.h"

namespace tremolo::python {
namespace {

struct Recorder {
  Recording recording;
  std::vector<BodyPointer> bodies;
};

void add(Recorder& self, const BodyPointer& body, const std::string& name) {
  if (self.recording.frames() > 0)
    raise(usage_error("the recorder has frames already: add '" + name + "' before the first one"));
  const BodyHandle::Call call(*body);
  unwrap(self.recording.add(body->body(), name));
  self.bodies.push_back(body);
}

void frame(Recorder& self, py::object time) {
  if (self.bodies.empty()) raise(usage_error("the recorder has no body: add one first"));
  double t = 0.0;
  if (time.is_none()) {
    const BodyHandle::Call call(*self.bodies.front());
    t = self.bodies.front()->body().time();
  } else {
    t = time.cast<double>();
  }
  check(self.recording.begin_frame(t));
  for (std::size_t i = 0; i < self.bodies.size(); ++i) {
    const BodyHandle::Call call(*self.bodies[i]);
    check(self.recording.record(i, self.bodies[i]->body()));
  }
}

py::list write(const Recorder& self, py::handle path_object) {
  const std::string path = path_text(path_object);
  const Animation animation = unwrap(self.recording.animation());
  py::list paths;
  if (std::string_view(path).ends_with(".html")) {
    paths.append(unwrap(write_motion_page(path, animation)).path);
    return paths;
  }
  Result<std::vector<WrittenFile>> files = write_animation(path, animation);
  if (!files && files.error().kind == ErrorKind::kUsage)
    raise(usage_error(files.error().message + ", a page of the motion in .html"));
  for (const WrittenFile& file : unwrap(std::move(files))) paths.append(file.path);
  return paths;
}

}  // namespace

void add_recorder(py::module_& module) {
  py::class_<Recorder> c(module, "Recorder",
                         "Records moving bodies, frame by frame, and writes the motion for other "
                         "programs.");
  refuse_construction(c, "tremolo.recorder() makes one");
  module.def(
      "recorder",
      [](double rate) {
        if (!std::isfinite(rate) || rate <= 0)
          raise(usage_error("rate: " + text_of(py::float_(rate)) +
                            ", must be a number of frames per second above 0"));
        return Recorder{Recording(rate), {}};
      },
      py::kw_only(), py::arg("rate") = 60.0,
      "A tremolo.Recorder. rate: frames per second, for formats without times.");
  c.def("add", &add, py::arg("body"), py::arg("name"),
        "Adds a body, before the first frame; its name is unique.");
  c.def("frame", &frame, py::arg("time") = py::none(),
        "Records all bodies as they are. time: s, later than the last frame's; by default that of "
        "the first body.");
  c.def_property_readonly(
      "frames", [](const Recorder& self) { return self.recording.frames(); }, "Number of frames.");
  c.def("write", &write, py::arg("path"),
        "Writes the motion; the ending names the format: .glb, .usda, .pvd, .pc2, .mdd, .ply or "
        ".obj (a series), .html. Returns the paths of all files that were written.");
}

}  // namespace tremolo::python
