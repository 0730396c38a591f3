#include <span>
#include <string>
#include <vector>

#include "runtime/world/identity.h"
#include "runtime/world/world_guests.h"

namespace tremolo {
namespace {

void add(Identity& identity, const ContactOptions& contact) {
  identity.add(contact.margin, contact.stiffness, contact.modulus.value_or(0.0), contact.friction,
               contact.restitution);
}

std::uint64_t hash_of(const TetsKind& kind) {
  Identity identity;
  const TetModel& model = *kind.model;
  identity.add(model.rest(), model.vertices());
  for (const double mass : model.masses()) identity.add(mass);
  for (const std::uint8_t held : model.held()) identity.add(held);
  for (const TetModelElement& element : model.elements()) {
    for (const std::uint32_t node : element.nodes) identity.add(node);
    const Elasticity& elasticity = model.elasticity(element);
    identity.add(elasticity.lambda, elasticity.mu, elasticity.tensor);
  }
  if (kind.hull->grid) identity.add(kind.hull->grid->content_hash());
  identity.add(kind.surface->rest().vertices);
  return identity.hash();
}

std::uint64_t hash_of(const TetSceneBody& body, std::uint64_t kind) {
  Identity identity;
  const TetBodyOptions& options = body.options;
  identity.add(kind, body.pose, body.velocity, body.spin, options.method, options.law);
  identity.add(options.tangent, options.gravity, options.alpha, options.beta, options.drag);
  identity.add(options.tolerance, options.linear_tolerance, options.max_iterations);
  identity.add(options.unsolved, options.guard, options.degree.kind, options.degree.error);
  identity.add(options.degree.upper, options.degree.lower, options.degree.least_steps);
  identity.add(options.degree.every);
  add(identity, body.contact);
  if (body.settled) identity.add(body.settled);
  return identity.hash();
}

void add(Identity& identity, const ClothSprings& springs) {
  identity.add(springs.law.stiffness, springs.law.damping, springs.rest);
  for (const auto& [a, b] : springs.pairs) identity.add(a, b);
}

void add(Identity& identity, const ClothParts& parts) {
  identity.add(parts.x, parts.mass, parts.drag);
  for (const Triangle& triangle : parts.triangles)
    for (const VertexId corner : triangle) identity.add(corner);
  for (const ClothSprings* springs : {&parts.structural, &parts.shear, &parts.bend})
    add(identity, *springs);
}

std::uint64_t hash_of(const ClothSceneBody& body, const ClothParts& parts) {
  Identity identity;
  add(identity, parts);
  const ClothScene& scene = body.scene;
  const NodalOptions& options = scene.options;
  identity.add(scene.integrator, options.tolerance, options.max_iterations, options.solver);
  identity.add(options.halvings, options.account, options.guard);
  identity.add(scene.gravity.times, scene.gravity.values, scene.wind, scene.gust, scene.gust_hz);
  const SceneCloth& cloth = body.cloth();
  identity.add(cloth.density, cloth.thickness, cloth.friction, cloth.restitution, cloth.crumple);
  identity.add(body.velocity, cloth.pins.size());
  for (const ClothPin& pin : cloth.pins) {
    identity.add(pin.particles.size(), pin.until);
    for (const std::size_t particle : pin.particles) identity.add(particle);
    add(identity, pin.motion);
  }
  add(identity, body.contact);
  if (cloth.settled) identity.add(cloth.settled);
  if (!body.spin.isZero(0.0)) identity.add(body.spin);
  return identity.hash();
}

std::uint64_t with_loads(std::uint64_t hash, std::span<const SceneLoad> loads) {
  for (const SceneLoad& load : loads) hash = with_load(hash, load);
  return hash;
}

}  // namespace

std::vector<SavedPart> guest_parts(std::span<const TetSceneBody> tets, const PlacedTets& placed,
                                   std::span<const ClothSceneBody> cloths,
                                   const MixedGuests& guests) {
  std::vector<SavedPart> parts;
  std::vector<std::uint64_t> kinds;
  for (const TetsKind& kind : placed.kinds) kinds.push_back(hash_of(kind));
  for (std::size_t i = 0; i < tets.size(); ++i)
    parts.push_back({"body '" + tets[i].name + "'",
                     with_loads(hash_of(tets[i], kinds[placed.kind_of[i]]), tets[i].loads)});
  for (std::size_t i = 0; i < cloths.size(); ++i)
    parts.push_back(cloth_part(cloths[i], *guests.cloth(tets.size() + i)));
  return parts;
}

SavedPart cloth_part(const ClothSceneBody& cloth, const ClothStep& step) {
  return {"body '" + cloth.name() + "'",
          with_loads(hash_of(cloth, step.body().model().parts()), cloth.loads)};
}

}  // namespace tremolo
