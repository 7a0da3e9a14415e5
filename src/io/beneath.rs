//! A folder held open, and what lies in it by name: no link is followed, and nothing but regular files is opened.
//!
//! Where several users write to a folder, any name in it may have become a link, or a pipe that waits for ever, since it was last looked at. On Unix each name is
//! looked up in the folder that was opened before it (`openat` with `O_NOFOLLOW`), so that there is no moment between the look and the use. Elsewhere a
//! name is looked at first.

use std::ffi::{OsStr, OsString};
use std::fs::File;
use std::io;
use std::path::Path;

/// What a name is of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// A regular file.
    File,
    /// A folder.
    Folder,
    /// A symbolic link.
    Link,
    /// A pipe, a socket, a device.
    Other,
}

/// What a file is opened for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Access {
    /// To be read.
    Read,
    /// To be added to; made where it is not there.
    Append,
    /// To be locked, read and written; made where it is not there.
    Lock,
}

#[cfg(unix)]
mod system {
    use super::{Access, File, Kind, OsStr, OsString, Path, io};
    use rustix::fs::{self, AtFlags, FileType, Mode, OFlags};
    use std::os::fd::OwnedFd;
    use std::os::unix::ffi::OsStrExt;
    use std::os::unix::fs::MetadataExt;

    /// Linux needs no right to list a folder in order to open what is in it.
    #[cfg(target_os = "linux")]
    const LOOK: OFlags = OFlags::PATH;
    #[cfg(not(target_os = "linux"))]
    const LOOK: OFlags = OFlags::RDONLY;

    pub(crate) struct Folder(OwnedFd);

    impl Folder {
        /// The folder that somebody named: links are followed.
        pub(crate) fn named(path: &Path) -> io::Result<Self> {
            Ok(Self(fs::open(path, LOOK | OFlags::DIRECTORY | OFlags::CLOEXEC, Mode::empty())?))
        }

        /// A folder in this one.
        pub(crate) fn enter(&self, name: &OsStr) -> io::Result<Self> {
            let flags = LOOK | OFlags::DIRECTORY | OFlags::NOFOLLOW | OFlags::CLOEXEC;
            Ok(Self(fs::openat(&self.0, name, flags, Mode::empty())?))
        }

        pub(crate) fn make(&self, name: &OsStr) -> io::Result<()> {
            Ok(fs::mkdirat(&self.0, name, Mode::from_raw_mode(0o777))?)
        }

        /// A regular file; one that is written to has no other name, which might be another's.
        pub(crate) fn open(&self, name: &OsStr, access: Access) -> io::Result<File> {
            let flags = match access {
                Access::Read => OFlags::RDONLY,
                Access::Append => OFlags::WRONLY | OFlags::APPEND | OFlags::CREATE,
                Access::Lock => OFlags::RDWR | OFlags::CREATE,
            };
            // A pipe without its other end does not wait.
            let flags = flags | OFlags::NOFOLLOW | OFlags::NONBLOCK | OFlags::NOCTTY | OFlags::CLOEXEC;
            let file = File::from(fs::openat(&self.0, name, flags, Mode::from_raw_mode(0o666))?);
            let meta = file.metadata()?;
            if !meta.is_file() {
                return Err(io::Error::new(io::ErrorKind::InvalidInput, "not a regular file"));
            }
            if access != Access::Read && meta.nlink() > 1 {
                let text = "the file has other names (hard links), which would be written to as well";
                return Err(io::Error::new(io::ErrorKind::InvalidInput, text));
            }
            Ok(file)
        }

        /// A file that was not there.
        pub(crate) fn create_new(&self, name: &OsStr) -> io::Result<File> {
            let flags = OFlags::WRONLY | OFlags::CREATE | OFlags::EXCL | OFlags::NOFOLLOW | OFlags::CLOEXEC;
            Ok(File::from(fs::openat(&self.0, name, flags, Mode::from_raw_mode(0o666))?))
        }

        pub(crate) fn rename(&self, from: &OsStr, to: &OsStr) -> io::Result<()> {
            Ok(fs::renameat(&self.0, from, &self.0, to)?)
        }

