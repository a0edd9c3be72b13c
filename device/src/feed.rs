use std::io::{self, Read, Write};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use goldtof_wire::{Event, Identity, Tally};

use crate::{Device, DeviceError};

/// How long to wait before a port that is gone is tried again.
const AGAIN: Duration = Duration::from_millis(300);

/// What a line has to tell.
#[derive(Debug)]
pub struct News {
    /// When it came, in seconds since 1970.
    pub time_s: f64,
    /// How much has come until then, and how much has not.
    pub tally: Tally,
    /// What came.
    pub what: What,
}

/// What came.
#[derive(Debug)]
pub enum What {
    /// Results, or that some are missing.
    Event(Event),
    /// The device is gone, for this reason. Without a way to open it again this is the last news.
    Gone(DeviceError),
    /// It is there again.
    Back,
}

/// Reads a device in a thread of its own. A terminal keeps 4 kB, which are 14 ms at 3 Mbaud: whoever draws, writes
/// or computes must not keep the line waiting.
#[derive(Debug)]
pub struct Feed {
    news: Receiver<News>,
    stop: Arc<AtomicBool>,
    requests: Sender<Asked>,
}

/// A register to read, or to write with data; and where the answer goes.
struct Asked {
    address: u16,
    data: Option<u32>,
    answer: Sender<Result<u32, DeviceError>>,
}

/// Opens the same device again.
pub type Reopen<P> = Box<dyn FnMut() -> Result<(Device<P>, Identity), DeviceError> + Send>;

impl Feed {
    /// Begins to read. Where the device is unplugged, `reopen` is asked for it until it is there again.
    pub fn start<P>(device: Device<P>, identity: Identity, reopen: Option<Reopen<P>>) -> Feed
    where
        P: Read + Write + Send + 'static,
    {
        let (sender, news) = channel();
        let (requests, asked) = channel();
        let stop = Arc::new(AtomicBool::new(false));
        let stopped = Arc::clone(&stop);
        thread::spawn(move || {
            let reader = Reader { sender, asked, stopped, identity, before: Tally::default() };
            reader.run(device, reopen);
        });
        Feed { news, stop, requests }
    }

    /// What came next, if anything does within this time. After [`What::Gone`] without a way back nothing does.
    pub fn next(&self, within: Duration) -> Option<News> {
        match self.news.recv_timeout(within) {
            Ok(news) => Some(news),
            Err(RecvTimeoutError::Timeout) => None,
            Err(RecvTimeoutError::Disconnected) => {
                thread::sleep(within);
                None
            }
        }
    }
}

impl Feed {
    /// Reads the register at a byte address; results that come meanwhile are kept.
    ///
    /// # Errors
    ///
    /// As [`Device::read`].
    pub fn read(&self, address: u16) -> Result<u32, DeviceError> {
        self.ask(address, None)
    }

    /// Writes the register at a byte address.
    ///
    /// # Errors
    ///
    /// As [`Device::write`].
    pub fn write(&self, address: u16, data: u32) -> Result<(), DeviceError> {
        self.ask(address, Some(data)).map(drop)
    }

    fn ask(&self, address: u16, data: Option<u32>) -> Result<u32, DeviceError> {
        let gone = || DeviceError::Unplugged(io::ErrorKind::BrokenPipe.into());
        let (answer, answered) = channel();
        self.requests.send(Asked { address, data, answer }).map_err(|_| gone())?;
        answered.recv().map_err(|_| gone())?
    }
}

impl Drop for Feed {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
    }
}

/// The thread that reads.
struct Reader {
    sender: Sender<News>,
    asked: Receiver<Asked>,
    stopped: Arc<AtomicBool>,
    identity: Identity,
    /// What came before the device was last opened.
    before: Tally,
}

impl Reader {
    fn run<P: Read + Write>(mut self, mut device: Device<P>, mut reopen: Option<Reopen<P>>) {
        while !self.stopped.load(Ordering::Relaxed) {
            for Asked { address, data, answer } in self.asked.try_iter() {
                let told = match data {
                    Some(data) => device.write(address, data).map(|()| data),
                    None => device.read(address),
                };
                // Who asked may be gone.
                let _ = answer.send(told);
            }
            let what = match device.next_event() {
                Ok(None) => continue,
                Ok(Some(event)) => What::Event(event),
                Err(error) => What::Gone(error),
            };
            let is_gone = matches!(what, What::Gone(_));
            let tally = sum(self.before, device.tally());
            if !self.tell(tally, what) {
                return;
            }
            if !is_gone {
                continue;
            }
            self.before = tally;
            let Some(found) = reopen.as_mut().and_then(|reopen| self.open_again(reopen)) else {
                return;
            };
            device = found;
            self.tell(tally, What::Back);
        }
    }

    /// The device, once it is there again; none if nobody waits for it.
    fn open_again<P>(&self, reopen: &mut Reopen<P>) -> Option<Device<P>> {
        while !self.stopped.load(Ordering::Relaxed) {
            thread::sleep(AGAIN);
            // Another one at this port is not waited for: it may go again.
            match reopen() {
                Ok((device, identity)) if identity == self.identity => return Some(device),
                Ok(_) | Err(_) => {}
            }
        }
        None
    }

    /// Whether anybody listens.
    fn tell(&self, tally: Tally, what: What) -> bool {
        let now = SystemTime::now().duration_since(UNIX_EPOCH);
        let time_s = now.map_or(0.0, |time| time.as_secs_f64());
        self.sender.send(News { time_s, tally, what }).is_ok()
    }
}

/// What came of a device that was opened twice.
fn sum(a: Tally, b: Tally) -> Tally {
    Tally {
        bytes: a.bytes + b.bytes,
        frames: a.frames + b.frames,
        results: a.results + b.results,
        doubled: a.doubled + b.doubled,
        torn: a.torn + b.torn,
        stray_bytes: a.stray_bytes + b.stray_bytes,
        lost_frames: a.lost_frames + b.lost_frames,
        lost_results: a.lost_results + b.lost_results,
        uncertain: a.uncertain + b.uncertain,
        dropped: a.dropped + b.dropped,
    }
}
