//! The host against a device that is simulated at the other end of a socket or a pseudo-terminal.

use std::io::{self, Read, Write};
use std::net::Shutdown;
use std::os::unix::net::UnixStream;
use std::thread;
use std::time::Duration;

use goldtof_device::{Device, DeviceError, Recorder, Sink, Watch};
use goldtof_wire::{
    Answer, Content, Event, Frame, Identity, Layout, Loss, REQUEST_HITS, REQUEST_IDENTITY,
    REQUEST_READ, REQUEST_TEXT, REQUEST_WRITE, Request, ResultsFrame, crc32, encode,
};

/// The scene's text in the device, two blocks less a byte.
const TEXT: &[u8; 63] = b"[clock]\nchip_period = \"8 ns\" # of the board\nsamples_per_chip=8\n";

fn identity() -> Identity {
    Identity {
        content: Content::Counts,
        layout: Layout { count_bits: 17, counts: 1, more_bits: 0 },
        detectors: 1,
        samples_per_chip: 8,
        chip_period_fs: 8_000_000,
        first_step: 240,
        steps: 10,
        code_chips: 31,
        parallel: 1,
        accumulate: 1,
        text_blocks: 2,
        counts_samples: true,
        scene: [1, 2, 3, 4, 5, 6, 7, 8],
    }
}

/// A line whose host end gives up after 20 ms.
fn line() -> (UnixStream, UnixStream) {
    let (host, device) = UnixStream::pair().expect("a pair");
    host.set_read_timeout(Some(Duration::from_millis(20))).expect("it can be set");
    (host, device)
}

/// Answers requests with the memory of a register file, until the line is closed: every third one not at all.
fn answer_requests(mut device: UnixStream, has_registers: bool) {
    let mut words = std::collections::BTreeMap::new();
    let mut sequence = 0_u8;
    let mut number = 0;
    let mut request = [0; goldtof_wire::REQUEST_BYTES];
    while device.read_exact(&mut request).is_ok() {
        assert_eq!(request[0], goldtof_wire::REQUEST_SYNC);
        assert_eq!(crc32(&request[1..9]).to_le_bytes(), request[9..]);
        number += 1;
        if number % 3 == 2 {
            continue;
        }
        let asked = Request {
            kind: request[1],
            tag: request[2],
            address: u16::from_le_bytes([request[3], request[4]]),
        };
        let data = u32::from_le_bytes([request[5], request[6], request[7], request[8]]);
        // Results come between request and answer, and now and then half a frame.
        let frame = ResultsFrame {
            index: u32::from(sequence % 5),
            results: vec![7; 2],
            ..ResultsFrame::default()
        };
        let results = encode::results(&frame, sequence, identity().layout);
        sequence += 1;
        device.write_all(&results).expect("it goes");
        device.write_all(&results[..9]).expect("it goes");
        let status = if asked.address >= 0x800 { 3 } else { 0 };
        let answer = match asked.kind {
            REQUEST_WRITE if has_registers => {
                words.insert(asked.address, data);
                encode::answer(Answer { request: asked, status, data: 0 }, sequence)
            }
            REQUEST_READ if has_registers => {
                let data = words.get(&asked.address).copied().unwrap_or(0);
                encode::answer(Answer { request: asked, status, data }, sequence)
            }
            REQUEST_TEXT => {
                let mut block = [0; 32];
                let bytes = TEXT.iter().skip(asked.address.into());
                block.iter_mut().zip(bytes).for_each(|(place, byte)| *place = *byte);
                encode::block(asked, &block, sequence)
            }
            REQUEST_HITS => {
                let mut block = [0; 32];
                for (place, bytes) in block.chunks_mut(4).enumerate() {
                    bytes.copy_from_slice(&(1000 * place as u32 + 7).to_le_bytes());
                }
                assert_eq!(asked.address, 0);
                encode::block(asked, &block, sequence)
            }
            _ => encode::identity(asked, &identity(), sequence),
        };
        sequence += 1;
        device.write_all(&answer).expect("it goes");
    }
}

