"""A host at the registers of the sensor of scene.toml, for cocotb 2 and cocotbext-axi: it reads what the
sensor is, stops it, writes other settings, and has one scan. Every port is held against goldtof's reference
model at every clock; and, where a phase step can last whole code periods, counts against those that
follow from the chips that the lasers showed and the levels that the detectors had.

`make` runs it behind test_sensor.py.
"""

import random

import cocotb
import goldtof.cocotb
from cocotb.clock import Clock
from cocotb.triggers import ClockCycles, RisingEdge
from cocotbext.axi import AxiLiteBus, AxiLiteMaster
from test_sensor import LATENCY, SEED, idle_samples, scene_of_design, stall_receiver

# Byte addresses.
REGISTERS = @REGISTERS@
# The number of each detector's reference among the lasers.
REFERENCES = @REFERENCES@
SAMPLES = @SAMPLES@  # of a chip
CELLS = @CELLS@  # of a detector, with samples each
COINCIDENCE = @COINCIDENCE@  # cells that a hit takes
PARALLEL = @PARALLEL@  # phase steps at once
CODE_CHIPS = @CODE_CHIPS@
COUNT_BITS = @COUNT_BITS@
# Other settings than the scene's.
CHIPS, GROUPS, FIRST = @CHIPS@, @GROUPS@, @FIRST@
SINGLE, BUSY = 1 << 1, 1 << 2


def pulse(first):
    """A pulse of as many cells as a hit takes, from one of them on."""
    return sum(1 << SAMPLES * ((first + cell) % CELLS) for cell in range(COINCIDENCE))


async def answer_lasers(dut, idle, periods):
    """A pulse to each chip of a detector's laser that is 1, a chip late; notes what the lasers of all detectors
    show, code period by code period."""
    shown, clock = [], 0
    while True:
        await RisingEdge(dut.i_clk)
        clock += 1
        lasers, epoch = int(dut.o_laser.value), int(dut.o_epoch.value)
        levels = [lasers >> reference & 1 for reference in REFERENCES]
        words = sum(level * pulse(clock) << SAMPLES * CELLS * number for number, level in enumerate(levels))
        dut.i_samples.value = idle ^ words
        if epoch:
            periods.append(shown)
            shown = []
        shown.append(levels)


async def take_results(dut, beats):
    """Notes what the receiver takes."""
    while True:
        await RisingEdge(dut.i_clk)
        if dut.m_axis_tvalid.value == 1 and dut.m_axis_tready.value == 1:
            beats.append((int(dut.m_axis_tdata.value), int(dut.m_axis_tlast.value)))


def count(chips, step):
    """The signed count of a phase step of whole code periods: pulses at the first sample of the chip after
    each that is 1, up where the delayed reference is 1, else down."""
    total = 0
    for chip, level in enumerate(chips):
        # One that follows another at once, in a chip of one sample, is not a rising edge.
        if level and not (SAMPLES == 1 and chips[chip - 1]):
            place = (chip + 1) * SAMPLES - step
            total += 1 if chips[place // SAMPLES % CODE_CHIPS] else -1
    return total * CHIPS // CODE_CHIPS


@cocotb.test()
async def a_scan_with_other_settings_is_what_the_model_says(dut):
    scene = scene_of_design()
    held_to = "auto" if LATENCY == "auto" else int(LATENCY) if LATENCY else None
    dut.i_rst.value = 1
    idle = idle_samples(scene, len(dut.i_samples))
    dut.i_samples.value = idle
    dut.m_axis_tready.value = 1
    host = AxiLiteMaster(AxiLiteBus.from_prefix(dut, "s_axil"), dut.i_clk, dut.i_rst)
    scoreboard = goldtof.cocotb.Scoreboard(dut.recorder, scene, result_latency_clocks=held_to)
    period_ps = 2 * max(1, round(scene.chip_period_s * 5e11))
    Clock(dut.i_clk, period_ps, unit="ps").start()
    await ClockCycles(dut.i_clk, 4)
    dut.i_rst.value = 0
    periods, beats = [], []
    cocotb.start_soon(answer_lasers(dut, idle, periods))
    cocotb.start_soon(stall_receiver(dut, random.Random(SEED)))
    cocotb.start_soon(take_results(dut, beats))

    async def end_of_scan():
        while await host.read_dword(REGISTERS["STATUS"]) & (SINGLE | BUSY):
            pass

    assert await host.read_dword(REGISTERS["MAGIC"]) == 0x676F6C64
    settings = {"CHIPS": CHIPS, "GROUPS": GROUPS, "FIRST": FIRST}
    for name in REGISTERS:
        if name.startswith("SEED_"):
            settings[name] = await host.read_dword(REGISTERS[name]) ^ 1
    for name, value in settings.items():
        await host.write_dword(REGISTERS[name], value)
        assert await host.read_dword(REGISTERS[name]) == value
    # The scene's scan may take long. Settings outlast a reset, which ends it.
    dut.i_rst.value = 1
    await ClockCycles(dut.i_clk, 2)
    dut.i_rst.value = 0
    await host.write_dword(REGISTERS["CONTROL"], 0)
    await end_of_scan()
    await ClockCycles(dut.i_clk, 300)
    beats.clear()
    await host.write_dword(REGISTERS["CONTROL"], SINGLE)
    await end_of_scan()
    # The last results, and the batch of the recorder that they are in.
    await ClockCycles(dut.i_clk, 600)
    await scoreboard.check()
    results = GROUPS * PARALLEL * len(REFERENCES)
    assert [last for _, last in beats] == [0] * (results - 1) + [1], beats
    if CHIPS % CODE_CHIPS == 0:
        chips = periods[-1]
        assert len(chips) == CODE_CHIPS
        for number, (data, _) in enumerate(beats):
            group, of_group = divmod(number, PARALLEL * len(REFERENCES))
            detector, lane = divmod(of_group, PARALLEL)
            step = (FIRST + group * PARALLEL + lane) % (CODE_CHIPS * SAMPLES)
            counted = data & (1 << COUNT_BITS) - 1
            counted -= (counted >> COUNT_BITS - 1) << COUNT_BITS
            expected = count([levels[detector] for levels in chips], step)
            assert counted == expected, f"detector {detector}, step {step}"

