"""A testbench of the sensor of scene.toml for cocotb 2: every output port, at every clock, against
goldtof's reference model.

    make                 in Icarus; SIM=verilator in Verilator
    make RTL="../mine.v ../more.v" DESIGN=mine LATENCY=auto

The second holds a design of your own to the model, at the latency that it shows. `emit --cocotb` makes
these files anew: change a copy of them.
"""

import os
import random
from pathlib import Path

import cocotb
import goldtof.cocotb
from cocotb.clock import Clock
from cocotb.triggers import ClockCycles, RisingEdge

import goldtof

HERE = Path(__file__).resolve().parent
# Keys that were overridden as the design was emitted.
SETTINGS = @SETTINGS@
# Until some results have come: of a phase step one, of a histogram one for each row.
CLOCKS = int(os.environ.get("CLOCKS") or "@CLOCKS@")
LATENCY = os.environ.get("LATENCY", "")
SEED = int(os.environ.get("SEED") or "1")


def scene_of_design():
    """The scene that the design was emitted for."""
    scene = goldtof.Scene.load(HERE / "scene.toml")
    for key, value in SETTINGS:
        scene[key] = value
    return scene


def idle_samples(scene, width):
    """What samples are without pulses: with a comparator that inverts, high."""
    return (1 << width) - 1 if scene["hardware.polarity"] == "low" else 0


async def drive_samples(dut, draw, idle, samples):
    """Pulses of one sample to some, at random, in one word of three, at one input or at several at once:
    cells of which a hit takes several have them together."""
    inputs = len(dut.i_samples) // samples
    while True:
        await RisingEdge(dut.i_clk)
        pulses = 0
        if draw.random() < 0.3:
            pulse = (draw.getrandbits(3) | 1) << draw.randrange(samples)
            for place in draw.sample(range(inputs), draw.randint(1, inputs)):
                pulses |= (pulse & ((1 << samples) - 1)) << samples * place
        dut.i_samples.value = idle ^ pulses


async def stall_receiver(dut, draw):
    """A receiver that is not ready at one clock of four."""
    while True:
        await RisingEdge(dut.i_clk)
        dut.m_axis_tready.value = int(draw.random() < 0.75)


@cocotb.test()
async def every_port_is_what_the_model_says(dut):
    scene = scene_of_design()
    held_to = "auto" if LATENCY == "auto" else int(LATENCY) if LATENCY else None
    scoreboard = goldtof.cocotb.Scoreboard(dut.recorder, scene, result_latency_clocks=held_to)
    idle = idle_samples(scene, len(dut.i_samples))
    dut.i_rst.value = 1
    dut.i_samples.value = idle
    dut.m_axis_tready.value = 1
@HOST_AT_REST@    # Even, so that half of it is whole.
    period_ps = 2 * max(1, round(scene.chip_period_s * 5e11))
    Clock(dut.i_clk, period_ps, unit="ps").start()
    await ClockCycles(dut.i_clk, 4)
    dut.i_rst.value = 0
    draw = random.Random(SEED)
    samples = scene["clock.samples_per_chip"]
    cocotb.start_soon(drive_samples(dut, draw, idle, samples))
    cocotb.start_soon(stall_receiver(dut, draw))
    await ClockCycles(dut.i_clk, CLOCKS)
    await scoreboard.check()
