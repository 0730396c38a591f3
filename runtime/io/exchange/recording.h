// Records moving bodies as an Animation, frame by frame.
#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/result.h"
#include "runtime/bodies/reduced/bones/skin.h"
#include "runtime/body.h"
#include "runtime/contact/collider.h"
#include "runtime/io/exchange/animation.h"
#include "runtime/model.h"

namespace tremolo {

// The drawn surface of the model (Model::drawn) as a shape. A rigid sphere, capsule or
// cylinder (Model::solid) has the surface of collider_shape() instead. Any other rigid body, unless
// its surface was made by an author, has more vertices, behind the others: both sides of sharp
// edges have theirs.
AnimatedShape animated_shape(const Model& model, std::string name);

// In each frame every track is recorded once. The body of a track that is added after the first
// frame is there from the first frame in which it is recorded; after end() it is gone. Not for a
// step loop: it allocates.
class Recording {
 public:
  // rate: requested frames per second, for formats without times.
  explicit Recording(double rate = 60.0) { animation_.rate = rate; }

  // Adds a body of this model; bodies of one model share its shape. skin: of a body on bones.
  // Returns the track's number. kUsage for a name that is empty or not unique, or for a skin of
  // another surface.
  Result<std::size_t> add(const Model::Pointer& model, std::string name,
                          const std::shared_ptr<const Skin>& skin = nullptr);
  Result<std::size_t> add(const Body& body, std::string name);
  // Scenery: a shape without coordinates.
  Result<std::size_t> add(AnimatedShape shape, std::string name);
  // A body that moves by its vertices. shape: the number that add_shape() returned.
  std::size_t add_shape(AnimatedShape shape);
  Result<std::size_t> add_free(std::size_t shape, std::string name);
  bool has_name(const std::string& name) const;      // of a track
  std::size_t coordinates(std::size_t track) const;  // 0: it has none, or there is no such track

  // time: s, later than the last frame's. kUsage if it is not, or the last frame lacks a track.
  Status begin_frame(double time);
  // q: as many as the model has, finite. poses: one, or one per bone. kUsage, with nothing
  // recorded, also for a track that does not exist or that this frame has already.
  Status record(std::size_t track, std::span<const double> q, std::span<const Pose> poses);
  Status record(std::size_t track, const Body& body);
  // Of add_free(): displacements from the shape at the pose, 3 for each vertex, m.
  Status record_free(std::size_t track, std::span<const double> displacements, const Pose& pose);
  // The body is gone: from the present frame on, or from the next one if that has it. kUsage: there
  // is no such track.
  Status end(std::size_t track);

  std::size_t frames() const { return animation_.frames(); }
  // All frames; tracks that were never recorded are left out. kUsage if the last frame lacks a
  // track, and as check_animation.
  Result<Animation> animation() const;

 private:
  // The frames of a track.
  struct Frames {
    std::size_t first = 0, count = 0;
    bool late = false;  // it was added after the first frame
    bool over = false;
  };

  Status add_body(AnimatedBody body);
  Status check_whole() const;
  Status check_track(std::size_t track) const;
  Status begin_record(std::size_t track, std::size_t poses) const;
  void end_record(std::size_t track);

  Animation animation_;                         // of each body the frames in which it is recorded
  std::vector<Model::Pointer> models_;          // keeps the addresses below
  std::map<const Model*, std::size_t> shapes_;  // of models
  std::vector<Frames> frames_;                  // of each track
  std::vector<Pose> poses_;                     // of one body
};

// Computes modes for a recorded motion without any, for formats that move vertices by few numbers
// per frame.

// Gives each body with displacements u a shape of its own whose modes are optimal for the recording
// in the mean square: with D = (u_1 ... u_f), the left singular vectors of D, largest singular
// values first, by the eigenvectors of D^T D (Sirovich 1987, method of snapshots). Their number is
// the smallest for which every vertex is within `enough` of the shape's size at every frame, and at
// most `most`. Other bodies stay. Returns the largest error over all vertices and frames, relative
// to the size of the shape. Errors: check_animation's.
Result<double> describe_by_modes(Animation& animation, std::size_t most = 160,
                                 double enough = 1e-3);

// Colliders as triangles, to be seen. The shape in its own frame, with an error of a thousandth of
// a sphere's radius. plane: half the side of the square that represents a plane, m, above 0.
// Nothing for a grid, which has distances instead of triangles.
std::optional<AnimatedShape> collider_shape(const Collider& collider, const std::string& name,
                                            double plane);

}  // namespace tremolo
