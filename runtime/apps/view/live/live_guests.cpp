#include "runtime/apps/view/live/live_guests.h"

#include <algorithm>

#include "runtime/apps/view/shape/sheet_geometry.h"

namespace tremolo {

using Eigen::Vector3d;

float quadratic_share(const TetModel& model, const TetModelElement& element,
                      std::span<const std::uint8_t> degrees) {
  int quadratic = 0;
  for (std::size_t k = 4; k < kMostNodes; ++k)
    if (degrees[element.nodes[k] - model.vertices()] == 2) ++quadratic;
  return static_cast<float>(quadratic) / 6.0F;
}

LiveGuests::LiveGuests(WorldGuests guests) : guests_(std::move(guests)) {
  for (std::size_t i = 0; i < size(); ++i)
    looks_.push_back(is_cloth(i) ? look_of(cloth(i).model().parts()) : ClothLook{});
}

std::string LiveGuests::method(std::size_t i) const {
  return is_cloth(i) ? cloth(i).integrator()
                     : std::string(tet_method_name(tets(i).options().method));
}

bool LiveGuests::is_held(std::size_t i) const {
  const std::span<const std::uint8_t> held =
      is_cloth(i) ? cloth(i).model().held() : tets(i).model().held();
  return std::any_of(held.begin(), held.end(), [](std::uint8_t flag) { return flag != 0; });
}

std::span<const Triangle> LiveGuests::triangles(std::size_t i) const {
  if (is_cloth(i)) return looks_[i].triangles;
  return guests_.kind(i).surface->rest().triangles;
}

std::vector<Vector3d> LiveGuests::rest(std::size_t i) const {
  if (!is_cloth(i)) return guests_.kind(i).surface->rest().vertices;
  const Eigen::VectorXd& x = cloth(i).model().parts().x;
  std::vector<Vector3d> rest;
  for (const std::uint32_t particle : looks_[i].particles)
    rest.emplace_back(x.segment<3>(3 * static_cast<Eigen::Index>(particle)));
  return rest;
}

std::vector<std::optional<Material>> materials_of(const TetsKind& kind) {
  const TetsSurface& drawn = kind.surface->rest();
  const std::span<const TetModelElement> elements = kind.model->elements();
  std::vector<std::optional<Material>> materials(drawn.triangles.size());
  for (std::size_t t = 0; t < materials.size(); ++t) {
    const auto corner = static_cast<std::size_t>(drawn.triangles[t][0]);
    const Elasticity& elasticity = kind.model->elasticity(elements[drawn.tetrahedra[corner]]);
    if (!elasticity.isotropic) continue;
    const double lambda = elasticity.lambda, mu = elasticity.mu;
    materials[t].emplace();
    materials[t]->young = mu * (3.0 * lambda + 2.0 * mu) / (lambda + mu);
    materials[t]->poisson = 0.5 * lambda / (lambda + mu);
  }
  return materials;
}

std::span<const Eigen::Vector2f> LiveGuests::uvs(std::size_t i) const {
  if (is_cloth(i)) return looks_[i].uvs;
  return guests_.kind(i).surface->rest().uvs;
}

std::vector<std::optional<Material>> LiveGuests::materials(std::size_t i) const {
  if (is_cloth(i)) return {};
  return materials_of(guests_.kind(i));
}

void LiveGuests::look(std::size_t i, BodyMoment& moment) const {
  if (is_cloth(i)) {
    const Eigen::VectorXd& x = cloth(i).state().x;
    particles_.assign(x.begin(), x.end());
    mean_normals(cloth(i).model().parts().triangles, particles_, particle_normals_);
    spread_to_look<float>(looks_[i], particles_, 3, moment.positions);
    spread_to_look<float>(looks_[i], particle_normals_, 3, moment.normals);
    return;
  }
  const TetSurface& surface = *guests_.kind(i).surface;
  const TetBody& body = tets(i);
  places_.resize(surface.vertices());
  normals_.resize(surface.vertices());
  surface.place(body.positions(), places_, normals_);
  moment.positions.resize(3 * places_.size());
  moment.normals.resize(3 * places_.size());
  moment.degrees.resize(places_.size());
  for (std::size_t v = 0; v < places_.size(); ++v) {
    Eigen::Map<Eigen::Vector3f>(moment.positions.data() + 3 * v) = places_[v].cast<float>();
    Eigen::Map<Eigen::Vector3f>(moment.normals.data() + 3 * v) = normals_[v];
    const std::uint32_t element = surface.rest().tetrahedra[v];
    moment.degrees[v] =
        quadratic_share(body.model(), body.model().elements()[element], body.system().degrees());
  }
}

std::optional<LiveGuests::Hit> LiveGuests::pick(const CameraRay& ray) const {
  RayHit hit;
  std::optional<Hit> found;
  BodyMoment moment;
  for (std::size_t i = 0; i < size(); ++i) {
    look(i, moment);
    const auto at = [&moment](VertexId v) {
      return Vector3d(Eigen::Map<const Eigen::Vector3f>(moment.positions.data() +
                                                        3 * static_cast<std::size_t>(v))
                          .cast<double>());
    };
    if (find_nearer(ray, triangles(i), at, hit)) found = Hit{i, hit.corner, hit.distance};
  }
  return found;
}

Result<HandSpring> LiveGuests::suitable_springs(const Hit& hit) const {
  if (is_cloth(hit.guest)) return swinging_spring(cloth(hit.guest).mass());
  TetBody& body = tets(hit.guest);
  TetHand hand = hand_at(body.model(), guests_.kind(hit.guest).surface->rest(), hit.vertex);
  if (Status s = suit_springs(body, hand); !s) return s.error();
  return HandSpring{hand.stiffness, hand.damping};
}

Vector3d LiveGuests::vertex_at(std::size_t i, std::size_t vertex) const {
  BodyMoment moment;
  look(i, moment);
  return Eigen::Map<const Eigen::Vector3f>(moment.positions.data() + 3 * vertex).cast<double>();
}

double LiveGuests::hand_work() const {
  double sum = 0.0;
  for (std::size_t i = 0; i < size(); ++i) sum += guests_.guests->sums(i).hand;
  return sum;
}

double LiveGuests::kinetic_energy() const {
  double sum = 0.0;
  for (std::size_t i = 0; i < size(); ++i)
    sum += is_cloth(i) ? cloth(i).kinetic_energy() : tets(i).kinetic_energy();
  return sum;
}

double LiveGuests::elastic_energy() const {
  double sum = 0.0;
  for (std::size_t i = 0; i < size(); ++i)
    sum += is_cloth(i) ? cloth(i).elastic_energy() : tets(i).elastic_energy();
  return sum;
}

std::int64_t LiveGuests::contacts() const {
  std::int64_t sum = 0;
  for (std::size_t i = 0; i < size(); ++i) sum += guests_.guests->contacts(i);
  return sum;
}

int LiveGuests::active_contacts() const {
  int sum = 0;
  for (std::size_t i = 0; i < size(); ++i) sum += guests_.guests->account(i).active;
  return sum;
}

}  // namespace tremolo
