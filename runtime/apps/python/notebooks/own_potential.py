# %% [markdown]
# # Your own potential
#
# `tremolo.own_body` moves coordinates in any potential that is written in Python. Here it is the chain of Fermi, Pasta,
# Ulam and Tsingou: 32 masses between walls with springs whose force is d + 0.25 d^2. It starts in its lowest mode. Energy
# moves to a few higher modes, and returns.

# %%
import matplotlib.pyplot as plt
import numpy as np

import tremolo

count, alpha = 32, 0.25
sines = np.sin(np.pi * np.outer(np.arange(1, count + 1), np.arange(1, count + 1)) / (count + 1))
sines *= np.sqrt(2.0 / (count + 1))
omega = 2.0 * np.sin(np.pi * np.arange(1, count + 1) / (2 * (count + 1)))


def stretch(q):
    return np.diff(np.concatenate([[0.0], q, [0.0]]))


def energy(q):
    d = stretch(q)
    return float(np.sum(d**2 / 2 + alpha * d**3 / 3))


def gradient(q):
    force = stretch(q) + alpha * stretch(q) ** 2
    return force[:-1] - force[1:]


def tangent(q):
    k = 1.0 + 2.0 * alpha * stretch(q)
    return np.diag(k[:-1] + k[1:]) - np.diag(k[1:-1], 1) - np.diag(k[1:-1], -1)


# %%
body = tremolo.own_body(energy, gradient, tangent, q=sines[0] * 4.0, integrator="energy", step=0.8)
start = body.energy["total"]
time, shares = [], []
for _ in range(280):
    a, b = sines @ body.q, sines @ body.v
    time.append(body.time * omega[0] / (2 * np.pi))
    shares.append(0.5 * b**2 + 0.5 * (omega * a) ** 2)
    body.step(50)
shares = np.array(shares)
drift = abs(body.energy["total"] / start - 1.0)
print(f"{body.steps} steps, the energy is off by {drift:.1e}")
assert drift < 1e-6

# %%
figure, axis = plt.subplots(figsize=(8, 4), constrained_layout=True)
for mode in range(4):
    axis.plot(time, shares[:, mode], label=f"mode {mode + 1}")
axis.set_xlabel("periods of the first mode")
axis.set_ylabel("energy")
axis.legend()
figure.savefig("own_potential.png", dpi=100)

# %%
lost, back = shares[:, 0].min() / shares[0, 0], shares[len(time) // 2:, 0].max() / shares[0, 0]
print(f"the first mode falls to {lost:.2f} of its energy and returns to {back:.2f}")
assert lost < 0.2 and back > 0.8
