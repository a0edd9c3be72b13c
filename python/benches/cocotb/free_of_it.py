"""The example's testbench without the scoreboard: what it is measured against."""

import cocotb
from cocotb.clock import Clock
from cocotb.triggers import ClockCycles
from test_sensor import CLOCKS, drive_samples, results_of


@cocotb.test()
async def runs(dut):
    dut.i_rst.value = 1
    dut.i_samples.value = 0
    results_of(dut)
    Clock(dut.i_clk, 8, unit="ns").start()
    await ClockCycles(dut.i_clk, 4)
    dut.i_rst.value = 0
    cocotb.start_soon(drive_samples(dut))
    await ClockCycles(dut.i_clk, CLOCKS)
