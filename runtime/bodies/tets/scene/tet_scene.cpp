#include "runtime/bodies/tets/scene/tet_scene.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <utility>

#include <Eigen/Geometry>

#include "common/overflow.h"
#include "formats/tets/tets_file.h"

namespace tremolo {
namespace {

Result<TetsKind> read_tets_kind(const TetSceneBody& body) {
  std::error_code ignored;
  if (!std::filesystem::exists(body.model, ignored)) {
    const std::string usual = "tremolo-precompute tets MESH -o " + body.model;
    return system_error(body.model + ": there is no such file; it is made by `" +
                        (body.made_by.empty() ? usual : body.made_by) + "`");
  }
  Result<TetsFile> file = read_tets(body.model);
  if (!file) return file.error();
  TetsKind kind;
  kind.path = body.model;
  kind.held = !file->held.empty();
  if (Status s =
          take(kind.model, TetModel::create(std::move(file->mesh), file->materials, file->held));
      !s)
    return error_of_file(body.model, s.error());
  kind.hull = std::make_shared<const TetHull>(
      kind.model, surface_points(*kind.model, file->surface), std::move(file->grid));
  kind.surface = std::make_shared<const TetSurface>(kind.model, std::move(file->surface));
  return kind;
}

Error error_of_tets(const TetSceneBody& body, const std::string& path, const Error& error) {
  const std::string file = path.empty() ? "" : path + ": ";
  return Error{error.kind, file + "body '" + body.name + "': " + error.message};
}

// The rest shape at the body's pose, with its velocity and spin about the centre of mass; fixed
// points are at rest.
Status place_tets_body(const TetSceneBody& wanted, TetBody& body) {
  if (Status s = check_start_size(wanted.pose.position, wanted.velocity, wanted.spin); !s) return s;
  const TetModel& model = body.model();
  const Eigen::Index size = model.rest().size();
  const Eigen::VectorXd ones = Eigen::VectorXd::Ones(size);
  Eigen::VectorXd x(size), v = Eigen::VectorXd::Zero(size), weight(size);
  model.mass_times(ones, weight);
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  BodyScale scale{
      .mass = model.mass(), .gravity = wanted.options.gravity.norm(), .step = wanted.options.step};
  for (Eigen::Index i = 0; i < size; i += 3) {
    const Eigen::Vector3d rest = model.rest().segment<3>(i);
    x.segment<3>(i) = wanted.pose * rest;
    centre += weight[i] / model.mass() * x.segment<3>(i);
  }
  for (Eigen::Index i = 0; i < size; i += 3) {
    const Eigen::Vector3d arm = x.segment<3>(i) - centre;
    if (model.held()[i / 3] == 0) v.segment<3>(i) = wanted.velocity + wanted.spin.cross(arm);
    scale.reach = std::max(scale.reach, x.segment<3>(i).norm());
    scale.speed = std::max(scale.speed, v.segment<3>(i).norm());
  }
  if (Status s = check_scale(scale); !s) return s;
  return body.set_state(x, v);
}

}  // namespace

std::size_t TetsBodies::elements() const {
  std::size_t sum = 0;
  for (std::size_t i = 0; i < group->size(); ++i) sum += group->body(i).model().elements().size();
  return sum;
}

std::size_t TetsBodies::bytes() const {
  std::size_t sum = 0;
  for (const TetsKind& one : kinds)
    sum += one.model->bytes() + one.surface->bytes() + one.hull->bytes();
  return sum + group->bytes();
}

namespace {

// The friction of a pair is the geometric mean.
std::vector<TetObstacle> tets_obstacles(const TetBodiesScene& scene, const TetSceneBody& body) {
  std::vector<TetObstacle> obstacles;
  for (const SceneCollider& collider : scene.colliders)
    obstacles.push_back(
        {collider.shape, collider.pose, std::sqrt(collider.friction * body.friction)});
  return obstacles;
}

}  // namespace

Result<PlacedTets> place_tets(std::span<const TetSceneBody> bodies, const std::string& path) {
  PlacedTets made;
  for (const TetSceneBody& wanted : bodies) {
    const auto with_name = [&](const Error& error) { return error_of_tets(wanted, path, error); };
    auto found = std::find_if(made.kinds.begin(), made.kinds.end(),
                              [&](const TetsKind& kind) { return kind.path == wanted.model; });
    if (found == made.kinds.end()) {
      Result<TetsKind> kind = read_tets_kind(wanted);
      if (!kind) return with_name(kind.error());
      found = made.kinds.insert(made.kinds.end(), std::move(*kind));
    }
    if (wanted.settled && !(wanted.velocity.isZero(0.0) && wanted.spin.isZero(0.0)))
      return with_name(
          content_error("it has a velocity or a spin, but start = \"static\" means at rest: leave "
                        "one of both out"));
    Result<TetBody> body = TetBody::create(found->model, wanted.options);
    if (!body) return with_name(body.error());
    if (Status s = place_tets_body(wanted, *body); !s) return with_name(s.error());
    made.kind_of.push_back(static_cast<std::size_t>(found - made.kinds.begin()));
    made.bodies.push_back(std::move(*body));
  }
  return made;
}

Result<TetsBodies> make_tets_bodies(const TetBodiesScene& scene) {
  Result<PlacedTets> placed = place_tets(scene.bodies, scene.path);
  if (!placed) return placed.error();
  std::vector<TetContact> contacts;
  std::vector<double> frictions;
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const TetSceneBody& wanted = scene.bodies[i];
    if (wanted.settled) {
      TetBody& body = placed->bodies[i];
      if (Status s = body.settle(Eigen::VectorXd::Zero(body.positions().size())); !s)
        return error_of_tets(wanted, scene.path, s.error());
    }
    contacts.emplace_back(placed->kinds[placed->kind_of[i]].hull, tets_obstacles(scene, wanted));
    frictions.push_back(wanted.friction);
  }
  return TetsBodies{std::move(placed->kinds), std::move(placed->kind_of),
                    std::make_unique<TetGroup>(std::move(placed->bodies), std::move(contacts),
                                               std::move(frictions), scene.group)};
}

}  // namespace tremolo
