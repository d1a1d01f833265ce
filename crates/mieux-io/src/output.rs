//! Files that are either whole or not there, and folders that are checked before the work begins.

use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, Seek, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

/// What can go wrong with what is written.
#[derive(Debug, thiserror::Error)]
pub enum OutputError {
    /// A folder could not be made.
    #[error("the folder `{}` cannot be made: {source}", path.display())]
    CreateFolder {
        /// The folder.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// There is something else where a folder should be.
    #[error("`{}` is not a folder; give a folder, or a name that is not taken", path.display())]
    NotAFolder {
        /// What is there.
        path: PathBuf,
    },
    /// A folder in which no file can be made.
    #[error("nothing can be written to the folder `{}`: {source}", path.display())]
    NotWritable {
        /// The folder.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// A file could not be written.
    #[error("`{}` cannot be written: {source}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// A name that is not the plain name of a file.
    #[error("`{name}` is not the name of a file in the output folder; give a name without `/`")]
    Name {
        /// The name.
        name: String,
    },
}

/// Where bytes go in order, and sometimes back.
pub trait WriteSeek: Write + Seek {}

impl<W: Write + Seek> WriteSeek for W {}

/// Writes a file under a temporary name in the same folder, and gives it its name when all of it is on disk: whoever
/// looks at `path` sees the old file or the whole new one. What is no regular file (`/dev/null`) is written in place.
///
/// # Errors
/// [`OutputError::Write`], and then `path` is as it was and no temporary file is left.
pub fn write_atomic(path: &Path, write: impl FnOnce(&mut dyn WriteSeek) -> io::Result<()>) -> Result<(), OutputError> {
    let error = |source| OutputError::Write { path: path.to_owned(), source };
    // A link to a file stays a link.
    let target = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    match fs::metadata(&target) {
        Ok(metadata) if metadata.is_dir() => {
            return Err(error(io::Error::new(io::ErrorKind::IsADirectory, "there is a folder of that name")));
        }
        Ok(metadata) if !metadata.is_file() => {
            let mut file = OpenOptions::new().write(true).open(&target).map_err(error)?;
            return write(&mut file).map_err(error);
        }
        _ => {}
    }
    let (temporary, file) = Temporary::beside(&target).map_err(error)?;
    let mut buffered = BufWriter::new(file);
    write(&mut buffered).map_err(error)?;
    let file = buffered.into_inner().map_err(|e| error(e.into_error()))?;
    file.sync_all().map_err(error)?;
    drop(file);
    temporary.rename(&target).map_err(error)
}

/// A file that is removed unless it is renamed.
struct Temporary {
    path: PathBuf,
    kept: bool,
}

impl Temporary {
    /// Makes a new file in the folder of `target`, under a name nobody else has.
    fn beside(target: &Path) -> io::Result<(Self, File)> {
        static COUNT: AtomicU64 = AtomicU64::new(0);
        let name = target.file_name().ok_or_else(|| {
            io::Error::new(io::ErrorKind::InvalidInput, "the path does not end in the name of a file")
        })?;
        loop {
            let number = COUNT.fetch_add(1, Ordering::Relaxed);
            let mut temporary_name = std::ffi::OsString::from(".");
            temporary_name.push(name);
            temporary_name.push(format!(".{}-{number}.partial", std::process::id()));
            let path = target.with_file_name(temporary_name);
            match OpenOptions::new().write(true).create_new(true).open(&path) {
                Ok(file) => return Ok((Self { path, kept: false }, file)),
                Err(e) if e.kind() == io::ErrorKind::AlreadyExists => {}
                Err(e) => return Err(e),
            }
        }
    }

    fn rename(mut self, target: &Path) -> io::Result<()> {
        fs::rename(&self.path, target)?;
        self.kept = true;
        // The new name lasts once its folder is on disk; where folders cannot be opened or synced, nothing more can be done.
        let folder = target.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let _ = File::open(folder).and_then(|folder| folder.sync_all());
        Ok(())
    }
}

impl Drop for Temporary {
    fn drop(&mut self) {
        if !self.kept {
            // Nothing more can be done about a file that will not go.
            let _ = fs::remove_file(&self.path);
        }
    }
}

/// A folder for results, made and tried out before any work is done.
///
/// Dropped without [`OutputDir::commit`], it removes again the folders it made, as far as they are empty: input that
/// turns out to be bad leaves nothing behind.
#[derive(Debug)]
pub struct OutputDir {
    path: PathBuf,
    /// Folders made here, the outermost first.
    made: Vec<PathBuf>,
}

impl OutputDir {
    /// Makes the folder, with its parents, unless it is there, and makes sure that files can be made in it.
    ///
    /// # Errors
    /// [`OutputError::NotAFolder`], [`OutputError::CreateFolder`] or [`OutputError::NotWritable`]; whatever was made
    /// on the way is removed again.
    pub fn create(path: &Path) -> Result<Self, OutputError> {
        let mut dir = Self { path: path.to_owned(), made: Vec::new() };
        let mut missing = Vec::new();
        for ancestor in path.ancestors().filter(|a| !a.as_os_str().is_empty()) {
            match fs::metadata(ancestor) {
                Ok(metadata) if metadata.is_dir() => break,
                Ok(_) => return Err(OutputError::NotAFolder { path: ancestor.to_owned() }),
                // A file on the way up is found at its own turn.
                Err(e) if matches!(e.kind(), io::ErrorKind::NotFound | io::ErrorKind::NotADirectory) => {
                    missing.push(ancestor);
                }
                Err(source) => return Err(OutputError::CreateFolder { path: ancestor.to_owned(), source }),
            }
        }
        for folder in missing.into_iter().rev() {
            match fs::create_dir(folder) {
                Ok(()) => dir.made.push(folder.to_owned()),
                // Somebody else was faster, or the path ends in `..`.
                Err(_) if folder.is_dir() => {}
                Err(source) => return Err(OutputError::CreateFolder { path: folder.to_owned(), source }),
            }
        }
        Temporary::beside(&path.join("probe"))
            .map(drop)
            .map_err(|source| OutputError::NotWritable { path: path.to_owned(), source })?;
        Ok(dir)
    }

    /// The folder.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The path of a file of that name in the folder.
    ///
    /// # Errors
    /// [`OutputError::Name`] when the name is empty, `.`, `..` or has a `/` in it.
    pub fn file(&self, name: &str) -> Result<PathBuf, OutputError> {
        let path = Path::new(name);
        if path.file_name() != Some(path.as_os_str()) {
            return Err(OutputError::Name { name: name.to_owned() });
        }
        Ok(self.path.join(name))
    }

    /// Writes a file into the folder with [`write_atomic`] and returns its path.
    ///
    /// # Errors
    /// [`OutputError::Name`] or [`OutputError::Write`].
    pub fn write(
        &self,
        name: &str,
        write: impl FnOnce(&mut dyn WriteSeek) -> io::Result<()>,
    ) -> Result<PathBuf, OutputError> {
        let path = self.file(name)?;
        write_atomic(&path, write)?;
        Ok(path)
    }

    /// Keeps the folder, even if it is empty.
    pub fn commit(mut self) -> PathBuf {
        self.made.clear();
        std::mem::take(&mut self.path)
    }
}

impl Drop for OutputDir {
    fn drop(&mut self) {
        for folder in self.made.iter().rev() {
            // Fails, as it should, on a folder that holds something.
            if fs::remove_dir(folder).is_err() {
                break;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let mut names: Vec<_> =
            fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    #[test]
    fn a_file_appears_whole_or_not_at_all() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        write_atomic(&path, |w| w.write_all(b"first")).unwrap();
        write_atomic(&path, |w| {
            w.write_all(b"xxxxx second")?;
            w.seek(io::SeekFrom::Start(0))?;
            w.write_all(b"the  ")
        })
        .unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"the   second");
        let failed = write_atomic(&path, |w| {
            w.write_all(b"half")?;
            Err(io::Error::other("the pen broke"))
        })
        .unwrap_err();
        assert!(failed.to_string().contains("a.txt") && failed.to_string().contains("the pen broke"), "{failed}");
        assert_eq!(fs::read(&path).unwrap(), b"the   second");
        assert_eq!(names(folder.path()), ["a.txt"]);
    }

    #[test]
    fn what_cannot_be_written_is_named() {
        let folder = tempfile::tempdir().unwrap();
        for path in [folder.path().to_owned(), folder.path().join("no/such/a.txt"), PathBuf::from("/"), PathBuf::new()]
        {
            let error = write_atomic(&path, |w| w.write_all(b"x")).unwrap_err();
            assert!(matches!(error, OutputError::Write { .. }), "{error:?}");
        }
        assert!(names(folder.path()).is_empty());
    }

    #[cfg(unix)]
    #[test]
    fn links_and_devices_stay_what_they_are() {
        use std::os::unix::fs::FileTypeExt;
        let folder = tempfile::tempdir().unwrap();
        let (real, link) = (folder.path().join("real"), folder.path().join("link"));
        fs::write(&real, "old").unwrap();
        std::os::unix::fs::symlink(&real, &link).unwrap();
        write_atomic(&link, |w| w.write_all(b"new")).unwrap();
        assert_eq!(fs::read(&real).unwrap(), b"new");
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        write_atomic(Path::new("/dev/null"), |w| w.write_all(b"gone")).unwrap();
        assert!(fs::metadata("/dev/null").unwrap().file_type().is_char_device());
    }

    #[test]
    fn folders_that_were_made_for_nothing_go_again() {
        let root = tempfile::tempdir().unwrap();
        let deep = root.path().join("a/b/c");
        drop(OutputDir::create(&deep).unwrap());
        assert!(names(root.path()).is_empty());
        assert_eq!(OutputDir::create(&deep).unwrap().commit(), deep);
        assert!(deep.is_dir() && names(&deep).is_empty());
        drop(OutputDir::create(&deep.join("d")).unwrap());
        assert!(deep.is_dir(), "only what was made goes");
        let dir = OutputDir::create(&root.path().join("kept")).unwrap();
        let file = dir.write("x.txt", |w| w.write_all(b"x")).unwrap();
        drop(dir);
        assert!(file.is_file());
    }

    #[test]
    fn a_folder_that_will_not_do_is_refused_at_once() {
        let root = tempfile::tempdir().unwrap();
        let file = root.path().join("file");
        fs::write(&file, "x").unwrap();
        for path in [file.clone(), file.join("below")] {
            let error = OutputDir::create(&path).unwrap_err();
            assert!(matches!(&error, OutputError::NotAFolder { path } if *path == file), "{error:?}");
        }
        assert!(OutputDir::create(Path::new("/proc/mieux")).is_err());
        assert!(OutputDir::create(Path::new("/proc")).is_err());
        let dir = OutputDir::create(root.path()).unwrap();
        for name in ["", ".", "..", "a/b", "/etc/passwd", "../x", "x/"] {
            assert!(matches!(dir.file(name), Err(OutputError::Name { .. })), "{name}");
        }
    }
}
