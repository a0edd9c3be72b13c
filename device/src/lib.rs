//! The host's end of the serial line of a sensor's bridge (docs/wire.md): [`Line`] opens a port, [`Device`] asks
//! and listens, [`Feed`] does so in a thread of its own, [`Scans`] puts counts together to scans, [`Ranging`]
//! ranges them, [`Recorder`] writes counts as CSV, [`Watch`] says how it goes. Any `Read` and `Write` is a line: a
//! serial port, a pseudo-terminal, a socket.

mod device;
mod feed;
mod line;
mod ranging;
mod record;
mod scans;
mod watch;

pub use device::{Device, DeviceError};
pub use feed::{Feed, News, Reopen, What};
pub use line::{Line, hexadecimal, scene_hash};
pub use ranging::{Ranger, Ranging};
pub use record::{Losses, RecordError, Recorder, Sink};
pub use scans::{DetectorScan, Largest, PlacedCount, ResultOrder, Scan, Scans};
pub use watch::{Report, Watch};
