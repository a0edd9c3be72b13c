use std::collections::VecDeque;
use std::io::{self, Read, Write};
use std::path::PathBuf;
use std::time::{Duration, Instant};

use goldtof_system::printable::printable_path;
use goldtof_wire::{
    BLOCK_BYTES, Decoder, Event, Frame, Identity, IdentityError, REQUEST_HITS, REQUEST_IDENTITY,
    REQUEST_READ, REQUEST_TEXT, REQUEST_WRITE, Request, Tally, encode,
};
use thiserror::Error;

use crate::hexadecimal;

/// How often a request is sent before the device is said to be silent.
const TRIES: u32 = 4;
/// How long an answer may take: a frame that is on the line first, and what a USB adapter adds.
const ANSWER_TIME: Duration = Duration::from_millis(400);

/// How many reads in a row have to time out before the line is silent: bytes of a frame follow one another on any
/// line, but a simulated board is as slow as its machine is busy.
const SILENT_READS: u32 = 3;

/// What goes wrong with a device.
#[derive(Debug, Error)]
pub enum DeviceError {
    /// Its port cannot be opened.
    #[error("{port}: {error}")]
    Port {
        /// The port's name.
        port: String,
        /// What the system says.
        error: serialport::Error,
    },
    /// The scene that it has to be of cannot be read.
    #[error("{}: {error}", printable_path(path))]
    Scene {
        /// The scene's file.
        path: PathBuf,
        /// What the system says.
        error: io::Error,
    },
    /// It was built from another scene.
    #[error(
        "the device was built from another scene: its hash begins with {}, and that of {} with {}. Load the \
         bitstream of this scene, or name the scene of this bitstream",
        hexadecimal(found),
        printable_path(path),
        hexadecimal(expected)
    )]
    OtherScene {
        /// The beginning of its scene's SHA-256.
        found: [u8; 8],
        /// The beginning of that of the scene's file.
        expected: [u8; 8],
        /// The file.
        path: PathBuf,
    },
    /// The other end is gone.
    #[error("the device is gone (unplugged, or its line was closed): {0}")]
    Unplugged(io::Error),
    /// It does not answer.
    #[error(
        "the device does not answer ({TRIES} requests, {} ms each): is the baud rate right, and is it this port?",
        ANSWER_TIME.as_millis()
    )]
    Silent,
    /// It has no registers.
    #[error("this build has no registers: emit it with hardware.registers = \"axi4-lite\"")]
    NoRegisters,
    /// It does not hold its scene.
    #[error(
        "the device does not hold its scene's text: emit it with hardware.scene_text = true, or name the \
         scene's file"
    )]
    NoText,
    /// It does not count hits by sample.
    #[error("the device does not count hits by sample: emit it with hardware.sample_counts = true")]
    NoHits,
    /// It refuses.
    #[error("the device refuses address {address:#05x} (AXI response {status})")]
    Refused {
        /// Byte address.
        address: u16,
        /// AXI's response: 2 SLVERR, 3 DECERR.
        status: u8,
    },
    /// It is another device than this program knows.
    #[error(transparent)]
    Identity(#[from] IdentityError),
}

/// A device at the other end of a line, whose `read` gives up after some 100 ms with `TimedOut`.
#[derive(Debug)]
pub struct Device<P> {
    port: P,
    decoder: Decoder,
    /// What came while an answer was awaited.
    events: VecDeque<Event>,
    tag: u8,
    piece: Vec<u8>,
    /// Reads in a row that timed out.
    timed_out: u32,
}

impl<P: Read + Write> Device<P> {
    /// A device of which nothing is known yet.
    pub fn new(port: P) -> Device<P> {
        Device {
            port,
            decoder: Decoder::new(None),
            events: VecDeque::new(),
            tag: 0,
            piece: vec![0; 1 << 16],
            timed_out: 0,
        }
    }

    /// Asks the device what it is; from then on results are read.
    ///
    /// # Errors
    ///
    /// It is gone or silent, or speaks another version of the protocol.
    pub fn identify(&mut self) -> Result<Identity, DeviceError> {
        match self.ask(REQUEST_IDENTITY, 0, 0)? {
            Frame::Identity(_, identity) => {
                let identity = identity?;
                self.decoder.set_layout(identity.layout);
                self.decoder.set_results_of_scan(identity.results_of_scan());
                Ok(identity)
            }
            _ => Err(DeviceError::Silent),
        }
    }

    /// Reads the text of the scene that the device was built from. Its SHA-256 begins with
    /// [`Identity::scene`].
    ///
    /// # Errors
    ///
    /// The device is gone or silent, or does not hold the text.
    pub fn scene_text(&mut self, identity: &Identity) -> Result<Vec<u8>, DeviceError> {
        let mut text = Vec::new();
        for block in 0..u16::from(identity.text_blocks) {
            match self.ask(REQUEST_TEXT, block * BLOCK_BYTES as u16, 0)? {
                Frame::Block(_, bytes) => text.extend(bytes),
                _ => return Err(DeviceError::NoText),
            }
        }
        // The last block ends with zeros.
        text.truncate(text.iter().rposition(|&byte| byte != 0).map_or(0, |last| last + 1));
        if text.is_empty() { Err(DeviceError::NoText) } else { Ok(text) }
    }

