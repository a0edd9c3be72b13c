# ---
# jupyter:
#   jupytext:
#     text_representation:
#       extension: .py
#       format_name: percent
# ---

# %% [markdown]
# # Your own RTL against the model
#
# `examples/own-rtl` is a sensor written by hand, with the ports of the emitted one but
# another inside. Here it is run beside the bit-exact reference model, every port at
# every clock.
#
# Needs `pip install ./python matplotlib`, Verilator and g++, and runs in the
# repository's folder. The Verilog is built once; later runs find it again.

# %%
from typing import Any

import matplotlib.pyplot as plt

import goldtof

scene = goldtof.Scene.load("scenes/quick.toml")


def run(**options: Any) -> dict[str, Any]:
    return goldtof.cosim(
        scene, file_lists=["examples/own-rtl/range_top.f"], top="range_top",
        engine="lockstep", **options,
    )


# %% [markdown]
# Its results come later than the emitted design's; how much is found by a short run.

# %%
told = run(latency="auto", clocks=100_000)
latency = told["latency"]["result_clocks"]
print(told["verdict"], f"at a latency of {latency} clocks; emitted: {scene.result_latency_clocks}")

# %% [markdown]
# Photons never bring a receiver that stalls, or a reset. Hostile inputs do, and say
# how many of their cover points they have reached.

# %%
hostile = run(latency=str(latency), stimulus="adversarial")
coverage = hostile["coverage"]
print(hostile["verdict"], f"in {hostile['clocks']} clocks,", end=" ")
print(f"{coverage['covered']} of {coverage['points']} cover points")

# %% [markdown]
# A match says little if nothing could fail. Held to another latency, the same design has
# to differ, and at which clock it does is known: that of the first result, a step's
# 2,500 words behind the reset, and the earlier of the two latencies.

# %%
latencies = range(latency - 4, latency + 5)
agreed = []
for held_to in latencies:
    told = run(latency=str(held_to), clocks=20_000)
    first = told["first_mismatch"]
    agreed.append(told["clocks"] if first is None else first["clock"])
    port = "" if first is None else f", first at port {first['port']}, clock {first['clock']}"
    print(f"held to {held_to:2d} clocks: {told['verdict']}{port}")

# %%
figure, axes = plt.subplots(figsize=(7, 3.5), layout="constrained")
colors = ["C2" if held_to == latency else "C3" for held_to in latencies]
axes.bar(latencies, agreed, color=colors)
for held_to, clocks in zip(latencies, agreed):
    axes.annotate(f"{clocks:,}", (held_to, clocks), ha="center", va="bottom", fontsize=8)
axes.set(
    xlabel="result latency that the design is held to (clocks)",
    ylabel="clocks that agree",
    title="The design matches at its own latency alone",
    xticks=list(latencies),
)
plt.show()
