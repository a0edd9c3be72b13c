"""A cocotb testbench of a sensor, with goldtof's scoreboard.

Samples come from Python a word at a time, and cocotbext-axi takes the results; the ports
go to the scoreboard a batch at a time.
"""

import itertools
import os
import random

import cocotb
import goldtof.cocotb
from cocotb.clock import Clock
from cocotb.triggers import ClockCycles, RisingEdge
from cocotbext.axi import AxiStreamBus, AxiStreamSink

import goldtof

CLOCKS = int(os.environ.get("CLOCKS", "6000"))
LATENCY = os.environ.get("LATENCY")


async def drive_samples(dut):
    """A short pulse in every third word or so."""
    draw = random.Random(1)
    while True:
        await RisingEdge(dut.i_clk)
        dut.i_samples.value = draw.choice((0x01, 0x30, 0xC3)) if draw.random() < 0.3 else 0


def results_of(dut):
    """A receiver of the results, which is not ready at every third clock."""
    bus = AxiStreamBus.from_prefix(dut, "m_axis")
    # Without TKEEP a beat would be taken apart into bytes; here it is one count.
    sink = AxiStreamSink(bus, dut.i_clk, dut.i_rst, byte_size=len(dut.m_axis_tdata))
    sink.set_pause_generator(itertools.cycle((0, 0, 1)))
    return sink


@cocotb.test()
async def every_port_is_what_the_model_says(dut):
    scene = goldtof.Scene.load(os.environ["SCENE"])
    scoreboard = goldtof.cocotb.Scoreboard(
        dut.recorder, scene, result_latency_clocks=int(LATENCY) if LATENCY else None
    )
    dut.i_rst.value = 1
    dut.i_samples.value = 0
    sink = results_of(dut)
    Clock(dut.i_clk, 8, unit="ns").start()
    await ClockCycles(dut.i_clk, 4)
    dut.i_rst.value = 0
    cocotb.start_soon(drive_samples(dut))
    await ClockCycles(dut.i_clk, CLOCKS)
    await scoreboard.check()
    # A frame is a scan, and comes when it is whole.
    while not sink.empty():
        counts = sink.recv_nowait().tdata
        assert len(counts) == scene.phase_steps
        cocotb.log.info("a scan of %d counts", len(counts))
