//! Claims of output paths, so that only one process at a time writes to a file.

use std::ffi::OsString;
use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use crate::{FileError, Memory};

/// Claimed target file. The claim ends when the value is dropped or the process ends.
#[derive(Debug)]
pub struct Output {
    path: PathBuf,
    /// `None` in memory.
    lock: Option<File>,
    has_values: bool,
    memory: Option<Memory>,
}

impl Output {
    /// Claims `path`, or the target of a symbolic link; an existing file is unchanged. Fails while another process
    /// holds the claim, if the folder does not exist or cannot be written, or if `path` exists and is not a regular
    /// file: renaming a result to a device or a pipe would destroy it.
    pub fn claim(path: impl AsRef<Path>) -> Result<Self, FileError> {
        let path = target(path.as_ref())?;
        for path in [beside(&path, ".lock"), beside(&path, ".part")] {
            check_regular(&path)?;
        }
        let lock_path = beside(&path, ".lock");
        // The last holder may unlink the lock file after this process has opened it, and another process may then
        // create and lock a new one. The lock is valid only if its file still has the name.
        for _ in 0..100 {
            let lock = OpenOptions::new()
                .write(true)
                .create(true)
                .truncate(false)
                .open(&lock_path)
                .map_err(|source| FileError::Io { action: "create", path: lock_path.clone(), source })?;
            match lock.try_lock() {
                Ok(()) if is_same_file(&lock, &lock_path) => {
                    return Ok(Self { path, lock: Some(lock), has_values: true, memory: None });
                }
                Ok(()) => continue,
                Err(TryLockError::WouldBlock) => break,
                Err(TryLockError::Error(source)) => {
                    return Err(FileError::Io { action: "lock", path: lock_path, source });
                }
            }
        }
        Err(FileError::Busy { path })
    }

    /// Claims `NAME` + `suffix` beside `path` instead of `path` itself, for a process that does part of the work. Fails
    /// like [`claim`](Self::claim), and if `path` itself could not be claimed later.
    ///
    /// # Errors
    /// A claim held by another process; paths at which no file can exist.
    pub fn claim_beside(path: &Path, suffix: &str) -> Result<Self, FileError> {
        Self::claim(beside(&target(path)?, suffix))
    }

    /// Creates a target in memory. Nothing is written to the disk; an [`Archive`](crate::Archive) puts its variables
    /// into `memory`. The path is empty.
    pub fn memory(memory: &Memory) -> Self {
        Self { path: PathBuf::new(), lock: None, has_values: true, memory: Some(memory.clone()) }
    }

    /// Returns the memory if it is the target.
    pub fn in_memory(&self) -> Option<&Memory> {
        self.memory.as_ref()
    }

    /// Restricts the target to the layout of a file: an [`Archive`](crate::Archive) then has all names, shapes, units,
    /// attributes and coordinates, but no values and no checksum.
    #[must_use]
    pub fn layout(mut self) -> Self {
        self.has_values = false;
        self
    }

    pub(crate) fn has_values(&self) -> bool {
        self.has_values
    }

    /// Returns the path of the target.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Returns the path `NAME.part` beside the target.
    pub fn part(&self) -> PathBuf {
        self.beside(".part")
    }

    /// Checks that files named `NAME` + `suffix` can exist, so that long work does not fail because of them.
    ///
    /// # Errors
    /// A name that is too long for the file system.
    pub fn check_beside(&self, suffixes: &[&str]) -> Result<(), FileError> {
        let too_long = |suffix: &&&str| {
            fs::symlink_metadata(self.beside(suffix)).is_err_and(|error| error.kind() == io::ErrorKind::InvalidFilename)
        };
        let Some(suffix) = suffixes.iter().find(too_long) else { return Ok(()) };
        let found = self.path.file_name().unwrap_or_default().len();
        let reason = format!(
            "the name has {found} bytes, and {} with {suffix}, the name of a file beside it, which is too long here; \
             it must be shorter",
            found + suffix.len()
        );
        Err(FileError::Target { path: self.path.clone(), reason })
    }

