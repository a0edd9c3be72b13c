//! The host's end of the serial line of a sensor's bridge (docs/wire.md): [`Device`] asks and listens,
//! [`Recorder`] writes counts as CSV, [`Watch`] says how it goes. Any `Read` and `Write` is a line: a serial
//! port, a pseudo-terminal, a socket.

mod device;
mod record;
mod watch;

pub use device::{Device, DeviceError};
pub use record::{RecordError, Recorder, Sink};
pub use watch::Watch;
