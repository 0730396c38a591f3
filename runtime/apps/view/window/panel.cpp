#include "runtime/apps/view/window/panel.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <imgui.h>
#include <numbers>
#include <utility>

#include "runtime/integrator.h"
#include "runtime/response/orbit.h"

namespace tremolo {
namespace {

constexpr double kFullShare = 1.0 / 6.0;

double seconds_now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

// Of the orbit that is shown, rad.
double orbit_angle(const OrbitShow& orbit) {
  return 2.0 * std::numbers::pi * (seconds_now() - orbit.began) / kOrbitSeconds;
}

void build_time(PanelState& state, Runner& runner, const RunnerReport& report) {
  ImGui::Text("t = %.3f s   step %lld", report.time, static_cast<long long>(report.steps));
  if (ImGui::Button(report.paused ? "Go on" : "Pause")) {
    state.swing.reset();
    state.orbit.plays = false;
    runner.set_paused(!report.paused);
  }
  ImGui::SameLine();
  if (ImGui::Button("One step")) {
    state.swing.reset();
    state.orbit.plays = false;
    runner.step_once();
  }
  ImGui::SameLine();
  if (ImGui::Button("Reset")) state.wants_reset = true;
  ImGui::SameLine();
  if (ImGui::Button("Frame")) state.wants_frame = true;
  if (ImGui::SliderFloat("speed", &state.rate, 0.001f, 4.0f, "%.3f x",
                         ImGuiSliderFlags_Logarithmic))
    runner.set_rate(state.rate);
  ImGui::Text("pace %.3f of %.3f, a step %.3f ms", report.pace, report.wanted, report.step_ms);
  ImGui::Text("lag: %.2f s given up", report.lost);
  ImGui::Text("contacts: %lld so far, %d points push", static_cast<long long>(report.contacts),
              report.active_contacts);
  if (!report.trouble.empty()) {
    ImGui::PushStyleColor(ImGuiCol_Text, ImVec4(1.0f, 0.6f, 0.4f, 1.0f));
    ImGui::TextWrapped("%s", report.trouble.c_str());
    ImGui::PopStyleColor();
  }
}

void tell_if_refused(Runner& runner, const Status& status) {
  if (!status) runner.complain(status.error().message);
}

void build_damping(PanelState& state, Runner& runner) {
  const std::size_t body = state.body;
  bool damps = ImGui::SliderFloat("alpha, 1/s", &state.alpha, 0.0f, 20.0f);
  damps = ImGui::SliderFloat("beta, 10^x s", &state.log_beta, -7.0f, -1.0f, "%.2f") || damps;
  if (damps) {
    const double alpha = state.alpha;
    const double beta = state.log_beta <= -7.0f ? 0.0 : std::pow(10.0, state.log_beta);
    runner.post([&runner, body, alpha, beta](LiveWorld& live) {
      tell_if_refused(runner, live.world().body(body).set_damping(alpha, beta));
    });
  }
}

void build_step(PanelState& state, Runner& runner) {
  if (!ImGui::InputFloat("step, ms", &state.step_ms, 0.5f, 2.0f, "%.2f",
                         ImGuiInputTextFlags_EnterReturnsTrue))
    return;
  state.step_ms = std::clamp(state.step_ms, 0.01f, 100.0f);
  const double step = 1e-3 * static_cast<double>(state.step_ms);
  runner.post(
      [&runner, step](LiveWorld& live) { tell_if_refused(runner, live.world().set_step(step)); });
}

void build_method(PanelState& state, Runner& runner, const std::vector<ModeFacts>& modes) {
  if (!ImGui::CollapsingHeader("Method", ImGuiTreeNodeFlags_DefaultOpen)) return;
  for (const std::string& guest : state.guests) ImGui::TextWrapped("%s", guest.c_str());
  if (modes.empty()) return;
  if (state.records_hand) {
    ImGui::TextWrapped("cannot be changed while a hand is recorded");
    return;
  }
  if (modes.size() > 1 && ImGui::BeginCombo("body", modes[state.body].name.c_str())) {
    for (std::size_t i = 0; i < modes.size(); ++i)
      if (ImGui::Selectable(modes[i].name.c_str(), i == state.body)) state.body = i;
    ImGui::EndCombo();
  }
  const std::size_t body = state.body;
  if (ImGui::BeginCombo("method", runner.method_of(body).c_str())) {
    for (const std::string_view name : integrator_names())
      if (ImGui::Selectable(std::string(name).c_str()))
        runner.post([&runner, body, name](LiveWorld& live) {
          tell_if_refused(runner, live.world().set_method(body, name));
        });
    ImGui::EndCombo();
  }
  if (state.guests.empty()) build_step(state, runner);
  if (state.damping_is_ours) build_damping(state, runner);
  if (!state.gravity_is_ours) return;
  if (ImGui::SliderFloat3("gravity, m/s2", state.gravity.data(), -20.0f, 20.0f, "%.2f")) {
    const Eigen::Vector3d g(state.gravity[0], state.gravity[1], state.gravity[2]);
    runner.post([&runner, g](LiveWorld& live) {
      for (std::size_t i = 0; i < live.world().size(); ++i)
        tell_if_refused(runner, live.world().body(i).set_gravity(g));
    });
  }
}

void build_colour(PanelState& state, const PictureCosts& costs) {
  const auto choice = [&state](const char* name, ColourBy colour) {
    if (ImGui::RadioButton(name, state.colour == colour)) state.colour = colour;
    ImGui::SameLine();
  };
  choice("own colours", ColourBy::kBody);
  choice("displacement", ColourBy::kMoved);
  if (state.knows_stress) choice("stress", ColourBy::kStress);
  if (state.knows_degrees) choice("degree", ColourBy::kDegree);
  ImGui::NewLine();
  const auto full = static_cast<double>(costs.full);
  if (state.colour == ColourBy::kMoved) ImGui::Text("red: %.4g m from rest", full);
  if (state.colour == ColourBy::kStress) ImGui::Text("red: %.4g Pa (von Mises)", full);
}

void build_look(PanelState& state, const PictureCosts& costs) {
  if (!ImGui::CollapsingHeader("Look and hand", ImGuiTreeNodeFlags_DefaultOpen)) return;
  ImGui::Checkbox("wires", &state.wire);
  ImGui::SameLine();
  ImGui::Checkbox("colliders", &state.colliders);
  build_colour(state, costs);
  ImGui::SliderInt("lights", &state.lights, 2, 48);
  ImGui::SliderInt("coarser", &state.coarser, 1, 4);
  ImGui::SliderFloat("hand", &state.firmness, 0.05f, 20.0f, "%.2f x as firm",
                     ImGuiSliderFlags_Logarithmic);
  ImGui::Text("%.1f pictures/s", costs.pictures_per_s);
  ImGui::Text("posed %.2f ms, panel %.2f, drawn %.1f", costs.prepare_ms, costs.panel_ms,
              costs.draw_ms);
  ImGui::TextDisabled("%s", state.shown_by.c_str());
}

void plot(const char* label, const std::vector<float>& values) {
  if (values.empty()) return;
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  char text[64];
  std::snprintf(text, sizeof(text), "%.4g J (%.3g to %.3g)", static_cast<double>(values.back()),
                static_cast<double>(*low), static_cast<double>(*high));
  ImGui::TextUnformatted(label);
  ImGui::PushID(label);
  ImGui::PlotLines("##plot", values.data(), static_cast<int>(values.size()), 0, text,
                   std::min(0.0f, *low), *high, ImVec2(ImGui::GetContentRegionAvail().x, 52.0f));
  ImGui::PopID();
}

void build_energy(const RunnerReport& report) {
  if (!ImGui::CollapsingHeader("Energy", ImGuiTreeNodeFlags_DefaultOpen)) return;
  std::vector<float> total, low, high;
  for (const EnergySample& sample : report.energies) {
    const double sum = sample.kinetic + sample.potential;
    total.push_back(static_cast<float>(sum));
    low.push_back(static_cast<float>(sum - sample.high));
    high.push_back(static_cast<float>(sample.high));
  }
  plot("kinetic + potential", total);
  plot("of it outside of the high band", low);
  plot("high band", high);
}

void build_swing(PanelState& state, Runner& runner, std::size_t k) {
  const bool swings =
      state.swing && state.swing->body == state.body && state.swing->mode == static_cast<int>(k);
  if (!ImGui::SmallButton(swings ? "stop" : "swing")) return;
  state.swing.reset();
  if (swings) return;
  runner.set_paused(true);
  state.orbit.plays = false;
  state.swing = Swing{state.body, static_cast<int>(k), 0.7, seconds_now()};
}

void build_modes(PanelState& state, Runner& runner, const std::vector<ModeFacts>& modes,
                 const WorldMoment& moment) {
  if (modes.empty() || !ImGui::CollapsingHeader("Modes")) return;
  const std::size_t body = state.body;
  const ModeFacts& facts = modes[body];
  for (std::size_t k = 0; k < facts.full.size(); ++k) {
    ImGui::PushID(static_cast<int>(k));
    auto share = static_cast<float>(moment.bodies[body].q[k] / facts.full[k]);
    char label[48];
    std::snprintf(label, sizeof(label), "%d: %.1f Hz", static_cast<int>(k), facts.hz[k]);
    ImGui::SetNextItemWidth(150.0f);
    if (ImGui::SliderFloat(label, &share, -1.0f, 1.0f, "%.2f")) {
      const double value = static_cast<double>(share) * facts.full[k];
      state.swing.reset();
      state.orbit.plays = false;
      runner.post([&runner, body, k, value](LiveWorld& live) {
        Body& moved = live.world().body(body);
        Eigen::VectorXd q = moved.state().q;
        q[k] = value;
        tell_if_refused(runner, moved.set_state(q, Eigen::VectorXd::Zero(q.size())));
      });
    }
    ImGui::SameLine();
    build_swing(state, runner, k);
    ImGui::PopID();
  }
}

// The orbit's amplitude, its frequency, and the buttons that play it or let the body go on from it.
void build_orbit_slider(PanelState& state, Runner& runner) {
  OrbitShow& orbit = state.orbit;
  const auto most = static_cast<float>(100.0 * orbit.orbits->largest());
  const bool moved =
      ImGui::SliderFloat("amplitude, % of size", &orbit.percent, 0.01f * most, most, "%.2f");
  const CurvePoint point = orbit.orbits->at(0.01 * static_cast<double>(orbit.percent));
  const double hz = point.omega / (2.0 * std::numbers::pi);
  ImGui::Text("%.5g Hz, %+.2f %% of %.5g Hz", hz, 100.0 * (hz / orbit.orbits->linear_hz - 1.0),
              orbit.orbits->linear_hz);
  ImGui::Text("amplitude %.4g m", point.amplitude);
  const bool pressed = ImGui::Button(orbit.plays ? "stop it" : "play it");
  if (pressed || (moved && !orbit.plays)) {
    orbit.plays = !orbit.plays || moved;
    orbit.began = seconds_now();
    state.swing.reset();
    if (orbit.plays) runner.set_paused(true);
  }
  ImGui::SameLine();
  if (!ImGui::Button("go on from it")) return;
  orbit.plays = false;
  const double theta = orbit_angle(orbit);
  runner.post([&runner, body = orbit.body, start = orbit_state(point, theta)](LiveWorld& live) {
    tell_if_refused(runner, live.world().body(body).set_state(start.q, start.p));
  });
  runner.set_paused(false);
}

void build_orbits(PanelState& state, Runner& runner, OrbitFinder& finder,
                  const std::vector<ModeFacts>& modes) {
  OrbitShow& orbit = state.orbit;
  if (orbit.opens) ImGui::SetNextItemOpen(true, ImGuiCond_Once);
  if (modes.empty() || !ImGui::CollapsingHeader("Orbits of a mode")) return;
  const int count = static_cast<int>(modes[state.body].hz.size());
  if (ImGui::InputInt("of mode", &orbit.mode)) orbit.mode = std::clamp(orbit.mode, 1, count);
  if (finder.searches()) {
    ImGui::TextDisabled("the orbits are being found");
  } else if (ImGui::Button("find")) {
    orbit.orbits.reset();
    orbit.plays = false;
    orbit.trouble.clear();
    orbit.body = state.body;
    finder.find(*modes[state.body].model, orbit.mode - 1);
  }
  if (!orbit.trouble.empty()) ImGui::TextWrapped("%s", orbit.trouble.c_str());
  if (orbit.orbits) build_orbit_slider(state, runner);
}

void build_record(PanelState& state) {
  if (!ImGui::CollapsingHeader("Record")) return;
  ImGui::InputText("to", state.record_to.data(), state.record_to.size());
  ImGui::TextDisabled("*.mp4, *.webm, or a folder of PNGs");
  if (ImGui::Button(state.recording ? "Stop recording" : "Record")) state.wants_record = true;
  if (!state.record_trouble.empty()) ImGui::TextWrapped("%s", state.record_trouble.c_str());
  if (state.records_hand) ImGui::TextWrapped("the hand is recorded, and written at the end");
}

}  // namespace

std::vector<ModeFacts> mode_facts(const SceneWorld& world) {
  std::vector<ModeFacts> all;
  for (std::size_t i = 0; i < world.size(); ++i) {
    const Model& model = world.body(i).model();
    const VertexBlock& surface = model.surface();
    Eigen::Vector3d low = surface.rest.front(), high = low;
    for (const Eigen::Vector3d& x : surface.rest) {
      low = low.cwiseMin(x);
      high = high.cwiseMax(x);
    }
    ModeFacts facts{world.name(i), {}, {}, &model};
    const Eigen::VectorXd hz = model.frequencies_hz();
    for (Eigen::Index k = 0; k < model.modes(); ++k) {
      double most = 0.0;
      for (Eigen::Index v = 0; v + 2 < surface.rows.rows(); v += 3)
        most = std::max(most, surface.rows.block<3, 1>(v, k).norm());
      facts.full.push_back(kFullShare * (high - low).maxCoeff() / std::max(most, 1e-30));
      facts.hz.push_back(hz[k]);
    }
    all.push_back(std::move(facts));
  }
  return all;
}

PanelState first_panel(const LiveWorld& live, double rate) {
  PanelState state;
  state.rate = static_cast<float>(rate);
  state.step_ms = static_cast<float>(1e3 * live.world().step_size());
  if (live.world().size() > 0) {
    const Body& body = live.world().body(0);
    state.alpha = static_cast<float>(body.options().alpha);
    state.log_beta = body.options().beta > 0.0
                         ? static_cast<float>(std::max(-7.0, std::log10(body.options().beta)))
                         : -7.0f;
  }
  for (std::size_t i = 0; i < live.guests().size(); ++i)
    state.guests.push_back(live.guests().name(i) + ": " + live.guests().method(i));
  const SceneGravity& gravity = live.viewed().scene.gravity;
  state.gravity_is_ours = gravity.values.size() < 2 && state.guests.empty();
  for (const SceneBody& wanted : live.viewed().scene.bodies)
    state.damping_is_ours = state.damping_is_ours && wanted.alphas.empty() && wanted.betas.empty();
  const Eigen::Vector3d g = gravity.at(0.0);
  for (std::size_t k = 0; k < 3; ++k) state.gravity[k] = static_cast<float>(g[k]);
  std::snprintf(state.record_to.data(), state.record_to.size(), "tremolo-view.mp4");
  return state;
}

void receive_orbits(OrbitFinder& finder, OrbitShow& orbit) {
  std::optional<Result<ModeOrbits>> found = finder.take_found();
  if (!found) return;
  if (*found) {
    orbit.orbits = std::move(**found);
    const double most = orbit.orbits->largest();
    orbit.percent = std::min(orbit.percent, static_cast<float>(100.0 * most));
    orbit.began = seconds_now();
  } else {
    orbit.trouble = found->error().message;
    orbit.plays = false;
  }
}

std::optional<Eigen::VectorXd> shown_orbit(const OrbitShow& orbit) {
  if (!orbit.plays || !orbit.orbits) return std::nullopt;
  const CurvePoint point = orbit.orbits->at(0.01 * static_cast<double>(orbit.percent));
  return orbit_state(point, orbit_angle(orbit)).q;
}

void build_panel(PanelState& state, Runner& runner, OrbitFinder& finder,
                 const std::vector<ModeFacts>& modes, const WorldMoment& moment,
                 const PictureCosts& costs) {
  if (!state.panel) return;
  const float height = ImGui::GetIO().DisplaySize.y;
  ImGui::SetNextWindowPos(ImVec2(8.0f, 8.0f), ImGuiCond_Once);
  ImGui::SetNextWindowSize(ImVec2(kPanelWidth, std::max(60.0f, height - 16.0f)), ImGuiCond_Once);
  ImGui::SetNextWindowBgAlpha(0.82f);
  if (ImGui::Begin("tremolo view")) {
    ImGui::PushItemWidth(170.0f);
    const RunnerReport report = runner.report();
    build_time(state, runner, report);
    build_method(state, runner, modes);
    build_orbits(state, runner, finder, modes);
    build_look(state, costs);
    build_energy(report);
    build_modes(state, runner, modes, moment);
    build_record(state);
    ImGui::TextDisabled("space . R F W H: as the buttons, H hides");
    ImGui::PopItemWidth();
  }
  ImGui::End();
}

}  // namespace tremolo
