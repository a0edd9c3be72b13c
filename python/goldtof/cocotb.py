"""A scoreboard for cocotb: every output port against the reference model, at every clock.

Nothing in Python happens at each clock. A small module of Verilog beside the design,
``goldtof_recorder`` (:func:`recorder_source` has its file), keeps the ports; the scoreboard
reads and compares a batch of clocks at a time::

    @cocotb.test()
    async def compares_with_the_model(dut):
        scene = goldtof.Scene.load("scenes/quick.toml")
        scoreboard = goldtof.cocotb.Scoreboard(dut.recorder, scene)
        ...                          # clock, reset, samples, a receiver: your testbench
        await scoreboard.check()

Works with cocotb 2 in Icarus and Verilator.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any, Literal

import numpy as np

import cocotb

from . import GoldtofError, Scene
from . import Scoreboard as _Comparison

_KNOWN = str.maketrans("xXzZuUwWlLhH-", "0" * 13)


def recorder_source() -> Path:
    """The file of the module ``goldtof_recorder``."""
    return Path(__file__).with_name("verilog") / "goldtof_recorder.v"


class Mismatch(AssertionError):
    """A design does not do what the reference model says, or did too little to tell."""


class Scoreboard:
    """Stands beside a design, and hears of its ports from an instance of the recorder.

    Comparison begins with the first clock at which ``i_rst`` is high. A mismatch raises
    :class:`Mismatch`, with clock and port, in the batch in which it is found; with
    ``stop=False`` not before :meth:`check`. ``result_latency_clocks="auto"`` takes the design's own
    latency, which its first result tells.
    """

    def __init__(
        self,
        recorder: Any,
        scene: Scene,
        *,
        result_latency_clocks: int | Literal["auto"] | None = None,
        peak_latency_clocks: int | None = None,
        is_idle_payload_free: bool = True,
        stop: bool = True,
    ) -> None:
        has_registers = hasattr(recorder, "s_axil_awvalid")
        names = _RECORD + _REGISTERS if has_registers else _RECORD
        self._ports = [(name, len(getattr(recorder, name))) for name in names]
        # A clock's record has whole words.
        self._bits = -(-sum(width for _, width in self._ports) // 64) * 64
        self._batch = recorder.batch
        self._is_new = recorder.is_new
        self._is_idle_payload_free = is_idle_payload_free
        self._stop = stop
        self._has_reset = False
        self._unknown: str | None = None
        self._clocks = 0
        self._comparison = _Comparison(
            scene,
            self._ports,
            result_latency_clocks=result_latency_clocks,
            peak_latency_clocks=peak_latency_clocks,
            is_idle_payload_free=is_idle_payload_free,
            batch_clocks=len(recorder.batch) // self._bits,
        )
        self._task = cocotb.start_soon(self._listen())

    async def _listen(self) -> None:
        while True:
            await self._is_new.value_change
            self._take()

    def _take(self) -> None:
        text = str(self._batch.value)
        # Not is_resolvable, which goes through the bits one by one in Python.
        if text.strip("01"):
            self._look_for_unknown(text)
            text = text.translate(_KNOWN)
        self._clocks += len(text) // self._bits
        words = np.frombuffer(int(text, 2).to_bytes(len(text) // 8, "little"), "<u8")
        if not self._comparison.push(words) or self._unknown:
            if self._stop:
                raise Mismatch(self.report())
        self._has_reset = self._has_reset or bool(np.any(words[:: self._bits // 64] & 1))

    def _look_for_unknown(self, text: str) -> None:
        """Finds the first X or Z that counts; it is lost when bits become numbers."""
        has_reset = self._has_reset
        for number in range(len(text) // self._bits):
            end = len(text) - number * self._bits
            bits = text[end - self._bits : end][::-1]
            fields, at = {}, 0
            for name, width in self._ports:
                fields[name] = bits[at : at + width]
                at += width
            has_reset = has_reset or fields["i_rst"] == "1"
            for name, field in fields.items():
                # Whoever drives nothing may drive X.
                is_free = fields.get(_PAYLOADS.get(name, "")) == "0" and (
                    self._is_idle_payload_free or not name.startswith("m_axis"))
                if has_reset and not is_free and not set(field) <= {"0", "1"}:
                    clock = self._clocks + number
                    self._unknown = self._unknown or f"clock {clock}: port {name} is unknown"
                    return

    @property
    def summary(self) -> dict[str, Any]:
        """What the clocks so far say, as :meth:`goldtof.Scoreboard.summary` has it."""
        return self._comparison.summary()

    def report(self) -> str:
        """The same in words."""
        if self._unknown:
            return f"mismatch: {self._unknown}"
        return str(self._comparison.summary()["text"])

    async def check(self) -> str:
        """Waits for the end of the present batch, while the clock runs, and judges.

        Gives the report of a match; raises :class:`Mismatch` with that of anything else.
        """
        if not self._task.done():
            # Else both of us would take the batch.
            self._task.cancel()
            await self._is_new.value_change
            self._take()
        report = self.report()
        if self._unknown or self._comparison.summary()["verdict"] != "match":
            raise Mismatch(report)
        cocotb.log.info("goldtof: %s", report)
        return report


# The recorder's ports, as they lie in its record, the first at bit 0.
_RECORD = (
    "i_rst",
    "o_laser",
    "o_epoch",
    "i_samples",
    "m_axis_tdata",
    "m_axis_tvalid",
    "m_axis_tready",
    "m_axis_tlast",
    "o_overrun",
    "o_saturated",
    "o_peak_step",
    "o_peak_count",
    "o_peak_valid",
)

# Those of a sensor with registers, behind them: what a host drives, then what it sees.
_REGISTERS = (
    "s_axil_awaddr",
    "s_axil_awvalid",
    "s_axil_wdata",
    "s_axil_wstrb",
    "s_axil_wvalid",
    "s_axil_bready",
    "s_axil_araddr",
    "s_axil_arvalid",
    "s_axil_rready",
    "s_axil_awready",
    "s_axil_wready",
    "s_axil_bresp",
    "s_axil_bvalid",
    "s_axil_arready",
    "s_axil_rdata",
    "s_axil_rresp",
    "s_axil_rvalid",
)

# Ports that mean nothing while another one is low.
_PAYLOADS = {
    "m_axis_tdata": "m_axis_tvalid",
    "m_axis_tlast": "m_axis_tvalid",
    "s_axil_awaddr": "s_axil_awvalid",
    "s_axil_wdata": "s_axil_wvalid",
    "s_axil_wstrb": "s_axil_wvalid",
    "s_axil_araddr": "s_axil_arvalid",
}

__all__ = ["GoldtofError", "Mismatch", "Scoreboard", "recorder_source"]
