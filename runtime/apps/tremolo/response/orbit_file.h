// The motion of one point of a curve as a file for other programs: a period as an animation or as
// surfaces.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

#include "common/result.h"
#include "runtime/apps/tremolo/response/curve_report.h"
#include "runtime/apps/tremolo/response/response_commands.h"

namespace tremolo {

// The point of a curve that --orbit-at names.
struct OrbitChoice {
  enum class Kind { kPeak, kLast, kFrequency, kAmplitude };
  Kind kind = Kind::kPeak;
  double value = 0.0;    // Hz; of an amplitude m, or a fraction of the size
  bool of_size = false;  // value is a fraction of the size
};

// "peak", "last", "1.2Hz", "8%", "0.02m". Errors: kUsage; kContent for a number that is not
// positive and finite.
Result<OrbitChoice> parse_orbit_choice(std::string_view text);

// The point of the first main curve. At a frequency it is the nearest point of the part with the
// largest amplitude; at an amplitude the motion where the curve first reaches it. Error: kContent
// if the curve does not reach it.
Result<CurvePoint> chosen_orbit(const OrbitChoice& choice, const MotionCurve& curve, double size);

// kUsage for a file whose ending is none of the formats, an --orbit-at without a file, kContent for
// numbers out of range.
Status check_orbit_flags(const PeriodicOptions& options);

// Writes the files of --orbit from the first of the results. The JSON is about the chosen point and
// lists the files; null without --orbit. Errors: chosen_orbit's, the writers'.
Result<nlohmann::ordered_json> write_orbit(const PeriodicOptions& options,
                                           const std::vector<CurveResult>& results,
                                           const CurveContext& context);

}  // namespace tremolo
