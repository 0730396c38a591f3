// The camera of a picture.
//
// A camera is `distance` metres from `target`, in the direction given by azimuth and elevation. If
// both are zero it is towards -y of a world with z up (towards +z of one with y up, that is in
// front). A positive azimuth moves it counter-clockwise seen from above, a positive elevation moves
// it up.
#pragma once

#include <optional>
#include <span>
#include <string>

#include <Eigen/Core>

#include "common/result.h"

namespace tremolo {

enum class UpAxis { kY, kZ };

struct Camera {
  Eigen::Vector3d target = Eigen::Vector3d::Zero();  // m, world
  double azimuth = 0.0;                              // rad
  double elevation = 0.0;                            // rad, within a right angle
  double distance = 1.0;                             // m
  double view_angle = 0.42;                          // rad, from the lower to the upper edge
  UpAxis up = UpAxis::kZ;
  double shift = 0.0;  // by which the target is right of the picture's middle, in half widths
};

struct PictureSize {
  int width = 1280, height = 720;
  double aspect() const { return static_cast<double>(width) / height; }
};

// The world's direction that is up, and the unit vectors of the picture: to the right, up, and from
// the target to the camera.
Eigen::Vector3d up_direction(UpAxis up);
struct CameraAxes {
  Eigen::Vector3d right, up, back;
};
CameraAxes axes_of(const Camera& camera);
Eigen::Vector3d eye_of(const Camera& camera);

// Maps the world to OpenGL's clip coordinates. radius: of a ball about `centre` that holds all that
// is drawn, m, by which the near and far planes are put.
Eigen::Matrix4d clip_from_world(const Camera& camera, double aspect, const Eigen::Vector3d& centre,
                                double radius);

// The ray from the eye through a point of the picture; x and y are measured from the upper left
// corner as fractions of its width and height.
struct CameraRay {
  Eigen::Vector3d origin, direction;
};
CameraRay ray_through(const Camera& camera, double aspect, double x, double y);

// Moves target and distance so that all points are in the picture with a margin around them, and
// as large as that allows. points: x y z x y z ..., m; of none the camera stays.
void frame_points(std::span<const double> points, double aspect, Camera& camera);

// --camera AZIMUTH,ELEVATION[,ZOOM]: degrees, and the magnification relative to the framed picture.
// Errors: kUsage for a text that is not such a list; kContent for an elevation beyond 90 degrees or
// a zoom that is not positive.
struct CameraWish {
  double azimuth = 0.0, elevation = 0.0;  // rad
  double zoom = 1.0;
};
Result<CameraWish> parse_camera(const std::string& text);

// --size WIDTHxHEIGHT in pixels, 16 to 8192 each. Errors: kUsage; kContent out of range.
Result<PictureSize> parse_size(const std::string& text);

}  // namespace tremolo
