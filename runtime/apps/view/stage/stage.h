// The bodies, colliders and hands of a world as drawn things.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/result.h"
#include "runtime/apps/view/camera/camera.h"
#include "runtime/apps/view/draw/renderer.h"
#include "runtime/apps/view/live/live_world.h"
#include "runtime/apps/view/picture/png_file.h"
#include "runtime/apps/view/shape/colour_by.h"
#include "runtime/apps/view/shape/creased_shape.h"
#include "runtime/apps/view/shape/surface_stress.h"
#include "runtime/bodies/reduced/surface/surface.h"
#include "runtime/contact/collider.h"

namespace tremolo {

// An image for a material of the drawn surface; an empty name: for all that have texture
// coordinates.
struct StageImage {
  std::string material;
  Picture picture;
};

struct StageLook {
  ColourBy colour = ColourBy::kBody;
  bool colliders = true;
};

class Stage {
 public:
  // A context must be current, as long as the stage lives. live: before its first step; its models
  // must outlive the stage. paints: a colour per body and then per guest, linear light. solids: a
  // material for each, if it is known. Errors: kContent for an image whose material no body has, or
  // for images if no body has texture coordinates; for a body without a surface.
  static Result<std::unique_ptr<Stage>> create(const LiveWorld& live, UpAxis up,
                                               const std::vector<Eigen::Vector3f>& paints,
                                               const std::vector<StageImage>& images,
                                               const std::vector<std::optional<Material>>& solids);

  // Computes all positions and normals at the given time. Needs no OpenGL.
  void pose(const WorldMoment& moment);
  // Uploads them to the card, with the stresses if those are shown.
  void upload(const StageLook& look);
  // The drawn things, valid until the next call; call it after upload(). A collider between the eye
  // (m, world) and the middle of a body is drawn as glass.
  const std::vector<DrawnThing>& things(const StageLook& look, const Eigen::Vector3d& eye);
  // The ball around everything that casts shadows in the last pose(); it does not shrink.
  const ShownBall& ball() const { return ball_; }

  // All drawn vertices of bodies in the last pose(), x y z ..., m, world; empty for a world without
  // bodies.
  std::vector<double> points() const;
  // The height of the ground along the up axis, m, and whether there is one: that of a collider
  // that is a level plane, else of the lowest point in the first pose; none if a body is free and
  // nothing stops it.
  double ground() const { return ground_; }
  bool has_ground() const { return has_ground_; }
  // The largest displacement of a vertex in its body's frame, m, of the last pose().
  float most_moved() const { return most_moved_; }
  // The largest stress of a vertex, Pa, in the last upload() that computed it.
  float most_stressed() const { return most_stressed_; }
  // The names of bodies without texture coordinates, if others have an image; not those of rigid
  // bodies, which never have any.
  std::vector<std::string> without_image() const;
  // True if the stress of at least one body can be computed; if there are bodies of tetrahedra.
  bool knows_stress() const;
  bool knows_degrees() const;

 private:
  struct MaterialRange {
    std::size_t first, count, material;
    GLuint image = 0;  // 0: none
    bool tiled = false;
  };
  // A body of the world, or a guest, which has no model.
  struct StagedBody {
    std::string name;
    Model::Pointer model;
    CreasedSheet sheet;  // of the positions and normals below; not of a rigid body
    GpuMesh mesh;
    std::vector<MaterialRange> ranges;
    Paint paint = Paint::kOne;
    Eigen::Vector3f colour;
    Pose pose;
    std::vector<float> positions, normals;
    bool is_rigid = false;  // `mesh` and `positions` are of a shape that stays as it is
    bool has_uvs = false;
    Eigen::Vector3d middle = Eigen::Vector3d::Zero();  // of its box, m, world
    bool own_frame = true;
    std::optional<SurfaceStress> stress;
    std::vector<float> stresses, number_paint, own_paint;  // of vertices; the paints r g b a
    // Of a guest: at rest, m; distances from there in its frame, m; degrees of tetrahedra.
    std::vector<Eigen::Vector3d> rest;
    std::vector<float> distances, degrees;
    bool is_cloth = false;
  };
  struct StagedCollider {
    GpuMesh mesh;
    TriangleShape shape;
    Collider solid;
    Pose pose;
    bool is_ground = false, is_plane = false;
    float yields = 0.0f;  // m, as DrawnThing has it
  };

  Stage() = default;
  void add_body(const std::string& name, const Body& body, const Eigen::Vector3f& colour,
                const std::optional<Material>& solid);
  static void add_rigid(StagedBody& body);
  static void add_ranges(StagedBody& body, const std::vector<std::size_t>& order);
  static void add_mesh(StagedBody& body, const std::vector<Eigen::Vector3d>& rest,
                       std::span<const Eigen::Vector2f> uvs);
  Status add_guests(const LiveGuests& guests, const std::vector<Eigen::Vector3f>& paints);
  void upload_stress(StagedBody& body);
  static void upload_numbers(StagedBody& body, const std::vector<float>& numbers);
  static const std::vector<float>* numbers_of(const StagedBody& body, ColourBy colour);
  Status add_images(const std::vector<StageImage>& images);
  void add_colliders(const SceneWorld& world);
  void find_ground(const LiveWorld& live);
  void pose_bodies(const WorldMoment& moment);
  void enclose();
  void add_hands(std::vector<DrawnThing>& things) const;
  bool hides_a_body(const StagedCollider& collider, const Eigen::Vector3d& eye) const;
  template <class Hides>
  static bool hides_most(const StagedBody& cloth, const Hides& hides);
  void add_body_things(const StagedBody& body, const StageLook& look);

  UpAxis up_ = UpAxis::kZ;
  std::vector<StagedBody> bodies_;
  std::vector<StagedCollider> colliders_;
  std::vector<HandMoment> hands_;
  std::vector<GlHandle> images_;
  GpuMesh hand_mesh_;
  SurfaceWorkspace workspace_;
  std::vector<DrawnThing> things_;
  ShownBall ball_;
  bool posed_ = false;
  double ground_ = 0.0, size_ = 1.0;
  bool has_ground_ = true;
  float most_moved_ = 0.0f, most_stressed_ = 0.0f;
  double edge_ = 0.0;  // m, at first, of the guests' triangles: the mean of the coarsest guest
};

// Solids yield to what rests on them by its vertices (DrawnThing::yields): by an edge of its
// triangles, of which half is cut off at a right angle, but by no more than this, m: half of the
// solid's least extent, since behind it things are hidden. A plane does not yield.
float most_yield(const Collider& solid);

// "#rrggbb" as linear light, 0 to 1 each.
Eigen::Vector3f linear_colour(std::uint32_t rgb);

}  // namespace tremolo