    /// Returns the path `NAME` + `suffix` beside the target, for further files under this claim.
    pub fn beside(&self, suffix: &str) -> PathBuf {
        beside(&self.path, suffix)
    }

    /// Replaces the target with the bytes that `write` produces: they are written to the part file, synced, and
    /// renamed. After an error an older file is unchanged.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn write(&self, write: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>) -> Result<(), FileError> {
        replace(&self.path, write)
    }

    /// Syncs the part file to the disk and renames it to the target.
    pub(crate) fn publish(&self) -> Result<(), FileError> {
        publish(&self.part(), &self.path)
    }
}

/// Replaces the file `path` with the bytes that `write` produces: they are written to `NAME.part`, synced, and renamed.
/// After an error an older file is unchanged. Use [`Output::write`] for the target itself, and this function for files
/// beside it.
///
/// # Errors
/// A file that cannot be written.
pub fn replace(path: &Path, write: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>) -> Result<(), FileError> {
    let path = &followed(path)?;
    let part = beside(path, ".part");
    check_replaceable(path)?;
    check_regular(&part)?;
    let written = File::create(&part).map(BufWriter::new).and_then(|mut file| {
        write(&mut file)?;
        file.flush()
    });
    let published = match written {
        Ok(()) => publish(&part, path),
        Err(source) => Err(FileError::Io { action: "write", path: part.clone(), source }),
    };
    published.inspect_err(|_| {
        let _ = fs::remove_file(&part);
    })
}

/// Syncs the part file to the disk and renames it to the target.
fn publish(part: &Path, path: &Path) -> Result<(), FileError> {
    let io = |action, path: &Path| {
        let path = path.to_path_buf();
        move |source| FileError::Io { action, path, source }
    };
    // The new file has the permissions of the old one.
    if let Ok(old) = fs::metadata(path) {
        fs::set_permissions(part, old.permissions()).map_err(io("set the permissions of", part))?;
    }
    File::open(part).and_then(|file| file.sync_all()).map_err(io("sync", part))?;
    fs::rename(part, path).map_err(io("rename to", path))?;
    sync_folder(folder(path)).map_err(io("sync", folder(path)))
}

impl Drop for Output {
    fn drop(&mut self) {
        let Some(lock) = &self.lock else { return };
        // Unlink before unlocking: a process waiting for the lock then finds the name gone and starts over.
        let _ = fs::remove_file(beside(&self.path, ".lock"));
        let _ = lock.unlock();
    }
}

/// Returns the path of a file to be written, which need not exist. A symbolic link is replaced by its target.
///
/// # Errors
/// A folder, device, pipe or read-only file; a symbolic link without a target; a path in no folder.
pub fn target(path: &Path) -> Result<PathBuf, FileError> {
    let refuse = |path: &Path, reason: &str| FileError::Target { path: path.into(), reason: reason.into() };
    if path.file_name().is_none() || path.is_dir() {
        return Err(refuse(path, "it is a folder; it must be a file name"));
    }
    let path = followed(path)?;
    check_replaceable(&path)?;
    let folder = folder(&path);
    if !folder.is_dir() {
        return Err(refuse(&path, &format!("there is no folder {}", folder.display())));
    }
    Ok(path)
}

/// Returns the path itself, or the target of a symbolic link.
fn followed(path: &Path) -> Result<PathBuf, FileError> {
    match fs::symlink_metadata(path) {
        Ok(metadata) if metadata.file_type().is_symlink() => fs::canonicalize(path).map_err(|_| {
            let reason = "it is a symbolic link that leads nowhere; it must lead to a file, or not exist";
            FileError::Target { path: path.into(), reason: reason.into() }
        }),
        _ => Ok(path.into()),
    }
}

/// Returns an error for an existing object that is not a regular file or is read-only.
fn check_replaceable(path: &Path) -> Result<(), FileError> {
    check_regular(path)?;
    if fs::metadata(path).is_ok_and(|metadata| metadata.permissions().readonly()) {
        let reason = "it is read-only; it must be writable, or another name".into();
        return Err(FileError::Target { path: path.into(), reason });
    }
    Ok(())
}

