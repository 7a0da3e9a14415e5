//! Where results lie: the folder or file that somebody named, and below a folder names of this program's own.
//!
//! What somebody named may be a link or a pipe of theirs. Below it nothing is followed: whoever else may write to the folder could lead
//! what is written anywhere the writer has a right to. A link there, and whatever is no regular file, is an error that names it.

use crate::IoError;
use crate::beneath::{Access, Folder, Kind};
use serde::{Serialize, Serializer};
use std::ffi::{OsStr, OsString};
use std::fs::{self, File};
use std::io::{self, Read};
use std::path::{Component, Display, Path, PathBuf};

/// A file or folder of results. Made from a path, it is that path as somebody named it; [`join`](Self::join) goes below.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ResultPath {
    /// What somebody named.
    root: PathBuf,
    /// What is below that; empty where nothing is.
    below: PathBuf,
    /// Both.
    path: PathBuf,
}

impl<P: Into<PathBuf>> From<P> for ResultPath {
    fn from(named: P) -> Self {
        let root = named.into();
        Self { path: root.clone(), below: PathBuf::new(), root }
    }
}

impl From<&Self> for ResultPath {
    fn from(other: &Self) -> Self {
        other.clone()
    }
}

impl Serialize for ResultPath {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.path.serialize(serializer)
    }
}

impl ResultPath {
    /// `name` in this folder. A name that is absolute or goes through `..` is an error of whatever is done with it.
    #[must_use]
    pub fn join(&self, name: impl AsRef<Path>) -> Self {
        let name = name.as_ref();
        if name.as_os_str().is_empty() {
            return self.clone();
        }
        let below = self.below.join(name);
        Self { root: self.root.clone(), path: self.root.join(&below), below }
    }

    /// With `.extension` behind the name.
    #[must_use]
    pub fn with_ending(&self, extension: &str) -> Self {
        let end = |path: &Path| {
            let mut name = OsString::from(path);
            name.push(".");
            name.push(extension);
            PathBuf::from(name)
        };
        if self.is_named() {
            return end(&self.root).into();
        }
        Self { root: self.root.clone(), below: end(&self.below), path: end(&self.path) }
    }

