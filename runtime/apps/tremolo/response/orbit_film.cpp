#include "runtime/apps/tremolo/response/orbit_film.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include <fmt/format.h>

#include "runtime/io/exchange/recording.h"
#include "runtime/io/page/document.h"

namespace tremolo {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kOrbits = 120;  // of all curves, besides bifurcations
constexpr int kFrames = 32;           // of a period
constexpr double kPeriod = 1.5;       // that a period lasts in the film, s
constexpr double kMostNumbers = 6e6;  // of a shape's fields: some 16 MB of page

class Film {
 public:
  explicit Film(const CurveContext& context) : context_(context) {
    animation_.shapes.push_back(animated_shape(*context.made.model, "body"));
    animation_.bodies.emplace_back().name = "body";
  }

  bool fits() const {
    const auto& modes = animation_.shapes.front().modes;
    return static_cast<double>(modes.rows()) * static_cast<double>(modes.cols()) <= kMostNumbers;
  }
  bool empty() const { return loops_.empty(); }

  // The number of the new loop.
  int add(const std::string& label, const CurvePoint& point) {
    const double from = animation_.times.empty() ? 0.0 : animation_.times.back() + 0.01;
    AnimatedBody& body = animation_.bodies.front();
    for (int n = 0; n <= kFrames; ++n) {
      const double part = static_cast<double>(n) / kFrames;
      const Eigen::VectorXd q =
          point.motion * fourier_row(point.harmonics(), 2.0 * std::numbers::pi * part);
      animation_.times.push_back(from + part * kPeriod);
      body.q.insert(body.q.end(), q.begin(), q.end());
      body.poses.emplace_back();
    }
    loops_.push_back({{"from", from},
                      {"to", animation_.times.back()},
                      {"label", fmt::format("{}: {:.6g} Hz, {:.4g} m ({:.3g} % of the size)", label,
                                            point.omega / (2.0 * std::numbers::pi), point.amplitude,
                                            100.0 * point.amplitude / context_.made.size)}});
    return static_cast<int>(loops_.size()) - 1;
  }

  Result<Json> json() const {
    const Result<PageMotion> motion = page_motion(animation_);
    if (!motion) return motion.error();
    Json json = Json::parse(motion->json);
    json["loops"] = loops_;
    return json;
  }

 private:
  const CurveContext& context_;
  Animation animation_;
  Json loops_ = Json::array();
};

}  // namespace

Result<OrbitFilm> orbit_film(const std::vector<CurveResult>& results, const CurveContext& context) {
  OrbitFilm made;
  Film film(context);
  if (!film.fits()) return made;
  const CurvePoint* largest = nullptr;
  const std::string* label = nullptr;
  for (const CurveResult& result : results)
    for (const CurvePoint& point : result.curve.points)
      if (largest == nullptr || point.amplitude > largest->amplitude)
        largest = &point, label = &result.label;
  if (largest == nullptr) return made;
  film.add(*label, *largest);
  const std::size_t each = std::max<std::size_t>(8, kOrbits / results.size());
  for (const CurveResult& result : results) {
    const std::size_t count = result.curve.points.size();
    const std::size_t stride = 1 + count / each;
    std::vector<int>& loops = made.loop_of_point.emplace_back(count);
    for (std::size_t i = 0; i < count; ++i)
      loops[i] = i % stride == 0 ? film.add(result.label, result.curve.points[i]) : loops[i - 1];
    std::vector<int>& marks = made.loop_of_bifurcation.emplace_back();
    for (const Bifurcation& found : result.curve.bifurcations)
      marks.push_back(film.add(name_of(found.kind), found.point));
  }
  if (Status s = take(made.film, film.json()); !s) return s.error();
  return made;
}

}  // namespace tremolo