#[test]
fn registers_are_written_and_read_though_answers_are_lost() {
    let (host, far) = line();
    let answers = thread::spawn(move || answer_requests(far, true));
    let mut device = Device::new(&host);
    assert_eq!(device.identify().expect("it answers"), identity());
    for (address, data) in [(0x10, 0x1234_5678), (0x14, 0xffff_ffff), (0x10, 0)] {
        device.write(address, data).expect("it is written");
        assert_eq!(device.read(address).expect("it is read"), data);
    }
    assert_eq!(device.scene_text(&identity()).expect("it is read"), TEXT);
    let hits = device.hits(&identity()).expect("they are read");
    assert_eq!(hits, [7, 1007, 2007, 3007, 4007, 5007, 6007, 7007]);
    let refused = device.read(0x800).unwrap_err();
    assert_eq!(refused.to_string(), "the device refuses address 0x800 (AXI response 3)");
    // What came between is kept.
    let mut results = 0;
    while let Some(event) = device.next_event().expect("the line is there") {
        results += usize::from(matches!(event, Event::Frame(Frame::Results(_))));
    }
    assert!(results >= 7, "{results}");
    host.shutdown(Shutdown::Both).expect("it can be closed");
    answers.join().expect("the device is content");
}

#[test]
fn a_build_without_registers_says_so() {
    let (host, far) = line();
    let answers = thread::spawn(move || answer_requests(far, false));
    let mut device = Device::new(&host);
    device.identify().expect("it answers");
    let error = device.write(4, 1).unwrap_err();
    assert!(matches!(error, DeviceError::NoRegisters), "{error}");
    let without = Identity { text_blocks: 0, counts_samples: false, ..identity() };
    let error = device.hits(&without).unwrap_err();
    assert!(matches!(error, DeviceError::NoHits), "{error}");
    let error = device.scene_text(&without).unwrap_err();
    assert!(matches!(error, DeviceError::NoText), "{error}");
    host.shutdown(Shutdown::Both).expect("it can be closed");
    answers.join().expect("the device is content");
}

#[test]
fn silence_and_an_unplugged_line_are_told_apart() {
    let (host, far) = line();
    let mut device = Device::new(&host);
    assert!(matches!(device.identify(), Err(DeviceError::Silent)));
    assert_eq!(device.next_event().expect("it is there"), None);
    drop(far);
    assert!(matches!(device.next_event(), Err(DeviceError::Unplugged(_))));
    assert!(matches!(device.identify(), Err(DeviceError::Unplugged(_))));
}

/// A disk with so much room.
#[derive(Debug)]
struct Disk {
    bytes: Vec<u8>,
    room: usize,
}