    /// The whole path, to be shown.
    pub fn display(&self) -> Display<'_> {
        self.path.display()
    }

    /// The whole path, for messages and for whoever reads as the user would.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Whether it is what somebody named, with nothing below.
    pub(crate) fn is_named(&self) -> bool {
        self.below.as_os_str().is_empty()
    }

    /// The names below what somebody named.
    fn names(&self) -> Result<Vec<&OsStr>, IoError> {
        let name = |part| if let Component::Normal(name) = part { Some(name) } else { None };
        let names = self.below.components().map(name).collect::<Option<_>>();
        names.ok_or_else(|| IoError::LeadsOut { path: self.path.clone(), dir: self.root.clone() })
    }

    /// The folder that this is in, and its name there; of what somebody named the folder itself and no name.
    fn folder(&self, make: bool) -> Result<(Folder, Option<&OsStr>), IoError> {
        let mut names = self.names()?;
        let name = names.pop();
        let open = || {
            if make {
                fs::create_dir_all(&self.root)?;
            }
            let root = if self.root.as_os_str().is_empty() { Path::new(".") } else { &self.root };
            let mut folder = Folder::named(root)?;
            for name in &names {
                folder = entered(&folder, name, make)?;
            }
            Ok(folder)
        };
        let folder = open().map_err(|source| self.fault(source, make))?;
        Ok((folder, name))
    }

    /// This as a folder, with `make` made with those above it.
    pub(crate) fn entered(&self, make: bool) -> Result<Folder, IoError> {
        let (folder, name) = self.folder(make)?;
        match name {
            None => Ok(folder),
            Some(name) => entered(&folder, name, make).map_err(|source| self.fault(source, make)),
        }
    }

    /// The folder below what somebody named that a file comes into, and its name; those on the way are made.
    pub(crate) fn place(&self) -> Result<(Folder, &OsStr), IoError> {
        let (folder, name) = self.folder(true)?;
        let name = name.ok_or_else(|| self.fault(io::ErrorKind::IsADirectory.into(), true))?;
        match folder.kind(name) {
            Ok(Kind::File) => Ok((folder, name)),
            Ok(Kind::Folder) => Err(self.fault(io::ErrorKind::IsADirectory.into(), true)),
            Ok(Kind::Link | Kind::Other) => Err(self.fault(io::ErrorKind::InvalidInput.into(), true)),
            Err(error) if error.kind() == io::ErrorKind::NotFound => Ok((folder, name)),
            Err(source) => Err(self.fault(source, true)),
        }
    }

    fn opened(&self, access: Access) -> Result<File, IoError> {
        let write = access != Access::Read;
        if self.is_named() {
            let mut options = File::options();
            options.read(!write).append(write).create(write);
            return options.open(&self.path).map_err(|source| self.fault(source, write));
        }
        let (folder, name) = self.folder(write)?;
        match name {
            Some(name) => folder.open(name, access).map_err(|source| self.fault(source, write)),
            None => Err(self.fault(io::ErrorKind::IsADirectory.into(), write)),
        }
    }

    /// What an error is about: what is in the way, where something is.
    pub(crate) fn fault(&self, source: io::Error, write: bool) -> IoError {
        if let Some((path, what)) = self.in_the_way() {
            return IoError::InTheWay { path, what };
        }
        let path = self.path.clone();
        if write { IoError::Write { path, source } } else { IoError::Read { path, source } }
    }

    /// The first name below what somebody named that is a link, or nothing that a result is or lies in.
    fn in_the_way(&self) -> Option<(PathBuf, &'static str)> {
        let names = self.names().ok()?;
        let mut path = self.root.clone();
        for name in names {
            path.push(name);
            let kind = fs::symlink_metadata(&path).ok()?.file_type();
            let what = if kind.is_symlink() {
                "a symbolic link"
            } else if kind.is_file() || kind.is_dir() {
                continue;
            } else {
                "a pipe, a socket or a device"
            };
            return Some((path, what));
        }
        None
    }

    /// The file, open to read; none where it is not there.
    ///
    /// # Errors
    /// A link or no regular file, here or on the way; a file that cannot be read.
    pub fn open(&self) -> Result<Option<File>, IoError> {
        if_there(self.opened(Access::Read))
    }

    /// The bytes of the file; none where it is not there.
    ///
    /// # Errors
    /// As [`open`](Self::open).
    pub fn read(&self) -> Result<Option<Vec<u8>>, IoError> {
        let Some(mut file) = self.open()? else { return Ok(None) };
        let mut bytes = Vec::new();
        file.read_to_end(&mut bytes).map_err(|source| self.fault(source, false))?;
        Ok(Some(bytes))
    }

    /// The bytes of a file that should be there.
    ///
    /// # Errors
    /// As [`open`](Self::open); a file that is not there.
    pub fn read_existing(&self) -> Result<Vec<u8>, IoError> {
        self.read()?.ok_or_else(|| IoError::Missing { path: self.path.clone() })
    }

    /// The text of the file, empty where there is none. What is no text is damage, which whoever takes the lines apart finds.
    ///
    /// # Errors
    /// As [`open`](Self::open).
    pub fn text(&self) -> Result<String, IoError> {
        Ok(self.read()?.map_or_else(String::new, |bytes| String::from_utf8_lossy(&bytes).into_owned()))
    }

    /// The file, open to be added to; made where it is not there, with the folders above.
    ///
    /// # Errors
    /// A link or no regular file, here or on the way; a file with other names; one that cannot be written to.
    pub fn append(&self) -> Result<File, IoError> {
        self.opened(Access::Append)
    }

    /// The file, open to be locked; made where it is not there, with the folders above.
    ///
    /// # Errors
    /// As [`append`](Self::append).
    pub fn open_lock(&self) -> Result<File, IoError> {
        self.opened(Access::Lock)
    }

    /// Takes the file away, where it is there. Of a link the link goes.
    ///
    /// # Errors
    /// A link on the way; a folder that cannot be written to.
    pub fn remove(&self) -> Result<(), IoError> {
        let removed = self.folder(false).and_then(|(folder, name)| {
            let name = name.ok_or_else(|| self.fault(io::ErrorKind::IsADirectory.into(), true))?;
            folder.remove(name).map_err(|source| IoError::Write { path: self.path.clone(), source })
        });
        if_there(removed).map(|_| ())
    }

    /// Takes the folder away with all that is in it, where it is there. Of links the links go.
    ///
    /// # Errors
    /// A link in its place or on the way; what cannot be removed.
    pub fn remove_all(&self) -> Result<(), IoError> {
        let Some(folder) = if_there(self.entered(false))? else { return Ok(()) };
        emptied(&folder).map_err(|source| self.fault(source, true))?;
        self.remove_empty().map_err(|source| self.fault(source, true))
    }

    /// Takes an empty folder away.
    pub(crate) fn remove_empty(&self) -> io::Result<()> {
        match self.folder(false) {
            Ok((folder, Some(name))) => folder.remove_folder(name),
            Ok((_, None)) => fs::remove_dir(&self.path),
            Err(_) => Err(io::ErrorKind::NotFound.into()),
        }
    }

    /// What is there; none where nothing is, or a link is on the way.
    pub fn kind(&self) -> Option<Kind> {
        if self.is_named() {
            let kind = fs::metadata(&self.path).ok()?.file_type();
            let other = if kind.is_dir() { Kind::Folder } else { Kind::Other };
            return Some(if kind.is_file() { Kind::File } else { other });
        }
        let (folder, name) = self.folder(false).ok()?;
        folder.kind(name?).ok()
    }

    /// Whether a regular file is there, by no link.
    pub fn is_file(&self) -> bool {
        self.kind() == Some(Kind::File)
    }

    /// What lies in the folder, by name; nothing where it is not there.
    ///
    /// # Errors
    /// A link on the way; a folder that cannot be listed.
    pub fn list(&self) -> Result<Vec<(OsString, Kind)>, IoError> {
        let Some(folder) = if_there(self.entered(false))? else { return Ok(Vec::new()) };
        let names = folder.list().map_err(|source| self.fault(source, false))?;
        // What has gone since is not there.
        let kind = |name: OsString| folder.kind(&name).ok().map(|kind| (name, kind));
        let mut found: Vec<_> = names.into_iter().filter_map(kind).collect();
        found.sort_by(|a, b| a.0.cmp(&b.0));
        Ok(found)
    }
}

