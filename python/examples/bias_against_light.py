# ---
# jupyter:
#   jupytext:
#     text_representation:
#       extension: .py
#       format_name: percent
# ---

# %% [markdown]
# # Bias against light
#
# More light makes the distance less noisy, and biases it: after each detection the
# detector is blind, so that it prefers the beginning of a flash (range walk). The phase
# estimator keeps that bias; the model estimator, which knows the dead time, does not.
#
# Needs `pip install './python[pandas]' matplotlib`, and runs in the repository's folder.

# %%
import matplotlib.pyplot as plt
import numpy as np

import goldtof

scene = goldtof.Scene.load("scenes/quick.toml")
POWERS_PW = [0.5, 1, 2, 5, 10, 20, 40]
powers = [f"{power} pW" for power in POWERS_PW]

# %% [markdown]
# What theory expects, exactly, costs a moment; simulated scans have to agree with it
# within their standard errors.

# %%
expected, simulated = {}, {}
for estimator in ("fft", "model"):
    over = {"source.mean_power": powers}
    expected[estimator] = goldtof.sweep(scene, over, estimator=estimator)
    simulated[estimator] = goldtof.sweep(
        scene, over, estimator=estimator, fidelity="counts", repetitions=100, seed=7
    )

# %% [markdown]
# Scans that miss the peak are left out of bias and deviation, and are told apart.

# %%
table = simulated["fft"][["source.mean_power", "detected_rate_cps", "missed_scans"]].copy()
for estimator, frame in simulated.items():
    table[f"{estimator}: bias (mm)"] = (1e3 * frame["bias_m"]).round(1)
    table[f"{estimator}: expected (mm)"] = (1e3 * frame["expected_bias_m"]).round(1)
    table[f"{estimator}: std (mm)"] = (1e3 * frame["std_m"]).round(1)
print(table.to_string(index=False))

# %%
figure, (of_bias, of_std) = plt.subplots(1, 2, figsize=(10, 4), layout="constrained")
LABELS = {"fft": "phase", "model": "model fit"}
for color, estimator in zip(("C0", "C1"), LABELS):
    rates_mcps = 1e-6 * expected[estimator]["detected_rate_cps"]
    theory, scans = expected[estimator], simulated[estimator]
    of_bias.plot(rates_mcps, 1e3 * theory["expected_bias_m"], color=color, label=LABELS[estimator])
    of_bias.errorbar(
        rates_mcps, 1e3 * scans["bias_m"], 2e3 * scans["bias_std_error_m"],
        fmt="o", color=color, capsize=3, markersize=4,
    )
    of_std.plot(rates_mcps, 1e3 * theory["expected_std_m"], color=color)
    of_std.plot(rates_mcps, 1e3 * scans["std_m"], "o", color=color, markersize=4)
model = expected["model"]
of_std.plot(
    1e-6 * model["detected_rate_cps"], 1e3 * model["bound_m"], "k:", label="Cramér-Rao bound"
)
for axes, title in ((of_bias, "bias (mm)"), (of_std, "standard deviation (mm)")):
    axes.set(xscale="log", xlabel="detections per second (millions)", title=title)
    axes.grid(alpha=0.3)
    axes.legend()
of_std.set_yscale("log")
ticks = [10, 20, 50, 100]
of_std.set_yticks(ticks, labels=[str(tick) for tick in ticks])
figure.suptitle("Lines: theory. Points: 100 simulated scans, with two standard errors")
plt.show()

# %% [markdown]
# The farthest that any simulated bias is from the expected one, in standard errors:

# %%
distances = [
    ((frame["bias_m"] - frame["expected_bias_m"]) / frame["bias_std_error_m"]).abs()
    for frame in simulated.values()
]
farthest = float(np.nanmax(np.concatenate(distances)))
print(f"{farthest:.1f}")
