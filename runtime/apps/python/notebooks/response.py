# %% [markdown]
# # A clamped beam: backbone and response curves
#
# A thin beam whose ends cannot approach becomes longer when it bends, and stiffer: its frequency grows with the
# amplitude. Woinowsky-Krieger gave the formula for one mode in 1950. The reduced model of the whole solid must agree.

# %%
import matplotlib.pyplot as plt
import numpy as np
from scipy.special import ellipk

import tremolo

length, width, height = 1.0, 0.02, 0.01
mesh = tremolo.box(size=(length, width, height), cells=(60, 1, 1))
ends = (mesh.vertices[:, 0] < 1e-6) | (mesh.vertices[:, 0] > length - 1e-6)
model = tremolo.precompute(*mesh, young=1e9, poisson=0.0, density=1000.0, fixed=ends, order=2, linear_modes=8, r=24)
middle = int(model.select(f"near:{length / 2},{width / 2},{height / 2}")[0])
print(f"{model.modes} coordinates, first frequency {model.frequencies[0]:.3f} Hz")

# %% [markdown]
# With the mode shape phi of a clamped beam, q'' + w^2 q + g q^3 = 0 where g = E A / 2 L (int phi'^2)^2. That is Duffing's
# equation; its period is an elliptic integral.

# %%
k = 4.730040744862704
s = (np.cosh(k) - np.cos(k)) / (np.sinh(k) - np.sin(k))
x, w = np.polynomial.legendre.leggauss(60)
x, w = (x + 1) / 2, w / 2


def phi(x):
    return np.cosh(k * x) - np.cos(k * x) - s * (np.sinh(k * x) - np.sin(k * x))


slope = k * (np.sinh(k * x) + np.sin(k * x) - s * (np.cosh(k * x) - np.cos(k * x)))
stretch, mass = w @ slope**2, w @ phi(x) ** 2


def formula(amplitude):
    """f / f_0 at the amplitude of the middle, m."""
    g = 6 * (amplitude / height * stretch / (phi(0.5) * k**2)) ** 2 / mass
    return np.pi * np.sqrt(1 + g) / (2 * ellipk(g / (2 * (1 + g))))


backbone = model.backbone(1, height, probe=middle)
free = backbone["frequency_hz"] / model.frequencies[0]
error = np.abs(free / formula(backbone["amplitude"]) - 1).max()
print(f"off the formula by at most {100 * error:.3f} %")
assert error < 2e-3  # the beam also changes its shape, which one mode leaves out

# %% [markdown]
# Now a force in the middle, with 1 % of critical damping, at four levels. Between two folds there are three motions at one
# frequency, of which the middle one does not last.

# %%
load = model.reduced_force(middle, (0.0, 0.0, 1.0))
span = 0.9 * model.frequencies[0], 1.35 * model.frequencies[0]
curves = {force: model.response(span, load=load, load_scale=force, damping_ratio="1%", probe=middle)
          for force in (0.005, 0.02, 0.04, 0.07)}

figure, axis = plt.subplots(figsize=(7, 4.5), constrained_layout=True)
for force, curve in curves.items():
    f, a = curve["frequency_hz"], curve["amplitude"] / height
    line, = axis.plot(f, np.where(curve["stable"], a, np.nan), label=f"{force:g} N")
    axis.plot(f, np.where(curve["stable"], np.nan, a), "--", color=line.get_color())
    for fold in (b for b in curve["bifurcations"] if b["kind"] == "fold"):
        axis.plot(fold["frequency_hz"], fold["amplitude"] / height, "o", color=line.get_color(), markersize=4)
axis.plot(backbone["frequency_hz"], backbone["amplitude"] / height, "k", linewidth=1, label="backbone")
grid = np.linspace(1e-9, height, 100)
axis.plot(formula(grid) * model.frequencies[0], grid / height, "k:", linewidth=2.5, alpha=0.5, label="formula")
axis.set_xlabel("frequency, Hz")
axis.set_ylabel("amplitude of the middle / height")
axis.set_xlim(*span)
axis.legend(fontsize=8)
figure.savefig("response.png", dpi=100)

# %%
folds = [len([b for b in curve["bifurcations"] if b["kind"] == "fold"]) for curve in curves.values()]
print("folds:", folds)
assert folds[0] == 0 and folds[-1] == 2
