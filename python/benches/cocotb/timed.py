"""The example's testbench with or without the scoreboard, and its processor time."""

import os
import time

import cocotb
import goldtof.cocotb
from cocotb.clock import Clock
from cocotb.triggers import ClockCycles
from test_sensor import CLOCKS, drive_samples, results_of

import goldtof


@cocotb.test()
async def runs(dut):
    started = time.process_time()
    scoreboard = None
    if "WITH_SCOREBOARD" in os.environ:
        scene = goldtof.Scene.load(os.environ["SCENE"])
        scoreboard = goldtof.cocotb.Scoreboard(dut.recorder, scene)
    dut.i_rst.value = 1
    dut.i_samples.value = 0
    results_of(dut)
    Clock(dut.i_clk, 8, unit="ns").start()
    await ClockCycles(dut.i_clk, 4)
    dut.i_rst.value = 0
    cocotb.start_soon(drive_samples(dut))
    await ClockCycles(dut.i_clk, CLOCKS)
    if scoreboard is not None:
        await scoreboard.check()
    cocotb.log.info("took %.3f s", time.process_time() - started)