/// Returns an error for an existing object that is not a regular file.
fn check_regular(path: &Path) -> Result<(), FileError> {
    let Ok(metadata) = fs::symlink_metadata(path) else { return Ok(()) };
    if metadata.is_file() {
        return Ok(());
    }
    let reason = format!("it is {}; it must be a regular file, or not exist", gfmd_topography::input::kind(&metadata));
    Err(FileError::Target { path: path.into(), reason })
}

fn beside(path: &Path, suffix: &str) -> PathBuf {
    let mut name = path.file_name().map(OsString::from).unwrap_or_default();
    name.push(suffix);
    path.with_file_name(name)
}

/// Returns the folder of a path.
pub fn folder(path: &Path) -> &Path {
    path.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Returns true if both names lead to the same existing file, also by links.
pub fn is_one_file(one: &Path, other: &Path) -> bool {
    gfmd_topography::Input::open(one).and_then(|one| one.handle()).is_ok_and(|one| is_same_file(&one, other))
}

#[cfg(unix)]
pub(crate) fn is_same_file(open: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let identity = |metadata: fs::Metadata| (metadata.dev(), metadata.ino());
    matches!((open.metadata().map(identity), fs::metadata(path).map(identity)), (Ok(a), Ok(b)) if a == b)
}

#[cfg(not(unix))]
pub(crate) fn is_same_file(_: &File, path: &Path) -> bool {
    path.exists() // An open file cannot be unlinked on this system.
}

/// Syncs a folder to the disk, so that a new or renamed file survives a crash.
///
/// # Errors
/// A folder that cannot be synced.
#[cfg(unix)]
pub fn sync_folder(folder: &Path) -> io::Result<()> {
    File::open(folder)?.sync_all()
}

#[cfg(not(unix))]
pub fn sync_folder(_: &Path) -> io::Result<()> {
    Ok(())
}

#[cfg(all(test, unix))]
mod tests {
    use std::os::unix::fs::{FileTypeExt, symlink};
    use std::os::unix::net::UnixListener;

    use super::*;

    /// A path that is not a regular file is unchanged, as a target and under the names beside it.
    #[test]
    fn special_files_are_refused_and_stay() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        let _socket = UnixListener::bind(at("socket")).unwrap();
        fs::create_dir(at("folder")).unwrap();
        symlink(at("nowhere"), at("dangling")).unwrap();
        symlink(at("socket"), at("link")).unwrap();
        for suffix in [".lock", ".part"] {
            symlink(at("socket"), at(&format!("result.h5{suffix}"))).unwrap();
            let refused = Output::claim(at("result.h5"));
            assert!(matches!(refused, Err(FileError::Target { .. })), "{suffix}");
            fs::remove_file(at(&format!("result.h5{suffix}"))).unwrap();
        }
        for name in ["socket", "folder", "dangling", "link"] {
            let claimed = Output::claim(at(name));
            assert!(matches!(claimed, Err(FileError::Target { .. })), "{name}: {claimed:?}");
            let written = replace(&at(name), |file| file.write_all(b"text"));
            assert!(matches!(written, Err(FileError::Target { .. })), "{name}: {written:?}");
        }
        assert!(fs::symlink_metadata(at("socket")).unwrap().file_type().is_socket());
        assert!(fs::symlink_metadata(at("dangling")).unwrap().is_symlink() && at("folder").is_dir());
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 4);
    }

    #[test]
    fn a_link_to_a_file_stays_a_link() {
        let folder = tempfile::tempdir().unwrap();
        let (file, link) = (folder.path().join("file"), folder.path().join("link"));
        fs::write(&file, "old").unwrap();
        symlink(&file, &link).unwrap();
        replace(&link, |target| target.write_all(b"new")).unwrap();
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(fs::read_to_string(&file).unwrap(), "new");
        Output::claim(&link).unwrap().write(|target| target.write_all(b"newer")).unwrap();
        assert_eq!(fs::read_to_string(&file).unwrap(), "newer");
    }
}
