#include "runtime/model.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "common/hash.h"
#include "common/mesh/surface_mesh.h"
#include "common/packed_index.h"
#include "common/text.h"
#include "formats/basis/basis_layout.h"
#include "formats/basis/basis_reader.h"
#include "runtime/bodies/reduced/frames/frame_inertia.h"
#include "runtime/bodies/reduced/surface/interior_rows.h"
#include "runtime/bodies/reduced/surface/surface.h"
#include "runtime/math/kernels/strain_matrix.h"

namespace tremolo {
namespace {

Result<Eigen::Index> kept_modes(Eigen::Index available, int asked) {
  if (asked < 0 || asked > available)
    return usage_error("asked for " + std::to_string(asked) + " modes; the model has " +
                       std::to_string(available));
  return asked == 0 ? available : Eigen::Index{asked};
}

Status check_lambda(const Eigen::VectorXd& lambda) {
  for (Eigen::Index i = 0; i < lambda.size(); ++i)
    if (!(lambda[i] > 0.0) || !std::isfinite(lambda[i]) || (i > 0 && lambda[i] < lambda[i - 1]))
      return content_error("lambda " + std::to_string(i) + " is " + number_text(lambda[i]) +
                           ", must be positive, finite and not below the one before it");
  return Success{};
}

Status check_triangles(const std::vector<Triangle>& triangles, std::size_t vertices) {
  for (std::size_t t = 0; t < triangles.size(); ++t)
    for (const VertexId corner : triangles[t])
      if (corner < 0 || static_cast<std::size_t>(corner) >= vertices)
        return content_error("triangle " + std::to_string(t) + " names vertex " +
                             std::to_string(corner) + " of " + std::to_string(vertices));
  return Success{};
}

Status check_load(const DefaultLoad& load) {
  if (load.vertices.size() != load.forces.size())
    return content_error("the default load has " + std::to_string(load.vertices.size()) +
                         " vertices and " + std::to_string(load.forces.size()) + " forces");
  for (const Eigen::Vector3d& force : load.forces)
    if (!force.allFinite()) return content_error("a force of the default load is not finite");
  return Success{};
}

Status read_total_counts(BasisReader& reader, BasisData& data) {
  data.vertex_count = reader.dimensions().vertices;
  data.tetrahedron_count = reader.dimensions().tetrahedra;
  data.rigid_mode_count = reader.dimensions().rigid;
  Result<Eigen::VectorXd> lambda = read_lambda(reader);
  if (!lambda) return lambda.error();
  data.lambda = std::move(*lambda);
  return Success{};
}

Status read_coefficients(BasisReader& reader, BasisData& data) {
  Result<std::vector<double>> cubic = reader.coefficients(basis_layout::kCubic);
  if (!cubic) return cubic.error();
  data.cubic = std::move(*cubic);
  Result<std::vector<double>> quartic = reader.coefficients(basis_layout::kQuartic);
  if (!quartic) return quartic.error();
  data.quartic = std::move(*quartic);
  return Success{};
}

// The leading columns of a render surface, after a check.
Result<RenderBlock> leading_columns(const RenderBlock& render, Eigen::Index modes,
                                    Eigen::Index available, std::uint64_t vertices) {
  if (!fits(render, available, vertices))
    return content_error("the render surface: its parts differ in size or an index names nothing");
  RenderBlock leading{render.surface, render.rows.leftCols(modes), render.anchors, {}};
  if (render.column_scales.size() >= modes)
    leading.column_scales = render.column_scales.head(modes);
  const auto finite = [](const auto& vectors) {
    return std::all_of(vectors.begin(), vectors.end(),
                       [](const auto& vector) { return vector.allFinite(); });
  };
  const RenderSurface& surface = render.surface;
  if (!leading.rows.allFinite() || !finite(surface.vertices) || !finite(surface.normals) ||
      !finite(surface.uvs))
    return content_error("the render surface: a value is not finite");
  return leading;
}

Status check_inertia(const InertiaIntegrals& inertia, Eigen::Index modes) {
  const Eigen::Index pairs = pair_count(static_cast<std::size_t>(modes));
  if (inertia.linear.rows() != 12 || inertia.linear.cols() != modes || inertia.B.rows() != 9 ||
      inertia.B.cols() != pairs)
    return content_error("the inertia integrals do not fit the basis");
  const bool finite = inertia.first_moment.allFinite() && inertia.second_moment.allFinite() &&
                      inertia.linear.allFinite() && inertia.B.allFinite();
  if (!finite || !(inertia.mass > 0) || !std::isfinite(inertia.mass))
    return content_error("the inertia integrals: a value is not finite or the mass not positive");
  return Success{};
}

// A solid without coordinates moves by its frame alone, which needs integrals and no support.
bool is_rigid(const BasisData& data) {
  return data.lambda.size() == 0 && data.inertia && data.rigid_mode_count == 6;
}

// Integrals of the leading coordinates.
InertiaIntegrals leading_inertia(const InertiaIntegrals& inertia, Eigen::Index modes) {
  InertiaIntegrals leading = inertia;
  leading.linear = inertia.linear.leftCols(modes);
  const Eigen::Index pairs = pair_count(static_cast<std::size_t>(modes));
  leading.B = inertia.B.leftCols(pairs);
  return leading;
}

// Checks the rows of the vertices on the surface and of the drawn surface.
Status check_response(const BasisData& data) {
  const LocalResponse& response = data.response;
  const Eigen::Index columns = 3 * std::ssize(response.at);
  const auto wrong = [columns](const BasisRows& rows, std::size_t vertices) {
    return rows.rows() != 3 * static_cast<Eigen::Index>(vertices) || rows.cols() != columns ||
           !rows.allFinite();
  };
  if (columns == 0) return Success{};
  if (wrong(response.surface, data.surface.vertex_ids.size()) ||
      (data.render && wrong(response.render, data.render->surface.vertices.size())))
    return content_error("the response at places does not fit the surface or is not finite");
  return Success{};
}

std::ptrdiff_t strain_numbers(Eigen::Index modes) {
  return static_cast<std::ptrdiff_t>(pair_count(strain_terms(static_cast<std::size_t>(modes))));
}

Status check_strain_gram(const BasisData& data) {
  const std::vector<double>& gram = data.strain_gram;
  if (std::ssize(gram) != strain_numbers(data.lambda.size()))
    return content_error("the Gram matrix of the strains does not fit the coordinates");
  for (std::size_t a = 0; pair_index(a, a) < gram.size(); ++a)
    if (!(gram[pair_index(a, a)] >= 0.0))
      return content_error("the Gram matrix of the strains has a negative entry on its diagonal");
  if (!std::all_of(gram.begin(), gram.end(), [](double value) { return std::isfinite(value); }))
    return content_error("the Gram matrix of the strains is not finite");
  return Success{};
}

// All except the interior and the provenance.
Result<BasisData> read_visible(BasisReader& reader, const ModelOptions& options) {
  BasisData data;
  if (Status s = read_total_counts(reader, data); !s) return s.error();
  if (!options.linear)
    if (Status s = read_coefficients(reader, data); !s) return s.error();
  Result<VertexBlock> surface = reader.vertex_block(
      basis_layout::kSurfaceIds, basis_layout::kSurfaceRest, basis_layout::kSurfaceBasis);
  if (!surface) return surface.error();
  data.surface = std::move(*surface);
  Result<std::vector<Triangle>> triangles = read_triangles(reader);
  if (!triangles) return triangles.error();
  data.triangles = std::move(*triangles);
  if (!options.hull) {
    Result<std::optional<RenderBlock>> render = read_render(reader);
    if (!render) return render.error();
    data.render = std::move(*render);
  }
  Result<std::optional<InertiaIntegrals>> inertia = read_inertia(reader);
  if (!inertia) return inertia.error();
  data.inertia = std::move(*inertia);
  if (Status s = take(data.elements, read_elements(reader)); !s) return s.error();
  if (!data.elements.corners.empty())
    if (Status s = take(data.edges, read_edges(reader)); !s) return s.error();
  if (Status s = take(data.response, read_response(reader)); !s) return s.error();
  Result<DefaultLoad> load = read_default_load(reader);
  if (!load) return load.error();
  data.load = std::move(*load);
  return data;
}

}  // namespace

Model::Model(Potential potential, VertexBlock surface)
    : potential_(std::move(potential)), surface_(std::move(surface)) {}

Model::~Model() = default;

Result<std::shared_ptr<Model>> Model::assemble(const BasisData& data, Eigen::Index modes,
                                               const ModelOptions& options) {
  if (Status s = check_lambda(data.lambda); !s) return s.error();
  Result<VertexBlock> surface = leading_columns(data.surface, modes, "surface");
  if (!surface) return surface.error();
  if (Status s = check_triangles(data.triangles, surface->vertex_ids.size()); !s) return s.error();
  if (Status s = check_load(data.load); !s) return s.error();
  const std::span<const double> cubic = data.cubic, quartic = data.quartic, none;
  Result<Potential> potential =
      is_rigid(data) ? Potential()
                     : Potential::create(data.lambda.head(modes), options.linear ? none : cubic,
                                         options.linear ? none : quartic);
  if (!potential) return potential.error();
  std::shared_ptr<Model> model(new Model(std::move(*potential), std::move(*surface)));
  if (data.render && !options.hull) {
    Result<RenderBlock> render =
        leading_columns(*data.render, modes, data.lambda.size(), data.vertex_count);
    if (!render) return render.error();
    model->render_ = std::move(*render);
  }
  if (data.inertia) {
    if (Status s = check_inertia(*data.inertia, data.lambda.size()); !s) return s.error();
    model->inertia_ = leading_inertia(*data.inertia, modes);
  }
  if (Status s = check_response(data); !s) return s.error();
  model->response_ = data.response;
  model->response_.interior.resize(0, 0);
  if (!model->render_) model->response_.render.resize(0, 0);
  if (data.elements.corners.size() != data.elements.masses.size())
    return content_error("the tetrahedra and their masses differ in number");
  model->elements_ = data.elements;
  if (!data.elements.corners.empty()) model->edges_ = data.edges;
  model->rigid_mode_count_ = data.rigid_mode_count;
  model->triangles_ = data.triangles;
  model->default_load_ = data.load;
  model->vertex_count_ = data.vertex_count;
  model->tetrahedron_count_ = data.tetrahedron_count;
  return model;
}

Result<Model::Pointer> Model::from_data(const BasisData& data, ModelOptions options,
                                        std::optional<Collider> solid) {
  const Result<Eigen::Index> modes = kept_modes(data.lambda.size(), options.modes);
  if (!modes) return modes.error();
  Result<std::shared_ptr<Model>> model = assemble(data, *modes, options);
  if (!model) return model.error();
  (*model)->solid_ = std::move(solid);
  Result<VertexBlock> interior = leading_columns(data.interior, *modes, "interior");
  if (!interior) return interior.error();
  const BasisRows& inside = data.response.interior;
  if (!data.response.at.empty() && inside.rows() != interior->rows.rows())
    return content_error("the response at places does not fit the vertices inside");
  (*model)->interior_ = std::make_unique<InteriorRows>(std::move(*interior), inside);
  if (data.strain_gram.empty() || (*model)->potential().linear()) return Pointer(std::move(*model));
  if (Status s = check_strain_gram(data); !s) return s.error();
  (*model)->strain_gram_.assign(data.strain_gram.begin(),
                                data.strain_gram.begin() + strain_numbers(*modes));
  return Pointer(std::move(*model));
}

Result<Model::Pointer> Model::load(const std::string& path, ModelOptions options) {
  Result<BasisReader> reader = BasisReader::open(path);
  if (!reader) return reader.error();
  Result<BasisData> data = read_visible(*reader, options);
  if (!data) return error_of_file(path, data.error());
  const Result<Eigen::Index> modes = kept_modes(data->lambda.size(), options.modes);
  if (!modes) return modes.error();
  Result<std::shared_ptr<Model>> model = assemble(*data, *modes, options);
  if (!model) return error_of_file(path, model.error());
  const auto file = std::shared_ptr<OpenBasis>(new OpenBasis{{}, std::move(*reader)});
  if (file->reader.has(basis_layout::kStrainGram) && !options.linear && !file->reader.linear())
    (*model)->strain_file_ = file;
  (*model)->interior_ = std::make_unique<InteriorRows>(file, *modes);
  return Pointer(std::move(*model));
}

Result<Model::Pointer> Model::load_from_memory(std::span<const std::byte> bytes,
                                               ModelOptions options) {
  Result<BasisReader> reader = BasisReader::from_memory(bytes);
  if (!reader) return reader.error();
  const Result<BasisData> data = read_basis(*reader);
  if (!data) return data.error();
  return from_data(*data, options);
}

bool Model::has_strain_gram() const {
  const std::scoped_lock lock(strains_mutex_);
  return strains_ || strain_file_ || !strain_gram_.empty();
}

Result<std::shared_ptr<const StrainMatrix>> Model::strain_matrix() const {
  const std::scoped_lock lock(strains_mutex_);
  if (strains_ || (!strain_file_ && strain_gram_.empty())) return strains_;
  if (strain_file_) {
    const std::scoped_lock reading(strain_file_->mutex);
    if (Status s = take(strain_gram_, strain_file_->reader.strain_gram()); !s) return s.error();
  }
  strains_ = std::make_shared<const StrainMatrix>(static_cast<std::size_t>(modes()), strain_gram_);
  strain_file_.reset();
  strain_gram_ = {};
  return strains_;
}

std::shared_ptr<const StrainMatrix> Model::known_strain_matrix() const {
  const std::scoped_lock lock(strains_mutex_);
  return strains_;
}

Eigen::VectorXd Model::frequencies_hz() const {
  return lambda().cwiseSqrt() / (2.0 * std::numbers::pi);
}

double Model::explicit_step_limit() const {
  if (modes() == 0) return std::numeric_limits<double>::infinity();
  return 2.0 / std::sqrt(lambda()[modes() - 1]);
}

const SurfaceBasis& Model::surface_basis() const {
  std::call_once(surface_basis_once_, [this] {
    surface_basis_ = std::make_unique<SurfaceBasis>(
        render_ ? make_surface_basis(*render_, response_.render)
                : make_surface_basis(surface_, triangles_, response_.surface));
  });
  return *surface_basis_;
}

DrawnSurface Model::surface_of(SurfaceKind surface) const {
  if (surface == SurfaceKind::kDrawn) return drawn();
  return {surface_.rest, surface_.rows, response_.surface, triangles_, surface_.vertex_ids};
}

Result<VertexRows> Model::place(const SurfacePlace& place) const {
  const DrawnSurface surface = surface_of(place.surface);
  if (place.triangle >= surface.triangles.size())
    return usage_error("there is no triangle " + std::to_string(place.triangle) + " among the " +
                       std::to_string(surface.triangles.size()) + " of the surface");
  if (!place.weights.allFinite() || place.weights.minCoeff() < -1e-9 ||
      std::abs(place.weights.sum() - 1.0) > 1e-6)
    return usage_error("the weights of a triangle's corners are not negative and sum to one");
  VertexRows rows{Eigen::Vector3d::Zero(), decltype(VertexRows::rows)::Zero(3, modes())};
  for (std::size_t k = 0; k < 3; ++k) {
    const Eigen::Index corner = surface.triangles[place.triangle][k];
    const double weight = place.weights[k];
    rows.rest += weight * surface.rest[corner];
    rows.rows += weight * surface.rows.middleRows<3>(3 * corner);
  }
  return rows;
}

VertexId Model::vertex_near(const SurfacePlace& place) const {
  const DrawnSurface surface = surface_of(place.surface);
  Eigen::Index corner = 0;
  place.weights.maxCoeff(&corner);
  return surface.mesh_vertices[surface.triangles[place.triangle][corner]];
}

const SurfaceTree& Model::surface_tree(SurfaceKind surface) const {
  // Without a render surface both kinds are the same surface.
  const bool drawn = surface == SurfaceKind::kDrawn || !render_;
  std::unique_ptr<SurfaceTree>& tree = drawn ? drawn_tree_ : boundary_tree_;
  std::call_once(drawn ? drawn_tree_once_ : boundary_tree_once_, [&] {
    const DrawnSurface of = surface_of(surface);
    tree = std::make_unique<SurfaceTree>(of.rest, of.rows, of.triangles);
  });
  return *tree;
}

std::uint64_t Model::content_hash() const {
  std::call_once(hash_once_, [this] {
    Hasher hasher;
    const auto add = [&hasher](const auto& list) {
      const std::uint64_t count = static_cast<std::uint64_t>(list.size());
      hasher.add(std::as_bytes(std::span(&count, 1)));
      hasher.add(std::as_bytes(std::span(list.data(), static_cast<std::size_t>(list.size()))));
    };
    add(lambda());
    add(cubic());
    add(quartic());
    add(surface_.vertex_ids);
    add(surface_.rest);
    add(surface_.rows);
    add(triangles_);
    add(default_load_.vertices);
    add(default_load_.forces);
    if (inertia_) {
      hasher.add(std::as_bytes(std::span(&inertia_->mass, 1)));
      add(inertia_->first_moment);
      add(inertia_->second_moment);
      add(inertia_->linear);
      add(inertia_->B);
    }
    content_hash_ = hasher.hash();
  });
  return content_hash_;
}

std::shared_ptr<const FrameInertia> Model::inertia_about_origin() const {
  std::call_once(origin_once_, [this] {
    about_origin_ = std::make_shared<const FrameInertia>(*inertia_, Eigen::Vector3d::Zero());
  });
  return about_origin_;
}

std::shared_ptr<const FrameInertia> Model::inertia_about_centre() const {
  std::call_once(centre_once_, [this] {
    const Eigen::Vector3d centre = inertia_->first_moment / inertia_->mass;
    about_centre_ = std::make_shared<const FrameInertia>(*inertia_, centre);
  });
  return about_centre_;
}

Result<const VertexBlock*> Model::interior() const {
  return interior_->block();
}

Result<VertexRows> Model::vertex(VertexId id) const {
  const VertexBlock* block = &surface_;
  std::optional<std::size_t> at = find_vertex(surface_.vertex_ids, id);
  if (!at) {
    const Result<const VertexBlock*> interior = interior_->block();
    if (!interior) return interior.error();
    block = *interior;
    at = find_vertex(block->vertex_ids, id);
  }
  if (!at)
    return usage_error("the model has no vertex " + std::to_string(id) + "; it has " +
                       std::to_string(vertex_count_) + ", counted from 0");
  return VertexRows{block->rest[*at], block->rows.middleRows(3 * *at, 3)};
}

std::optional<Eigen::Index> Model::response_place(VertexId id) const {
  const auto found = std::lower_bound(response_.at.begin(), response_.at.end(), id);
  if (found == response_.at.end() || *found != id) return std::nullopt;
  return found - response_.at.begin();
}

Result<VertexRows> Model::response(VertexId id) const {
  const auto rows_at = [](const std::vector<Eigen::Vector3d>& rest, const BasisRows& rows,
                          std::size_t at) {
    return VertexRows{rest[at], rows.middleRows(3 * static_cast<Eigen::Index>(at), 3)};
  };
  if (const auto at = find_vertex(surface_.vertex_ids, id))
    return rows_at(surface_.rest, response_.surface, *at);
  const Result<const VertexBlock*> inside = interior_->block();
  if (!inside) return inside.error();
  const Result<const BasisRows*> rows = interior_->response();
  if (!rows) return rows.error();
  const auto at = find_vertex((*inside)->vertex_ids, id);
  if (!at) return vertex(id).error();
  return rows_at((*inside)->rest, **rows, *at);
}

}  // namespace tremolo
