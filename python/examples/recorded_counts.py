# ---
# jupyter:
#   jupytext:
#     text_representation:
#       extension: .py
#       format_name: percent
# ---

# %% [markdown]
# # From recorded counts to a distance
#
# What a sensor sends are counts, one signed and perhaps one total for each phase step.
# Here simulated photons stand in for a sensor; with a real one, `recorded.csv` is its
# file.
#
# Needs `pip install './python[pandas]' matplotlib`, and runs in the repository's folder.

# %%
import matplotlib.pyplot as plt
from typing import Literal

import numpy as np
import pandas

import goldtof

scene = goldtof.Scene.load("scenes/quick.toml")
built = scene.copy()
built["path.distance"] = "4.321 m"
scan = goldtof.scans(built, fidelity="sampled", seed=11)
recorded = pandas.DataFrame(
    {"phase_step": np.arange(scene.phase_steps), "count": scan["signed"][0],
     "total_count": scan["total"][0]}
)
recorded.to_csv("recorded.csv", index=False)

# %%
recorded = pandas.read_csv("recorded.csv")
signed, total = recorded["count"], recorded["total_count"]

# %% [markdown]
# Both estimators, each with what theory expects of it. The scene believes the target at
# 3.2 m; what light is there decides.

# %%
estimates = {}
ESTIMATORS: tuple[Literal["fft", "model"], ...] = ("fft", "model")
for estimator in ESTIMATORS:
    told = goldtof.estimate(scene, recorded, estimator=estimator)
    estimates[estimator] = told["estimate"]["distance_m"]
    print(f"{estimator:5}: {estimates[estimator]:.4f} m,", end=" ")
    print(f"off by {1e3 * (estimates[estimator] - 4.321):+.1f} mm")
print(goldtof.estimate(scene, recorded, estimator="model")["diagnosis"]["sentence"])

# %% [markdown]
# A scene at the distance that came out has to explain the counts; one with a wrong dead
# time does not, and it is named.

# %%
scene["path.distance"] = estimates["model"]
right = goldtof.estimate(scene, recorded, estimator="model")
wrong_scene = scene.copy()
wrong_scene["detector.dead_time"] = "20 ns"
wrong = goldtof.estimate(wrong_scene, recorded, estimator="model")
for told in (right, wrong):
    print(f"chi-square {told['chi_square']:.0f} of {told['degrees_of_freedom']}:", end=" ")
    print(told["diagnosis"]["sentence"])

# %%
expected = goldtof.expected(scene)
steps = recorded["phase_step"]
std = np.sqrt(expected["signed_variance"])
figure, (of_counts, of_residuals) = plt.subplots(
    2, 1, figsize=(9, 6), sharex=True, height_ratios=(2, 1), layout="constrained"
)
of_counts.fill_between(
    steps, expected["signed_mean"] - 2 * std, expected["signed_mean"] + 2 * std,
    color="C1", alpha=0.4, label="expected, with two standard deviations",
)
of_counts.plot(steps, signed, ".", markersize=4, label="recorded")
of_counts.set(ylabel="signed count", title=f"Distance by the model fit: {estimates['model']:.3f} m")
of_counts.legend()
for against, label in ((scene, "right scene"), (wrong_scene, "dead time of 20 ns")):
    theory = goldtof.expected(against)
    residuals = (total - theory["total_mean"]) / np.sqrt(theory["total_variance"])
    of_residuals.plot(steps, residuals, ".", markersize=4, label=label)
of_residuals.set(xlabel="phase step", ylabel="residual of the\ntotal count (std)")
of_residuals.legend(loc="lower right", bbox_to_anchor=(1, 1), ncols=2, frameon=False)
plt.show()
