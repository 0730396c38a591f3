# %% [markdown]
# # From arrays of numpy to a vibrating body
#
# A bar of soft rubber is a mesh of numpy arrays. It is precomputed in a second, clamped at one end, pulled down at the
# other and released.

# %%
import matplotlib.pyplot as plt
import numpy as np

import tremolo

mesh = tremolo.box(size=(0.4, 0.06, 0.04), cells=(16, 3, 2))
print(f"{len(mesh.vertices)} vertices, {len(mesh.cells)} tetrahedra")

# %%
model = tremolo.precompute(
    mesh.vertices, mesh.cells, young=5e5, poisson=0.45, density=1100.0,
    fixed=mesh.vertices[:, 0] < 1e-6,  # a mask: the face at x = 0
    load_at="x>0.3999", load_force=(0.0, 0.0, -1.0), order=2, r=12, linear_modes=5)
print("frequencies, Hz:", np.round(model.frequencies, 2))

# %% [markdown]
# A mode is a column of `U`. Here are the rest shape and the first three modes, seen from the side.

# %%
figure, axes = plt.subplots(3, 1, figsize=(7, 5), sharex=True, constrained_layout=True)
for i, axis in enumerate(axes):
    u = model.U[:, i].reshape(-1, 3)
    u = 0.05 * u / np.abs(u).max()
    for places, colour in ((model.vertices, "0.8"), (model.vertices + u, "C0")):
        axis.triplot(places[:, 0], places[:, 2] if i != 1 else places[:, 1], model.triangles, color=colour, linewidth=0.4)
    axis.set_title(f"mode {i + 1}, {model.frequencies[i]:.2f} Hz" + (", from above" if i == 1 else ""), fontsize=9)
    axis.set_aspect("equal")
    axis.set_ylabel("m")
axes[-1].set_xlabel("x, m")
figure.savefig("vibrating_body_modes.png", dpi=100)

# %% [markdown]
# The body starts in its equilibrium under the load, which a strong damping finds, and is then released.

# %%
body = model.body(step=2e-3, damping_ratio="1:0.9,20:0.9")
body.add_load()
body.step(5000)
body.clear_loads()
body.set_damping(0.0, 0.0)
body.p = np.zeros(model.modes)

tip = int(model.select("near:0.4,0.03,0.02")[0])
time, height, energy = [], [], []
start = body.time
for _ in range(1000):
    time.append(body.time - start)
    height.append(body.displacement(tip)[2])
    energy.append(body.energy["total"])
    body.step()

# %%
figure, (above, below) = plt.subplots(2, 1, figsize=(7, 5), sharex=True, constrained_layout=True)
above.plot(time, np.array(height) * 1000)
above.set_ylabel("tip, mm")
below.plot(time, np.array(energy) / energy[0] - 1.0)
below.set_ylabel("change of energy / energy")
below.set_xlabel("t, s")
figure.savefig("vibrating_body_motion.png", dpi=100)
drift = np.abs(np.array(energy) / energy[0] - 1.0).max()
print(f"the energy changes by {drift:.1e} of itself in 1000 steps")
assert drift < 1e-10
