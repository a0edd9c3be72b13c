//! A program in memory: the bytes that were checked are those that run.
//!
//! A program is started by its file's name. A file in the cache could be another one
//! by then, so its checked bytes go into an anonymous file without a name in any
//! folder, sealed against changes (`memfd_create(2)`), and are started from there.

use std::fs::File;
use std::io::{self, Write as _};
use std::os::fd::{AsRawFd as _, OwnedFd};
use std::path::PathBuf;

use rustix::fs::{MemfdFlags, SealFlags, fcntl_add_seals, memfd_create};

/// A program's bytes, which nothing can change any more.
#[derive(Debug)]
pub struct ProgramImage {
    file: File,
}

impl ProgramImage {
    /// Seals a copy of `bytes`.
    ///
    /// # Errors
    /// When the system has no memory for it, or permits no code there.
    pub fn new(bytes: &[u8]) -> io::Result<ProgramImage> {
        let flags = MemfdFlags::CLOEXEC | MemfdFlags::ALLOW_SEALING;
        // Linux before 6.3 does not know that a file may say that it holds code.
        let memory: OwnedFd = memfd_create("goldtof-model", flags | MemfdFlags::EXEC)
            .or_else(|_| memfd_create("goldtof-model", flags))?;
        let mut file = File::from(memory);
        file.write_all(bytes)?;
        let all = SealFlags::WRITE | SealFlags::GROW | SealFlags::SHRINK | SealFlags::SEAL;
        fcntl_add_seals(&file, all)?;
        Ok(ProgramImage { file })
    }

    /// A name for this process and for a child of it that is about to become the
    /// program; good as long as the image lives.
    pub fn path(&self) -> PathBuf {
        PathBuf::from(format!("/proc/self/fd/{}", self.file.as_raw_fd()))
    }
}

#[cfg(test)]
mod tests {
    use std::fs::{self, OpenOptions};

    use super::*;

    #[test]
    fn an_image_holds_its_bytes_and_takes_no_others() {
        let image = ProgramImage::new(b"checked").unwrap();
        assert_eq!(fs::read(image.path()).unwrap(), b"checked");
        let opened = OpenOptions::new().write(true).open(image.path());
        let changed = opened.and_then(|mut file| file.write_all(b"planted"));
        assert!(changed.is_err());
        assert!(image.file.set_len(0).is_err());
        assert_eq!(fs::read(image.path()).unwrap(), b"checked");
    }
}
