# %% [markdown]
# # A gripper controlled from Python
#
# Two soft fingers close around a soft ball and lift it. Each finger is a body whose frame Python moves; in every step the
# controller reads the force of contact on the ball and stops closing at a set value.

# %%
import os
import tempfile

import matplotlib.pyplot as plt
import numpy as np

import tremolo

files = tempfile.TemporaryDirectory(prefix="tremolo-gripper-")  # removed when Python ends
folder = files.name


def made(name, mesh, **options):
    path = os.path.join(folder, name)
    tremolo.precompute(*mesh, poisson=0.4, order=1, output=path, **options)
    return path


# A ball of 3 cm radius, 60 g: a cube whose vertices are moved to spheres.
cube = tremolo.box((2.0, 2.0, 2.0), (6, 6, 6))
x = cube.vertices - 1.0
largest = np.abs(x).max(axis=1, keepdims=True)
x = 0.03 * x * largest / np.maximum(np.linalg.norm(x, axis=1, keepdims=True), 1e-12)
ball = made("ball.tremolo", tremolo.Mesh(x, cube.cells), young=2e5, density=500.0, r=12, linear_modes=6)

# A finger of 10 cm x 2 cm x 4 cm, held at its upper end by what moves it.
finger_mesh = tremolo.box((0.02, 0.04, 0.10), (2, 4, 8))
finger = made("finger.tremolo", finger_mesh, young=2e7, density=1000.0, fixed="z>0.0999", r=10, linear_modes=5)

# %%
step, gap = 0.002, 0.02
scene = {
    "step": step,
    "gravity": [0, 0, -9.81],
    "bodies": [
        {"name": "ball", "model": ball, "kind": "free", "beta": 2e-3, "position": [0, 0, 0.0302], "friction": 0.8,
         "restitution": 0.1, "shape": "sphere", "radius": 0.03},
        {"name": "left", "model": finger, "kind": "driven", "beta": 2e-3, "friction": 0.8, "restitution": 0.1,
         "position": [-0.03 - gap - 0.02, -0.02, 0.004]},
        {"name": "right", "model": finger, "kind": "driven", "beta": 2e-3, "friction": 0.8, "restitution": 0.1,
         "position": [0.03 + gap, -0.02, 0.004]},
    ],
    "colliders": [{"name": "floor", "shape": "plane", "friction": 0.5, "restitution": 0.1}],
}
world = tremolo.world(scene)
bodies = {name: world[name] for name in world.names}


def push_on_ball(finger_name):
    """The force of a finger on the ball along x, N."""
    points = world.contact_points(finger_name, "ball")
    return sum(point["impulse"][0] for point in points) / step


# %% [markdown]
# The controller: close until both fingers push with 3 N, then lift by 8 cm in half a second. The force of a single step
# may alternate from step to step, so the controller takes the mean of the last ten.

# %%
target = 3.0  # N
start = {name: bodies[name].pose[0].copy() for name in ("left", "right")}
closed, lifted, pushes, log = 0.0, 0.0, [0.0] * 10, []
for k in range(900):
    left, right = push_on_ball("left"), push_on_ball("right")
    pushes = [*pushes[1:], 0.5 * (abs(left) + abs(right))]
    push = np.mean(pushes)
    # A controller of the rate: 4 cm/s far from the target, slower near it.
    closed += step * 0.04 * np.clip((target - push) / target, -1.0, 1.0)
    if k * step > 1.0:
        s = min((k * step - 1.0) / 0.5, 1.0)
        lifted = 0.08 * s * s * (3.0 - 2.0 * s)
    for name, side in (("left", 1.0), ("right", -1.0)):
        bodies[name].move_to(start[name] + [side * closed, 0.0, lifted])
    world.step()
    centre = bodies["ball"].boundary_positions().mean(axis=0)
    log.append((k * step, push, lifted, centre[2], closed))
log = np.array(log)

# %%
figure, (above, below) = plt.subplots(2, 1, figsize=(7, 5), sharex=True, constrained_layout=True)
above.plot(log[:, 0], log[:, 1])
above.axhline(target, color="k", linestyle=":")
above.set_ylabel("push of a finger, N")
below.plot(log[:, 0], (log[:, 3] - log[0, 3]) * 1000, label="ball")
below.plot(log[:, 0], log[:, 2] * 1000, "--", label="gripper")
below.set_ylabel("height, mm")
below.set_xlabel("t, s")
below.legend()
figure.savefig("gripper_control.png", dpi=100)

# %%
figure, axis = plt.subplots(figsize=(5, 5), constrained_layout=True)
for name, colour in (("ball", "C1"), ("left", "C0"), ("right", "C0")):
    places = bodies[name].positions()
    axis.triplot(places[:, 0] * 1000, places[:, 2] * 1000, bodies[name].model.drawn_triangles, color=colour, linewidth=0.5)
axis.axhline(0.0, color="k")
axis.set_aspect("equal")
axis.set_xlabel("x, mm")
axis.set_ylabel("z, mm")
figure.savefig("gripper_end.png", dpi=100)
rise = log[-1, 3] - log[0, 3]
print(f"the ball rose by {rise * 1000:.1f} mm, held with {log[-1, 1]:.2f} N")
assert rise > 0.06 and abs(log[-1, 1] - target) < 0.3
