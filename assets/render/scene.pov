// One model on a floor. render.sh puts in front: #declare Surface (the mesh) and the model's view:
// Target (the point looked at, m), Extent (about the model's size, m), Direction (from the target to
// the camera), Angle (degrees), Colour, Floor (height of the floor, m).
#version 3.7;

global_settings { assumed_gamma 1.0 }

// z is up and the frame right-handed, like in the mesh.
camera {
  sky z
  up z
  right -x * image_width / image_height
  location Target + 4 * Extent * vnormalize(Direction)
  look_at Target
  angle Angle
}

background { rgb <0.92, 0.94, 0.97> }

light_source {
  Target + Extent * <4, -5, 7>
  rgb <1.0, 0.97, 0.92>
  area_light 1.2 * Extent * x, 1.2 * Extent * y, 4, 4
  adaptive 1
  jitter
}
light_source {
  Target + Extent * <-6, -4, 4>
  rgb <0.33, 0.36, 0.42>
  shadowless
}

plane {
  z, Floor
  pigment { rgb <0.83, 0.85, 0.88> }
  finish { ambient 0.25 diffuse 0.65 }
}

object {
  Surface
  pigment { srgb Colour }
  finish { ambient 0.2 diffuse 0.72 specular 0.18 roughness 0.04 }
}
