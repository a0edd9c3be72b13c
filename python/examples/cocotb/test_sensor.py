"""A cocotb testbench of a sensor, with goldtof's scoreboard.

The samples come from Python a word at a time; the ports go back a batch at a time.
"""

import os
import random

import cocotb
import goldtof.cocotb
from cocotb.clock import Clock
from cocotb.triggers import ClockCycles, RisingEdge

import goldtof

CLOCKS = int(os.environ.get("CLOCKS", "6000"))
LATENCY = os.environ.get("LATENCY")


async def drive_samples(dut):
    """A short pulse in every third word or so."""
    draw = random.Random(1)
    while True:
        await RisingEdge(dut.i_clk)
        dut.i_samples.value = draw.choice((0x01, 0x30, 0xC3)) if draw.random() < 0.3 else 0


@cocotb.test()
async def every_port_is_what_the_model_says(dut):
    scene = goldtof.Scene.load(os.environ["SCENE"])
    scoreboard = goldtof.cocotb.Scoreboard(
        dut.recorder, scene, result_latency_clocks=int(LATENCY) if LATENCY else None
    )
    dut.i_rst.value = 1
    dut.i_samples.value = 0
    dut.m_axis_tready.value = 1
    Clock(dut.i_clk, 8, unit="ns").start()
    await ClockCycles(dut.i_clk, 4)
    dut.i_rst.value = 0
    cocotb.start_soon(drive_samples(dut))
    await ClockCycles(dut.i_clk, CLOCKS)
    await scoreboard.check()