fn if_there<T>(found: Result<T, IoError>) -> Result<Option<T>, IoError> {
    match found {
        Err(IoError::Read { source, .. } | IoError::Write { source, .. })
            if source.kind() == io::ErrorKind::NotFound =>
        {
            Ok(None)
        }
        found => found.map(Some),
    }
}

/// Removes what is in `folder`.
fn emptied(folder: &Folder) -> io::Result<()> {
    for name in folder.list()? {
        if folder.kind(&name)? == Kind::Folder {
            emptied(&folder.enter(&name)?)?;
            folder.remove_folder(&name)?;
        } else {
            folder.remove(&name)?;
        }
    }
    Ok(())
}

/// A folder in `folder`, made where it is not there and `make` says so.
fn entered(folder: &Folder, name: &OsStr, make: bool) -> io::Result<Folder> {
    match folder.enter(name) {
        Err(error) if make && error.kind() == io::ErrorKind::NotFound => {
            match folder.make(name) {
                // Another process was quicker.
                Err(error) if error.kind() != io::ErrorKind::AlreadyExists => return Err(error),
                _ => {}
            }
            folder.enter(name)
        }
        entered => entered,
    }
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use crate::atomic_write;
    use std::os::unix::fs::symlink;

    fn refusal<T: std::fmt::Debug>(result: Result<T, IoError>) -> String {
        result.unwrap_err().to_string()
    }

    #[test]
    fn below_the_folder_that_was_named_no_link_is_followed_by_anything() {
        let tmp = tempfile::tempdir().unwrap();
        let (dir, real) = (tmp.path().join("named"), tmp.path().join("real"));
        fs::create_dir_all(real.join("a")).unwrap();
        symlink(&real, &dir).unwrap();
        let (named, decoy) = (ResultPath::from(&dir), tmp.path().join("decoy"));
        atomic_write(named.join("a/b/whole"), |out| out.write_all(b"whole")).unwrap();
        assert_eq!(fs::read(real.join("a/b/whole")).unwrap(), b"whole");
        fs::write(&decoy, "own").unwrap();
        symlink(&decoy, real.join("a/file")).unwrap();
        fs::create_dir(tmp.path().join("other")).unwrap();
        symlink(tmp.path().join("other"), real.join("a/folder")).unwrap();
        for name in ["a/file", "a/folder", "a/folder/new", "a/folder/new/er"] {
            let path = named.join(name);
            let link = dir.join(if name.starts_with("a/file") { "a/file" } else { "a/folder" });
            let words = format!("{}: a symbolic link, and results", link.display());
            for said in [
                refusal(atomic_write(&path, |out| out.write_all(b"x"))),
                refusal(path.read()),
                refusal(path.append()),
                refusal(path.open_lock()),
                refusal(crate::FolderLock::take(&path).map_err(|error| match error {
                    crate::LockError::Io(error) => error,
                    held @ crate::LockError::Held { .. } => panic!("{held}"),
                })),
            ] {
                assert!(said.starts_with(&words), "{name}: {said}");
            }
            assert!(!path.is_file());
        }
        assert!(named.join("a/folder").list().is_err() && named.join("a/folder/new").remove().is_err());
        assert_eq!(fs::read(&decoy).unwrap(), b"own");
        assert_eq!(fs::read_dir(tmp.path().join("other")).unwrap().count(), 0);
        // Nor is anything removed through one.
        fs::create_dir_all(real.join("a/made/deeper")).unwrap();
        fs::write(real.join("a/made/deeper/file"), "").unwrap();
        for name in ["made/link", "made/deeper/link"] {
            symlink(tmp.path().join("other"), real.join("a").join(name)).unwrap();
        }
        fs::write(tmp.path().join("other/kept"), "").unwrap();
        let said = refusal(named.join("a/folder").remove_all());
        assert!(said.contains("a/folder: a symbolic link, and results"), "{said}");
        named.join("a/folder/kept").remove_all().unwrap_err();
        named.join("a/made").remove_all().unwrap();
        named.join("a/made").remove_all().unwrap();
        assert!(!real.join("a/made").exists());
        fs::remove_file(tmp.path().join("other/kept")).unwrap();
        // Of a link itself, the link goes.
        named.join("a/file").remove().unwrap();
        named.join("a/file").remove().unwrap();
        assert!(decoy.exists() && !real.join("a/file").exists());
        let listed = named.join("a").list().unwrap();
        assert_eq!(listed, [("b".into(), Kind::Folder), ("folder".into(), Kind::Link)]);
    }

    #[test]
    fn a_name_that_leads_out_a_second_name_and_a_pipe_are_errors() {
        let tmp = tempfile::tempdir().unwrap();
        let named = ResultPath::from(tmp.path().join("named"));
        let outside = tmp.path().join("outside");
        for name in ["../outside", "a/../../outside", outside.to_str().unwrap()] {
            let path = named.join(name);
            for said in [refusal(atomic_write(&path, |out| out.write_all(b"x"))), refusal(path.append())] {
                assert!(said.contains("is not below") && said.contains("named, where results lie"), "{said}");
            }
        }
        assert!(!outside.exists());
        fs::create_dir_all(named.path()).unwrap();
        fs::write(&outside, "own").unwrap();
        let second = named.join("second");
        fs::hard_link(&outside, second.path()).unwrap();
        let said = second.append().unwrap_err();
        let cause = std::error::Error::source(&said).unwrap().to_string();
        assert!(cause.contains("hard links"), "{cause}");
        // What is made anew leaves the other name alone.
        atomic_write(&second, |out| out.write_all(b"new")).unwrap();
        assert_eq!(fs::read(&outside).unwrap(), b"own");
        let pipe = named.join("pipe");
        assert!(std::process::Command::new("mkfifo").arg(pipe.path()).status().unwrap().success());
        for said in [refusal(pipe.read()), refusal(pipe.append()), refusal(atomic_write(&pipe, |_| Ok(())))] {
            assert!(said.contains("pipe: a pipe, a socket or a device, and results"), "{said}");
        }
        assert!(matches!(named.join("none").read(), Ok(None)));
        assert!(matches!(named.join("none/either").list().as_deref(), Ok([])));
        assert!(refusal(named.join("none").read_existing()).contains("none does not exist"));
    }
}