    /// Reads how many hits each sample of a chip has had, modulo 2^32, detector by detector. Counts of a
    /// detector are of the same time.
    ///
    /// # Errors
    ///
    /// The device is gone or silent, or does not count them.
    pub fn hits(&mut self, identity: &Identity) -> Result<Vec<u32>, DeviceError> {
        if !identity.counts_samples {
            return Err(DeviceError::NoHits);
        }
        let places = usize::from(identity.detectors) * usize::from(identity.samples_per_chip);
        let mut hits = Vec::new();
        while hits.len() < places {
            match self.ask(REQUEST_HITS, 4 * hits.len() as u16, 0)? {
                Frame::Block(_, bytes) => {
                    let (words, _) = bytes.as_chunks();
                    hits.extend(words.iter().map(|word| u32::from_le_bytes(*word)));
                }
                _ => return Err(DeviceError::NoHits),
            }
        }
        hits.truncate(places);
        Ok(hits)
    }

    /// Reads the register at a byte address.
    ///
    /// # Errors
    ///
    /// The device is gone or silent, refuses, or has no registers.
    pub fn read(&mut self, address: u16) -> Result<u32, DeviceError> {
        self.transfer(REQUEST_READ, address, 0)
    }

    /// Writes the register at a byte address. Where an answer is lost the word is written again.
    ///
    /// # Errors
    ///
    /// The device is gone or silent, refuses, or has no registers.
    pub fn write(&mut self, address: u16, data: u32) -> Result<(), DeviceError> {
        self.transfer(REQUEST_WRITE, address, data).map(drop)
    }

    /// What came next, results and losses; `None` if nothing did before the port's time was over.
    ///
    /// # Errors
    ///
    /// The device is gone; what had come before has been given.
    pub fn next_event(&mut self) -> Result<Option<Event>, DeviceError> {
        if let Some(event) = self.events.pop_front() {
            return Ok(Some(event));
        }
        if let Some(event) = self.decoder.next_event() {
            return Ok(Some(event));
        }
        self.listen()?;
        Ok(self.decoder.next_event())
    }

    /// How much has come, and how much has not.
    pub fn tally(&self) -> Tally {
        self.decoder.tally()
    }

    fn transfer(&mut self, kind: u8, address: u16, data: u32) -> Result<u32, DeviceError> {
        match self.ask(kind, address, data)? {
            Frame::Answer(answer) if answer.status == 0 => Ok(answer.data),
            Frame::Answer(answer) => Err(DeviceError::Refused { address, status: answer.status }),
            _ => Err(DeviceError::NoRegisters),
        }
    }

    /// The answer to a request, which is sent again if none comes. What else comes is kept.
    fn ask(&mut self, kind: u8, address: u16, data: u32) -> Result<Frame, DeviceError> {
        for _ in 0..TRIES {
            // An answer that comes too late is none to the next one.
            self.tag = self.tag.wrapping_add(1);
            let request = Request { kind, tag: self.tag, address };
            self.port.write_all(&encode::request(request, data)).map_err(DeviceError::Unplugged)?;
            self.port.flush().map_err(DeviceError::Unplugged)?;
            let sent = Instant::now();
            while sent.elapsed() < ANSWER_TIME {
                while let Some(event) = self.decoder.next_event() {
                    match event {
                        Event::Frame(Frame::Answer(answer)) if answer.request == request => {
                            return Ok(Frame::Answer(answer));
                        }
                        Event::Frame(Frame::Identity(answered, identity))
                            if answered == request =>
                        {
                            return Ok(Frame::Identity(answered, identity));
                        }
                        Event::Frame(Frame::Block(answered, block)) if answered == request => {
                            return Ok(Frame::Block(answered, block));
                        }
                        other => self.events.push_back(other),
                    }
                }
                self.listen()?;
            }
        }
        Err(DeviceError::Silent)
    }

    /// Takes what the line has.
    fn listen(&mut self) -> Result<(), DeviceError> {
        match self.port.read(&mut self.piece) {
            Ok(0) => Err(DeviceError::Unplugged(io::ErrorKind::UnexpectedEof.into())),
            Ok(count) => {
                self.decoder.push(&self.piece[..count]);
                self.timed_out = 0;
                Ok(())
            }
            Err(error) => match error.kind() {
                io::ErrorKind::Interrupted => Ok(()),
                io::ErrorKind::TimedOut | io::ErrorKind::WouldBlock => {
                    self.timed_out += 1;
                    if self.timed_out.is_multiple_of(SILENT_READS) {
                        self.decoder.silence();
                    }
                    Ok(())
                }
                _ => Err(DeviceError::Unplugged(error)),
            },
        }
    }
}
