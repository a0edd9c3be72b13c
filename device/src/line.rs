use std::fs;
use std::path::PathBuf;
use std::time::Duration;

use goldtof_system::digest::sha256;
use goldtof_wire::Identity;
use serialport::SerialPort;

use crate::{Device, DeviceError};

/// How long a port's `read` waits.
const READ_TIME: Duration = Duration::from_millis(100);

/// Where a device is, and which one it has to be.
#[derive(Debug, Clone)]
pub struct Line {
    /// Serial port: `/dev/ttyUSB1`, or a pseudo-terminal of a simulated board.
    pub port: String,
    /// Bits per second.
    pub baud: u32,
    /// The scene that the device was built from; another device is refused.
    pub scene: Option<PathBuf>,
}

impl Line {
    /// The device, which has said what it is.
    ///
    /// # Errors
    ///
    /// The port cannot be opened, or the scene cannot be read; the device is silent, or is another scene's.
    pub fn open(&self) -> Result<(Device<Box<dyn SerialPort>>, Identity), DeviceError> {
        let expected = match &self.scene {
            Some(path) => {
                let read = fs::read(path);
                let told = |error| DeviceError::Scene { path: path.clone(), error };
                Some((scene_hash(&read.map_err(told)?), path))
            }
            None => None,
        };
        let port = serialport::new(&self.port, self.baud).timeout(READ_TIME).open();
        let told = |error| DeviceError::Port { port: self.port.clone(), error };
        let mut device = Device::new(port.map_err(told)?);
        let identity = device.identify()?;
        match expected {
            Some((expected, path)) if expected != identity.scene => {
                let (found, path) = (identity.scene, path.clone());
                Err(DeviceError::OtherScene { found, expected, path })
            }
            _ => Ok((device, identity)),
        }
    }
}

/// The first eight bytes of the SHA-256 of a scene's text.
pub fn scene_hash(text: &[u8]) -> [u8; 8] {
    let digits = sha256(text);
    std::array::from_fn(|k| {
        // It is digits, two for each byte.
        u8::from_str_radix(&digits[2 * k..2 * k + 2], 16).unwrap_or_default()
    })
}

/// Bytes as hexadecimal digits.
pub fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}
