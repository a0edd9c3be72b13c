//! What people read: plots, tables, the report page.

pub mod chart;
pub mod page;
pub mod plot;

use std::fmt::Write as _;
use std::io::Write as _;
use std::path::Path;

use anyhow::Context as _;

use crate::scene::Scene;

/// The counts of a scan as CSV: number of the measurement, phase step, its
/// calibrated distance, count.
pub fn counts_csv(scene: &Scene, distances_m: &[f64], counts: &[i64]) -> String {
    let mut text = "measurement,phase_step,distance_m,count\n".to_owned();
    for (j, (distance_m, count)) in distances_m.iter().zip(counts).enumerate() {
        let step = scene.scan.step(j as u64);
        let _ = writeln!(text, "{j},{step},{distance_m:.6},{count}");
    }
    text
}

/// Writes a file under its name only when it is whole.
///
/// # Errors
/// When it cannot be written; the message names it.
pub fn write_file(path: &Path, text: &str) -> anyhow::Result<()> {
    let write = || -> std::io::Result<()> {
        let folder = path.parent().filter(|f| !f.as_os_str().is_empty());
        let mut file = tempfile::NamedTempFile::new_in(folder.unwrap_or(Path::new(".")))?;
        file.write_all(text.as_bytes())?;
        publish(file, path)
    };
    write().with_context(|| format!("{}: cannot write the file", path.display()))
}

/// Gives a finished temporary file its name, and the rights of a usual file:
/// temporary files are private.
pub fn publish(file: tempfile::NamedTempFile, path: &Path) -> std::io::Result<()> {
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt as _;
        let readable = std::fs::Permissions::from_mode(0o644);
        std::fs::set_permissions(file.path(), readable)?;
    }
    file.persist(path)?;
    Ok(())
}