        pub(crate) fn remove(&self, name: &OsStr) -> io::Result<()> {
            Ok(fs::unlinkat(&self.0, name, AtFlags::empty())?)
        }

        /// Takes an empty folder away.
        pub(crate) fn remove_folder(&self, name: &OsStr) -> io::Result<()> {
            Ok(fs::unlinkat(&self.0, name, AtFlags::REMOVEDIR)?)
        }

        pub(crate) fn kind(&self, name: &OsStr) -> io::Result<Kind> {
            let stat = fs::statat(&self.0, name, AtFlags::SYMLINK_NOFOLLOW)?;
            Ok(match FileType::from_raw_mode(stat.st_mode) {
                FileType::RegularFile => Kind::File,
                FileType::Directory => Kind::Folder,
                FileType::Symlink => Kind::Link,
                _ => Kind::Other,
            })
        }

        pub(crate) fn list(&self) -> io::Result<Vec<OsString>> {
            let flags = OFlags::RDONLY | OFlags::DIRECTORY | OFlags::CLOEXEC;
            let readable = fs::openat(&self.0, c".", flags, Mode::empty())?;
            let mut names = Vec::new();
            for entry in fs::Dir::new(readable)? {
                let entry = entry?;
                let name = OsStr::from_bytes(entry.file_name().to_bytes());
                if name != "." && name != ".." {
                    names.push(name.to_owned());
                }
            }
            Ok(names)
        }
    }
}

#[cfg(not(unix))]
mod system {
    use super::{Access, File, Kind, OsStr, OsString, Path, io};
    use std::fs::{self, OpenOptions};
    use std::path::PathBuf;

    pub(crate) struct Folder(PathBuf);

    impl Folder {
        pub(crate) fn named(path: &Path) -> io::Result<Self> {
            if fs::metadata(path)?.is_dir() {
                Ok(Self(path.to_owned()))
            } else {
                Err(io::ErrorKind::NotADirectory.into())
            }
        }

        pub(crate) fn enter(&self, name: &OsStr) -> io::Result<Self> {
            match self.kind(name)? {
                Kind::Folder => Ok(Self(self.0.join(name))),
                _ => Err(io::ErrorKind::NotADirectory.into()),
            }
        }

        pub(crate) fn make(&self, name: &OsStr) -> io::Result<()> {
            fs::create_dir(self.0.join(name))
        }

        pub(crate) fn open(&self, name: &OsStr, access: Access) -> io::Result<File> {
            let there = self.kind(name);
            if there.as_ref().is_ok_and(|kind| *kind != Kind::File) {
                return Err(io::Error::new(io::ErrorKind::InvalidInput, "not a regular file"));
            }
            let mut options = OpenOptions::new();
            match access {
                Access::Read => options.read(true),
                Access::Append => options.append(true).create(true),
                Access::Lock => options.read(true).write(true).create(true).truncate(false),
            };
            options.open(self.0.join(name))
        }

        pub(crate) fn create_new(&self, name: &OsStr) -> io::Result<File> {
            OpenOptions::new().write(true).create_new(true).open(self.0.join(name))
        }

        pub(crate) fn rename(&self, from: &OsStr, to: &OsStr) -> io::Result<()> {
            fs::rename(self.0.join(from), self.0.join(to))
        }

        pub(crate) fn remove(&self, name: &OsStr) -> io::Result<()> {
            fs::remove_file(self.0.join(name))
        }

        pub(crate) fn remove_folder(&self, name: &OsStr) -> io::Result<()> {
            fs::remove_dir(self.0.join(name))
        }

        pub(crate) fn kind(&self, name: &OsStr) -> io::Result<Kind> {
            let kind = fs::symlink_metadata(self.0.join(name))?.file_type();
            Ok(match kind {
                kind if kind.is_symlink() => Kind::Link,
                kind if kind.is_dir() => Kind::Folder,
                kind if kind.is_file() => Kind::File,
                _ => Kind::Other,
            })
        }

        pub(crate) fn list(&self) -> io::Result<Vec<OsString>> {
            fs::read_dir(&self.0)?.map(|entry| Ok(entry?.file_name())).collect()
        }
    }
}

pub(crate) use system::Folder;
