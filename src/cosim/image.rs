//! A shared library in memory: the bytes that were checked are those that run.
//!
//! The loader takes a file name. A file in the cache could be another one by the
//! time it is loaded, so its checked bytes go into an anonymous file without a
//! name in any folder, sealed against changes (`memfd_create(2)`), and are loaded
//! from there.

use std::fs::File;
use std::io::{self, Write as _};
use std::os::fd::{AsRawFd as _, OwnedFd};
use std::path::PathBuf;
use std::sync::atomic::{AtomicU32, Ordering};

use rustix::fs::{MemfdFlags, SealFlags, fcntl_add_seals, memfd_create};

/// Numbers the images of this process.
static NEXT: AtomicU32 = AtomicU32::new(0);

/// A library's bytes, which nothing can change any more.
#[derive(Debug)]
pub struct Image {
    file: File,
    number: u32,
}

impl Image {
    /// Seals a copy of `bytes`.
    ///
    /// # Errors
    /// When the system has no memory for it, or permits no code there.
    pub fn new(bytes: &[u8]) -> io::Result<Image> {
        let flags = MemfdFlags::CLOEXEC | MemfdFlags::ALLOW_SEALING;
        // Linux before 6.3 does not know that a file may say that it holds code.
        let memory: OwnedFd = memfd_create("goldtof-model", flags | MemfdFlags::EXEC)
            .or_else(|_| memfd_create("goldtof-model", flags))?;
        let mut file = File::from(memory);
        file.write_all(bytes)?;
        let all = SealFlags::WRITE | SealFlags::GROW | SealFlags::SHRINK | SealFlags::SEAL;
        fcntl_add_seals(&file, all)?;
        let number = NEXT.fetch_add(1, Ordering::Relaxed);
        Ok(Image { file, number })
    }

    /// A name for the loader, good as long as the image lives.
    ///
    /// The loader takes two libraries of one name for one library, also when the
    /// first is no longer wanted, and file numbers are used again. So the image's
    /// own number is written into the path, in slashes that mean nothing: each bit
    /// as `/.` or `//.`.
    pub fn path(&self) -> PathBuf {
        let bits = u32::BITS - self.number.leading_zeros();
        let number: String = (0..bits)
            .map(|bit| ["/.", "//."][(self.number >> bit & 1) as usize])
            .collect();
        PathBuf::from(format!("/proc/self/fd{number}/{}", self.file.as_raw_fd()))
    }
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;
    use std::fs::{self, OpenOptions};

    use super::*;

    #[test]
    fn an_image_holds_its_bytes_and_takes_no_others() {
        let image = Image::new(b"checked").unwrap();
        assert_eq!(fs::read(image.path()).unwrap(), b"checked");
        let opened = OpenOptions::new().write(true).open(image.path());
        let changed = opened.and_then(|mut file| file.write_all(b"planted"));
        assert!(changed.is_err());
        assert!(image.file.set_len(0).is_err());
        assert_eq!(fs::read(image.path()).unwrap(), b"checked");
    }

    #[test]
    fn images_one_after_another_have_names_of_their_own() {
        let mut names = HashSet::new();
        for number in 0..100_u32 {
            let image = Image::new(&number.to_le_bytes()).unwrap();
            assert!(names.insert(image.path().into_os_string()), "{number}");
            assert_eq!(fs::read(image.path()).unwrap(), number.to_le_bytes());
        }
    }
}
