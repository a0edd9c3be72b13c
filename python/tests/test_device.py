"""A device at a pseudo-terminal, whose frames are made here, byte by byte, as docs/wire.md has them."""

import hashlib
import os
import select
import struct
import threading
import time
import tty
import zlib
from collections.abc import Callable, Iterator
from pathlib import Path

import goldtof
import numpy as np
import pytest

QUICK = Path(__file__).resolve().parents[2] / "scenes/quick.toml"
STEPS, COUNT_BITS, TOTAL_BITS = 248, 17, 16


class Simulated:
    """The far end of a line: it answers, and sends what it is told to."""

    def __init__(self, *, registers: bool = True, scene: Path = QUICK) -> None:
        self.scene = scene
        self.far, self.near = os.openpty()
        tty.setraw(self.near)
        self.port = os.ttyname(self.near)
        self.sequence = 0
        self.registers = {0: 0x676F6C64} if registers else None
        self.sent = threading.Lock()
        self.gone = False
        self.answers = threading.Thread(target=self._answer, daemon=True)
        self.answers.start()

    def send(self, kind: int, flags: int, body: bytes) -> None:
        frame = bytes([kind, self.sequence % 256, flags]) + body
        self.sequence += 1
        os.write(self.far, b"\xa5" + frame + struct.pack("<I", zlib.crc32(frame)))

    def identity(self) -> bytes:
        digest = hashlib.sha256(self.scene.read_bytes()).digest()[:8]
        head = struct.pack("<BBBBBBBB", 1, 0, COUNT_BITS, 1, TOTAL_BITS, 1, 8, 0)
        numbers = b"".join(number.to_bytes(3, "little") for number in (0, STEPS, 31))
        return head + struct.pack("<I", 8_000_000) + numbers + struct.pack("<BH", 0, 1) + digest

    def _answer(self) -> None:
        try:
            while True:
                request = b""
                while len(request) < 13:
                    # A terminal that is read stays open for as long.
                    while not select.select([self.far], [], [], 0.05)[0]:
                        if self.gone:
                            return
                    request += os.read(self.far, 13 - len(request))
                kind, tag, address, data, crc = struct.unpack("<xBBHII", request)
                assert crc == zlib.crc32(request[1:9])
                with self.sent:
                    if kind == ord("I") or self.registers is None:
                        self.send(ord("I"), 0, request[1:5] + self.identity())
                        continue
                    refused = address >= 0x800
                    if kind == ord("W") and not refused:
                        self.registers[address] = data
                    data = 0 if refused else self.registers.get(address, 0)
                    flags = (3 if refused else 0) << 4
                    self.send(ord("A"), flags, request[1:5] + struct.pack("<I", data))
        except OSError:
            pass

    def scan(self, counts: np.ndarray, totals: np.ndarray, *, torn: bool = False) -> None:
        """Sends a scan in frames of 62 results; torn, without a byte of the second one."""
        for first in range(0, STEPS, 62):
            bits = 0
            for place in range(62):
                signed = int(counts[first + place]) & (1 << COUNT_BITS) - 1
                result = signed | int(totals[first + place]) << COUNT_BITS
                bits |= result << place * (COUNT_BITS + TOTAL_BITS)
            payload = bits.to_bytes((62 * (COUNT_BITS + TOTAL_BITS) + 7) // 8, "little")
            last = first + 62 == STEPS
            body = bytes([62]) + first.to_bytes(3, "little") + b"\0\0" + payload
            with self.sent:
                if torn and first == 62:
                    frame = bytes([ord("C"), self.sequence % 256, 0]) + body
                    self.sequence += 1
                    os.write(self.far, b"\xa5" + frame[:-1])
                else:
                    self.send(ord("C"), int(last), body)

    def unplug(self) -> None:
        self.gone = True
        self.answers.join()
        os.close(self.near)
        # What is not read when a terminal goes is lost.
        time.sleep(0.5)
        os.close(self.far)


@pytest.fixture
def simulated() -> Iterator[Callable[..., Simulated]]:
    yield Simulated


def test_taps_that_make_no_code_are_not_written(simulated: Callable[..., Simulated]) -> None:
    scene = QUICK.parents[1] / "tests/scenes/taps.toml"
    board = simulated(scene=scene)
    # CHIPS in bits 4..0, TAPS in 9..5. x^5 + x^4 + x^3 + x^2 + x + 1 divides x^6 - 1.
    good, bad = 0x0F << 5 | 0x13, 0x1F << 5 | 0x13
    with goldtof.device.open(board.port, scene) as device:
        device.write(0x024, good)
        with pytest.raises(ValueError, match="not a primitive polynomial of degree 5"):
            device.write(0x024, bad)
        assert board.registers[0x024] == good
        device.write(0x024, bad, force=True)
        assert board.registers[0x024] == bad


def numbers(scan: int) -> tuple[np.ndarray, np.ndarray]:
    """Counts and totals of a scan, of either sign, up to the bits' ends."""
    steps = np.arange(STEPS)
    return (steps * 523 + scan * 97) % (1 << 17) - (1 << 16), (steps * 263 + scan) % (1 << 16)


def test_scans_are_arrays_of_what_was_sent(simulated: Callable[..., Simulated]) -> None:
    board = simulated()
    begun = time.time()
    with goldtof.device.open(board.port, QUICK) as device:
        assert device.identity["phase_steps"] == STEPS
        assert device.identity["chip_period_s"] == pytest.approx(8e-9)
        assert device.identity["content"] == "counts"
        for scan in range(5):
            board.scan(*numbers(scan), torn=scan == 2)
        told = device.scans(4)
        assert told["signed"].shape == told["total"].shape == (4, STEPS)
        assert told["signed"].dtype == np.int64
        assert (told["phase_step"] == np.arange(STEPS)).all()
        # The third one is not whole, and has its number.
        assert told["scan"].tolist() == [0, 1, 3, 4]
        for row, scan in enumerate([0, 1, 3, 4]):
            counts, totals = numbers(scan)
            assert (told["signed"][row] == counts).all()
            assert (told["total"][row] == totals).all()
        assert (np.diff(told["time_s"]) >= 0).all()
        assert begun <= told["time_s"][0] <= told["time_s"][-1] <= time.time()
        assert device.tally["torn"] >= 1
        assert (device.tally["lost_frames"], device.tally["lost_results"]) == (1, 62)
        with pytest.raises(TimeoutError, match=r"no whole scan came in 0.2 s"):
            device.scan(timeout_s=0.2)


def test_registers_are_read_and_written(simulated: Callable[..., Simulated]) -> None:
    board = simulated()
    with goldtof.device.open(board.port) as device:
        assert device.read(0) == 0x676F6C64
        board.scan(*numbers(0))
        device.write(0x018, 150)
        assert (device.read(0x018), board.registers[0x018]) == (150, 150)
        with pytest.raises(goldtof.GoldtofError, match="refuses address 0x800"):
            device.read(0x800)
        # What came meanwhile is there.
        assert (device.scan()["signed"] == numbers(0)[0]).all()
    with pytest.raises(goldtof.GoldtofError, match="the device was closed"):
        device.read(0)
    board = simulated(registers=False)
    with (
        goldtof.device.open(board.port) as device,
        pytest.raises(goldtof.GoldtofError, match="no registers"),
    ):
        device.read(0)


def test_an_unplugged_device_gives_all_that_came_before(
    simulated: Callable[..., Simulated],
) -> None:
    board = simulated()
    device = goldtof.device.open(board.port)
    for scan in range(3):
        board.scan(*numbers(scan))
    board.unplug()
    for number, scan in zip(range(3), device, strict=False):
        assert (scan["signed"] == numbers(number)[0]).all()
    with pytest.raises(ConnectionError, match="the device is gone"):
        device.scan()


def test_another_scene_and_another_port_are_refused(
    simulated: Callable[..., Simulated], tmp_path: Path
) -> None:
    other = tmp_path / "other.toml"
    other.write_text(QUICK.read_text() + "# another\n")
    with pytest.raises(goldtof.GoldtofError, match="built from another scene"):
        goldtof.device.open(simulated().port, other)
    with pytest.raises(goldtof.GoldtofError, match="no-such-port"):
        goldtof.device.open("no-such-port")


def test_counts_from_a_device_are_ranged_like_simulated_ones(
    simulated: Callable[..., Simulated], quick: goldtof.Scene
) -> None:
    counts = goldtof.scans(quick, fidelity="counts", seed=3)
    board = simulated()
    with goldtof.device.open(board.port, QUICK) as device:
        board.scan(counts["signed"][0], counts["total"][0])
        told = device.scans(1)
    mine = goldtof.estimate(quick, told["signed"][0], total=told["total"][0])
    theirs = goldtof.estimate(quick, counts["signed"][0], total=counts["total"][0])
    assert mine.distance_m == theirs.distance_m
    assert abs(mine.distance_m - 3.2) < 0.2
