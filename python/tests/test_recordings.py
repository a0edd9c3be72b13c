"""Time tags: the reader against ptufile, which reads them independently, and replays of arrays."""

import struct

import goldtof
import numpy as np
import ptufile
import pytest

from conftest import ROOT

QUICK = goldtof.Scene.load(ROOT / "scenes/quick.toml")
# Record types of T2 mode.
PICOHARP, HYDRAHARP_1, HYDRAHARP_2, MULTIHARP = 0x00010203, 0x00010204, 0x01010204, 0x00010207


def tag(name, kind, value):
    return name.encode().ljust(32, b"\0") + struct.pack("<iI", -1, kind) + value


def header(record_type, records, resolution_s):
    integer = lambda number: struct.pack("<q", number)
    return b"".join([
        b"PQTTTR\0\0", b"1.0.00\0\0",
        tag("File_CreatingTime", 0x21000008, struct.pack("<d", 45000.0)),
        tag("Measurement_Mode", 0x10000008, integer(2)),
        tag("Measurement_SubMode", 0x10000008, integer(0)),
        tag("MeasDesc_GlobalResolution", 0x20000008, struct.pack("<d", resolution_s)),
        tag("TTResultFormat_TTTRRecType", 0x10000008, integer(record_type)),
        tag("TTResultFormat_BitsPerRecord", 0x10000008, integer(32)),
        tag("TTResult_NumberOfRecords", 0x10000008, integer(records)),
        tag("Header_End", 0xFFFF0008, integer(0)),
    ])


def picoharp(ticks, inputs, markers):
    """Records of 28 bits of time; overflows are of 210,698,240 ticks."""
    records, overflows = [], 0
    for time, channel, marker in zip(ticks, inputs, markers):
        while time >= (overflows + 1) * 210_698_240:
            records.append(0xF0000000)
            overflows += 1
        low = time - overflows * 210_698_240
        records.append(0xF0000000 | (low & ~15) | marker if marker else channel << 28 | low)
    return records


def hydraharp(wrap, counted):
    def records_of(ticks, inputs, markers):
        records, overflows = [], 0
        for time, channel, marker in zip(ticks, inputs, markers):
            more = time // wrap - overflows
            if more and counted:
                records.append(0xFE000000 | more)
            records += [] if counted else [0xFE000000] * more
            overflows += more
            low = time - overflows * wrap
            records.append((0x80000000 | marker << 25 if marker else channel << 25) | low)
        return records
    return records_of


INSTRUMENTS = {
    "PicoHarp": (PICOHARP, 4e-12, picoharp),
    "HydraHarp 1": (HYDRAHARP_1, 1e-12, hydraharp(33_552_000, counted=False)),
    "HydraHarp 2": (HYDRAHARP_2, 1e-12, hydraharp(1 << 25, counted=True)),
    "MultiHarp": (MULTIHARP, 5e-12, hydraharp(1 << 25, counted=True)),
}


@pytest.mark.parametrize("instrument", INSTRUMENTS)
def test_the_reader_agrees_with_ptufile(tmp_path, instrument):
    record_type, resolution_s, records_of = INSTRUMENTS[instrument]
    random = np.random.default_rng(5)
    # Some gaps of several overflows.
    ticks = np.cumsum(random.integers(1, 40_000, 20_000)
                      + 10**9 * (random.random(20_000) < 0.002)).tolist()
    inputs = random.integers(0, 4, len(ticks)).tolist()
    markers = [int(random.integers(1, 3)) if random.random() < 0.05 else 0 for _ in ticks]
    if instrument == "PicoHarp":
        # The lowest bits of a marker's time are the marker itself, counted from the last overflow.
        ticks = [time - time % 210_698_240 + (time % 210_698_240 & ~15 | marker) if marker else time
                 for time, marker in zip(ticks, markers)]
    records = records_of(ticks, inputs, markers)
    path = tmp_path / "tags.ptu"
    words = np.array(records, "<u4").tobytes()
    path.write_bytes(header(record_type, len(records), resolution_s) + words)

    told = goldtof.read_tags(path)
    assert told["tick_s"] == pytest.approx(resolution_s)
    channels = [-marker if marker else channel + 1 for channel, marker in zip(inputs, markers)]
    assert told["ticks"].tolist() == ticks
    assert told["channels"].tolist() == channels

    with ptufile.PtuFile(path) as other:
        decoded = other.decode_records()
    photons = decoded[decoded["channel"] >= 0]
    ours = told["channels"] > 0
    assert photons["time"].tolist() == told["ticks"][ours].tolist()
    assert (photons["channel"] + 1).tolist() == told["channels"][ours].tolist()
    marks = decoded[decoded["marker"] > 0]
    assert marks["time"].tolist() == told["ticks"][told["channels"] < 0].tolist()


def test_arrays_and_files_say_the_same(tmp_path):
    epochs = np.arange(0, 5 * 10**8, 248_000)
    # Never at a sample, where rounding would decide.
    photons = epochs + 20_333 + np.arange(len(epochs)) * 7000 % 200_000
    times = np.concatenate([epochs, photons])
    channels = np.repeat([2, 1], len(epochs))
    of_arrays = goldtof.replay(QUICK, (times, channels), photons={"spad": 1}, epoch=2)
    order = np.argsort(times, kind="stable")
    path = tmp_path / "pairs.bin"
    np.column_stack([times, channels])[order].astype("<u8").tofile(path)
    of_file = goldtof.replay(QUICK, path, photons="1", epoch="2")
    bins = [told["detectors"][0].pop("bins") for told in (of_arrays, of_file)]
    assert bins[0].tolist() == bins[1].tolist()
    assert of_arrays == of_file
    # By hand, of all but the last period, which no epoch ends: the sample at or after each photon.
    expected = np.bincount(np.ceil((photons[:-1] % 248_000) / 1000).astype(int) % 248, minlength=248)
    assert bins[0].tolist() == expected.tolist()
    # In ticks of 4 ps the same, as arrays of a Photon-HDF5 file are.
    ticks = goldtof.replay(QUICK, (times // 4, channels), photons=1, epoch=2, tick_s=4e-12)
    assert ticks["detectors"][0]["photons"] == of_file["detectors"][0]["photons"]


def test_what_is_no_recording_is_refused(tmp_path):
    times = np.arange(0, 10**7, 248_000)
    with pytest.raises(ValueError, match="two arrays of one length"):
        goldtof.replay(QUICK, (times, times[:-1]), photons=1, epoch=2)
    with pytest.raises(ValueError, match="whole numbers from 0 up"):
        goldtof.replay(QUICK, (times - 1, times), photons=1, epoch=2)
    with pytest.raises(ValueError, match="names no detector of the scene: write spad=1"):
        goldtof.replay(QUICK, (times, times), photons={"left": 1}, epoch=2)
    with pytest.raises(ValueError, match='"x" is not a channel'):
        goldtof.replay(QUICK, (times, times), photons=1, epoch="x")
    with pytest.raises(goldtof.GoldtofError, match="channel 2 has no record"):
        goldtof.replay(QUICK, (times, np.ones_like(times)), photons=1, epoch=2)
    torn = tmp_path / "torn.ptu"
    torn.write_bytes(header(HYDRAHARP_2, 0, 1e-12)[:90])
    with pytest.raises(goldtof.GoldtofError, match="torn.ptu, byte 90: the file ends within its header"):
        goldtof.read_tags(torn)
    with pytest.raises(goldtof.GoldtofError, match="nowhere.ptu"):
        goldtof.read_tags(tmp_path / "nowhere.ptu")