impl Write for Disk {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let count = bytes.len().min(self.room - self.bytes.len());
        if count == 0 {
            return Err(io::ErrorKind::StorageFull.into());
        }
        self.bytes.extend(&bytes[..count]);
        Ok(count)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Sink for Disk {
    fn cut(&mut self, length: u64) -> io::Result<()> {
        self.bytes.truncate(length as usize);
        Ok(())
    }
}

fn disk(room: usize) -> Disk {
    Disk { bytes: Vec::new(), room }
}

#[test]
fn counts_are_written_with_their_places_and_losses_beside_them() {
    let mut recorder =
        Recorder::new(disk(10_000), disk(10_000), identity()).expect("there is room");
    let minus_five = (1 << 17) - 5;
    let frame = ResultsFrame {
        index: 7,
        last: true,
        results: vec![1, minus_five, 3],
        ..ResultsFrame::default()
    };
    recorder.results(&frame, 1.5).expect("there is room");
    recorder.loss(&Loss { frames: 2, results: Some(3), dropped: 0 }, 1.75).expect("there is room");
    let frame = ResultsFrame { index: 3, results: vec![9], ..ResultsFrame::default() };
    recorder.results(&frame, 2.0).expect("there is room");
    // The rest of that scan and the beginning of this one are missing.
    let frame = ResultsFrame { index: 1, results: vec![8], ..ResultsFrame::default() };
    recorder.results(&frame, 2.5).expect("there is room");
    let (counts, losses) = recorder.into_sinks();
    // Step 7 of a scan from 240 on is 247, the last of 248.
    assert_eq!(
        String::from_utf8_lossy(&counts.bytes),
        "time_s,scan,detector,phase_step,count\n\
         1.500000,0,0,247,1\n1.500000,0,0,0,-5\n1.500000,0,0,1,3\n2.000000,1,0,243,9\n2.500000,2,0,241,8\n"
    );
    assert_eq!(
        String::from_utf8_lossy(&losses.bytes),
        "time_s,scan,frames,results,dropped\n1.750000,1,2,3,0\n"
    );
}

#[test]
fn a_full_disk_keeps_whole_frames_and_says_how_many_results_are_safe() {
    let frame = |index| ResultsFrame { index, results: vec![5; 4], ..ResultsFrame::default() };
    for room in 40..200 {
        let mut recorder =
            Recorder::new(disk(room), disk(1000), identity()).expect("the heading fits");
        let mut error = None;
        for index in [0, 4, 0, 4] {
            match recorder.results(&frame(index), 1.0) {
                Ok(()) => {}
                Err(full) => {
                    error.get_or_insert(full);
                }
            }
        }
        let written = recorder.written();
        let (counts, _) = recorder.into_sinks();
        let text = String::from_utf8(counts.bytes).expect("it is text");
        assert!(text.ends_with('\n'));
        assert_eq!(text.lines().count() as u64, 1 + written, "{room}");
        assert_eq!(written % 4, 0);
        let error = error.expect("the disk is too small");
        assert!(
            error
                .to_string()
                .starts_with(&format!("after {} results, which are written: ", error.results))
        );
    }
}

#[test]
fn the_watch_tells_the_largest_count_of_the_last_scan_and_its_distance() {
    let mut watch = Watch::new(Identity { first_step: 0, steps: 248, ..identity() });
    let mut results = vec![1; 21];
    results.push(1000);
    watch.results(&ResultsFrame { index: 0, results, ..ResultsFrame::default() });
    let rest = vec![2; 248 - 22];
    watch.results(&ResultsFrame {
        index: 22,
        last: true,
        overrun: true,
        results: rest,
        ..ResultsFrame::default()
    });
    let report = watch.report(Duration::ZERO, Default::default()).expect("it is due");
    let (step, count, distance_m, step_m) = report.peak.expect("there was a whole scan");
    // A step of 1 ns is 149.896 mm.
    assert_eq!((step, count), (21, 1000));
    assert!(
        (distance_m - 21.0 * 0.149_896_229).abs() < 1e-9 && (step_m - 0.149_896_229).abs() < 1e-9
    );
    assert!(report.to_string().contains("peak 1000 at step 21: 3.148 +- 0.043 m"), "{report}");
    assert!(report.to_string().ends_with("OVERRUN"), "{report}");
}

#[test]
fn no_peak_is_told_of_counts_that_are_all_the_same_or_where_some_are_missing() {
    let mut watch = Watch::new(Identity { first_step: 0, steps: 248, ..identity() });
    let frame = |index: u32, results: Vec<u128>, last| ResultsFrame {
        index,
        last,
        results,
        ..ResultsFrame::default()
    };
    let mut said = |frames: &[ResultsFrame]| {
        frames.iter().for_each(|frame| watch.results(frame));
        watch.report(Duration::ZERO, Default::default()).expect("it is due").to_string()
    };
    let with_peak = || (0..248).map(|step| 100 * u128::from(step == 21)).collect::<Vec<_>>();
    // Without its first half, and without its second frame.
    let text = said(&[frame(124, with_peak()[124..].to_vec(), true)]);
    assert!(text.contains("0 scans") && text.contains("no whole scan yet"), "{text}");
    let text = said(&[frame(0, vec![0; 20], false), frame(100, vec![0; 148], true)]);
    assert!(text.contains("0 scans") && text.contains("no whole scan yet"), "{text}");
    let text = said(&[frame(0, vec![3; 124], false), frame(124, vec![3; 124], true)]);
    assert!(text.contains("1 scans") && text.contains("no peak stands out"), "{text}");
    let text = said(&[frame(0, with_peak(), true)]);
    assert!(text.contains("2 scans") && text.contains("peak 100 at step 21: 3.148"), "{text}");
    // The last whole one stands.
    let text = said(&[frame(0, vec![7; 124], false), frame(200, vec![500; 48], true)]);
    assert!(text.contains("2 scans") && text.contains("peak 100 at step 21"), "{text}");
}

#[test]
fn a_request_of_another_kind_is_not_taken_for_an_answer() {
    // The identity answers a request with another tag: an answer that came too late.
    let (host, mut far) = line();
    let late = Request { kind: REQUEST_IDENTITY, tag: 200, address: 0 };
    far.write_all(&encode::identity(late, &identity(), 0)).expect("it goes");
    assert!(matches!(Device::new(&host).identify(), Err(DeviceError::Silent)));
}
