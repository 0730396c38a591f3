// The text of the shaders, GLSL 3.30.
#pragma once

namespace tremolo {

// Lights of one picture at most; the shaders' array is as long.
inline constexpr int kMostLights = 96;

// A surface under all lights. What its inputs mean is said at runtime/viewer/draw/renderer.cpp.
extern const char* const kSurfaceVertexShader;
extern const char* const kSurfaceFragmentShader;
// The same surface seen from a light: depth only.
extern const char* const kDepthVertexShader;
extern const char* const kDepthFragmentShader;
// A triangle over the whole picture: the background; and the picture's light as sRGB.
extern const char* const kWholeVertexShader;
extern const char* const kBackgroundFragmentShader;
extern const char* const kDevelopFragmentShader;

}  // namespace tremolo
