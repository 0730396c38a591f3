#include "runtime/apps/view/draw/gl_objects.h"

namespace tremolo {

const char* const kSurfaceVertexShader = R"(#version 330 core
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec3 rest;
layout(location = 3) in vec4 paint;
layout(location = 4) in vec2 uv;
uniform mat4 pose, clip;
uniform vec3 eye;
uniform float yields;  // m: by which it counts as farther away than it is
out vec3 world, world_normal, paint_of;
out vec2 uv_of;
out float moved;
void main() {
  vec4 place = pose * vec4(position, 1.0);
  world = place.xyz;
  world_normal = mat3(pose) * normal;
  paint_of = paint.rgb;
  uv_of = uv;
  moved = distance(position, rest);
  gl_Position = clip * place;
  if (yields > 0.0) {
    vec4 farther = clip * vec4(place.xyz + yields * normalize(place.xyz - eye), 1.0);
    gl_Position.z = farther.z / farther.w * gl_Position.w;
  }
}
)";

// Each light is a direction with a depth map along it. A few close directions form the lamp, whose
// shadows are therefore soft; all others form the sky, whose sum darkens points that see little of
// it.
const char* const kSurfaceFragmentShader = R"(#version 330 core
const int kMost = 96;
layout(std140) uniform Lights {
  vec4 to_map[3 * kMost];  // rows of the map's coordinates of a place in the world
  vec4 light[kMost];       // direction to the light, and how bright it is
};
uniform sampler2DArrayShadow lamp_maps, sky_maps;
uniform sampler2D image;
uniform int lamps, lights, paint_kind;
uniform vec3 colour, eye, up, centre, lamp_colour, sky_colour;
uniform vec4 line;           // of wires: alpha above zero takes the place of all light
uniform vec2 ground_fade;    // m: where the ground begins to end, and where it has; x < 0: no ground
uniform vec3 horizon, zenith;
uniform float height, moved_scale, lamp_shift, sky_shift, gloss, glass, lifted;
in vec3 world, world_normal, paint_of;
in vec2 uv_of;
in float moved;
out vec4 result;

// From blue, where nothing moves, by green to red.
vec3 moved_colour(float share) {
  const vec3 stops[6] = vec3[6](vec3(0.06, 0.08, 0.36), vec3(0.05, 0.35, 0.65),
                                vec3(0.07, 0.58, 0.45), vec3(0.75, 0.75, 0.10),
                                vec3(0.90, 0.36, 0.04), vec3(0.62, 0.02, 0.02));
  float at = clamp(share, 0.0, 1.0) * 5.0;
  int low = min(int(at), 4);
  return mix(stops[low], stops[low + 1], at - float(low));
}

// Values above 0.8 are compressed so that they stay below 1.
float bend(float x) { return x < 0.8 ? x : 1.0 - 0.2 * exp(-(x - 0.8) / 0.2); }

float seen(int i, vec3 place) {
  if (glass < 1.0) return 1.0;
  vec4 at = vec4(place, 1.0);
  vec3 map = vec3(dot(to_map[3 * i], at), dot(to_map[3 * i + 1], at), dot(to_map[3 * i + 2], at));
  return i < lamps ? texture(lamp_maps, vec4(map.xy, float(i), map.z))
                   : texture(sky_maps, vec4(map.xy, float(i - lamps), map.z));
}

// Light of the lamp that mirrors, for a rough surface.
float mirrored(vec3 n, vec3 to_eye, vec3 to_light) {
  vec3 half_way = normalize(to_eye + to_light);
  float rough = 0.10, facing = max(dot(n, half_way), 0.0);
  float spread = facing * facing * (rough - 1.0) + 1.0;
  float fresnel = 0.04 + 0.96 * pow(1.0 - max(dot(to_eye, half_way), 0.0), 5.0);
  return 0.6 * fresnel * rough / (3.14159 * spread * spread);
}

void main() {
  if (line.a > 0.0) {
    result = line;
    return;
  }
  vec3 n = normalize(world_normal), to_eye = normalize(eye - world);
  if (dot(n, n) < 0.5) n = to_eye;
  if (!gl_FrontFacing) n = -n;
  vec3 base = colour;
  if (paint_kind == 1) base = paint_of;
  if (paint_kind == 2) base = texture(image, uv_of).rgb;
  if (paint_kind == 3) base = moved_colour(moved * moved_scale);
  if (paint_kind == 4) base = moved_colour(paint_of.r * moved_scale);
  vec3 lamp_place = world + (lamp_shift + lifted) * n;
  vec3 sky_place = world + (sky_shift + lifted) * n;
  float lamp = 0.0, sky = 0.0, shine = 0.0;
  for (int i = 0; i < lights; ++i) {
    float facing = dot(n, light[i].xyz);
    if (facing <= 0.0) continue;
    float reaches = light[i].w * facing * seen(i, i < lamps ? lamp_place : sky_place);
    if (i < lamps) {
      lamp += reaches;
      shine += reaches * mirrored(n, to_eye, light[i].xyz);
    } else
      sky += reaches;
  }
  // Light reflected by the ground.
  float below = 0.5 - 0.5 * dot(n, up);
  vec3 all = lamp_colour * lamp + sky_colour * (sky + 0.05) + vec3(0.17, 0.165, 0.16) * below;
  vec3 seen_colour = base * all + gloss * shine * lamp_colour;
  seen_colour = vec3(bend(seen_colour.r), bend(seen_colour.g), bend(seen_colour.b));
  if (ground_fade.x >= 0.0) {
    vec3 out_there = world - centre;
    float far = length(out_there - up * dot(out_there, up));
    vec3 behind = mix(horizon, zenith, gl_FragCoord.y / height);
    seen_colour = mix(seen_colour, behind, smoothstep(ground_fade.x, ground_fade.y, far));
  }
  result = vec4(seen_colour, glass);
}
)";

const char* const kDepthVertexShader = R"(#version 330 core
layout(location = 0) in vec3 position;
uniform mat4 pose, clip;
void main() { gl_Position = clip * (pose * vec4(position, 1.0)); }
)";

const char* const kDepthFragmentShader = R"(#version 330 core
void main() {}
)";

const char* const kWholeVertexShader = R"(#version 330 core
void main() {
  vec2 corner = vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0);
  gl_Position = vec4(corner, 0.0, 1.0);
}
)";

const char* const kBackgroundFragmentShader = R"(#version 330 core
uniform vec3 horizon, zenith;
uniform float height;
out vec4 result;
void main() { result = vec4(mix(horizon, zenith, gl_FragCoord.y / height), 1.0); }
)";

// Noise of half a step of 8 bits hides
// where one begins.
const char* const kDevelopFragmentShader = R"(#version 330 core
uniform sampler2D picture;
uniform int flat_background;
uniform vec2 size;
out vec4 result;
float encode(float x) {
  return x <= 0.0031308 ? 12.92 * x : 1.055 * pow(x, 1.0 / 2.4) - 0.055;
}
void main() {
  vec3 light = texture(picture, gl_FragCoord.xy / size).rgb;
  vec3 shown = vec3(encode(light.r), encode(light.g), encode(light.b));
  float noise = fract(52.9829189 * fract(dot(gl_FragCoord.xy, vec2(0.06711056, 0.00583715))));
  if (flat_background == 0) shown += (noise - 0.5) / 255.0;
  result = vec4(shown, 1.0);
}
)";

}  // namespace tremolo
