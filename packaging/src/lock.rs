//! One `cargo xtask` at a time in a target directory.

use std::fs::{File, TryLockError};
use std::path::Path;

use anyhow::{Context, Result};

use crate::process;

/// Waits until no other program holds the lock of a folder, and holds it as long as the file lives.
///
/// # Errors
/// When the file of the lock cannot be made or locked.
pub fn hold(folder: &Path) -> Result<File> {
    std::fs::create_dir_all(folder).with_context(|| format!("cannot make {}", folder.display()))?;
    let name = folder.join("xtask.lock");
    let lock = File::create(&name).with_context(|| format!("cannot make {}", name.display()))?;
    match lock.try_lock() {
        Ok(()) => return Ok(lock),
        Err(TryLockError::WouldBlock) => (),
        Err(TryLockError::Error(error)) => {
            return Err(error).with_context(|| format!("cannot lock {}", name.display()));
        }
    }
    process::with_progress(&format!("waiting for another cargo xtask in {}", folder.display()), || lock.lock())?;
    Ok(lock)
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc::{RecvTimeoutError, channel};
    use std::time::Duration;

    use super::*;

    #[test]
    fn a_second_holder_waits_for_the_first() -> Result<()> {
        let folder = crate::files::scratch("lock");
        let first = hold(&folder)?;
        let (sender, receiver) = channel();
        let second = std::thread::spawn({
            let folder = folder.clone();
            move || sender.send(hold(&folder).is_ok())
        });
        assert_eq!(receiver.recv_timeout(Duration::from_millis(200)), Err(RecvTimeoutError::Timeout));
        drop(first);
        assert_eq!(receiver.recv_timeout(Duration::from_secs(60)), Ok(true));
        assert!(second.join().is_ok_and(|sent| sent.is_ok()));
        std::fs::remove_dir_all(&folder)?;
        Ok(())
    }
}
