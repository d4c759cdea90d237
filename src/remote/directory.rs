//! A folder, local or remote. In: a path, or an address that objects lie below. Out: places of the
//! files in it, which of them exist, and the contents of small ones. Requests for many objects run
//! at the same time.

use std::path::{Path, PathBuf};

use rayon::prelude::*;

use super::stored;
use crate::naming::{is_address, shown};
use heliotile_core::archive::ReadAt;
use heliotile_core::error::{Error, Result};

/// Objects of a store that are requested at the same time, to hide the latency of each request.
const AT_ONCE: usize = 16;
/// Smallest number of names above which a store is asked for its list.
const LISTED_FROM: usize = 64;
/// Divisor of the number of files that may exist: a list is read only if more than one in
/// `LISTED_SHARE` of them is asked for.
const LISTED_SHARE: usize = 20;

/// Largest small file, bytes: the plan of an atlas of some millions of parts.
const MAX_BYTES: u64 = 1 << 30;

/// A folder of a file system, or what lies below an address.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Directory(PathBuf);

impl Directory {
    /// Returns the folder at a place.
    pub fn at(place: &Path) -> Self {
        Directory(place.to_path_buf())
    }

    /// Returns the place of the folder.
    pub fn place(&self) -> &Path {
        &self.0
    }

    /// Returns true if the folder has an address.
    pub fn is_remote(&self) -> bool {
        is_address(&self.0)
    }

    /// Returns the place of the file `name` in the folder. A signed address passes its signature on
    /// to each file.
    pub fn join(&self, name: &str) -> PathBuf {
        if !self.is_remote() {
            return self.0.join(name);
        }
        let text = self.0.to_string_lossy();
        let (path, rest) = text.split_at(text.find(['?', '#']).unwrap_or(text.len()));
        format!("{}/{name}{rest}", path.trim_end_matches('/')).into()
    }

    /// Reads a small file in the folder, from one version of it, or returns `None` if it is not
    /// there. With `sure`, a file that may not be read is an error; without it, it counts as
    /// absent.
    pub fn read(&self, name: &str, sure: bool) -> Result<Option<Vec<u8>>> {
        let place = self.join(name);
        if !is_address(&place) {
            return place.is_file().then(|| std::fs::read(&place).map_err(Error::io(&place, "read"))).transpose();
        }
        let Some(file) = stored::find(&place, false, sure)? else { return Ok(None) };
        if file.length() > MAX_BYTES {
            let what = format!("bytes of {}", shown(&place).display());
            return Err(Error::Limit { what: what.into(), value: file.length(), max: MAX_BYTES });
        }
        let length = usize::try_from(file.length()).unwrap_or(usize::MAX);
        file.copy_at(0, length).map(Some).map_err(Error::unread(&shown(&place)))
    }

    /// Returns for each of `names` true if that file exists. `of` is the number of files that may
    /// exist in the folder.
    pub fn has(&self, names: &[String], of: usize) -> Result<Vec<bool>> {
        if !self.is_remote() {
            return Ok(names.iter().map(|name| self.join(name).is_file()).collect());
        }
        if names.len() > LISTED_FROM
            && names.len() > of / LISTED_SHARE
            && let Some(listed) = self.names()?
        {
            return Ok(names.iter().map(|name| listed.binary_search(name).is_ok()).collect());
        }
        self.each(names, |name| stored::exists(&self.join(name)))
    }

    /// Returns the names of all files below the folder, sorted, `a/b` for a file in a subfolder;
    /// `None` if a server gives no list.
    pub fn names(&self) -> Result<Option<Vec<String>>> {
        if self.is_remote() {
            let mut names = stored::names_below(Path::new(self.0.to_string_lossy().trim_end_matches('/')))?;
            names.iter_mut().for_each(|names| names.sort_unstable());
            return Ok(names);
        }
        let (mut names, mut folders) = (Vec::new(), vec![String::new()]);
        while let Some(folder) = folders.pop() {
            let path = self.0.join(&folder);
            for entry in path.read_dir().map_err(Error::io(&path, "list"))? {
                let entry = entry.map_err(Error::io(&path, "list"))?;
                let name = format!("{folder}{}", entry.file_name().to_string_lossy());
                match entry.path().is_dir() {
                    true => folders.push(name + "/"),
                    false => names.push(name),
                }
            }
        }
        names.sort_unstable();
        Ok(Some(names))
    }

    /// Calls `each` for each item; remote folders are served by `AT_ONCE` threads, as each call
    /// waits for an answer.
    pub fn each<T: Sync, R: Send>(&self, items: &[T], each: impl Fn(&T) -> Result<R> + Sync) -> Result<Vec<R>> {
        let all = || items.par_iter().map(&each).collect();
        if !self.is_remote() {
            return all();
        }
        let threads = rayon::ThreadPoolBuilder::new().num_threads(AT_ONCE.min(items.len().max(1))).build();
        // Without a pool of its own the work runs on the global thread pool.
        threads.map_or_else(|_| all(), |threads| threads.install(all))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// For 4 addresses and a path, a file in the folder gets the right place, with the name before
    /// the signature and behind one slash; two of three names exist.
    #[test]
    fn a_name_is_joined_before_the_signature() {
        for (place, joined) in [
            ("s3://bucket/atlas", "s3://bucket/atlas/parts/a/site.helio"),
            ("s3://bucket/", "s3://bucket/parts/a/site.helio"),
            ("https://host/atlas/?sv=1&sig=a/b", "https://host/atlas/parts/a/site.helio?sv=1&sig=a/b"),
            ("http://host:8/a#b", "http://host:8/a/parts/a/site.helio#b"),
            ("folder/atlas", "folder/atlas/parts/a/site.helio"),
        ] {
            assert_eq!(Directory::at(Path::new(place)).join("parts/a/site.helio"), Path::new(joined));
        }
        let folder = tempfile::tempdir().expect("a folder");
        std::fs::create_dir(folder.path().join("a")).expect("a folder");
        for name in ["b", "a/c"] {
            std::fs::write(folder.path().join(name), name).expect("written");
        }
        let folder = Directory::at(folder.path());
        assert_eq!(folder.names().ok().flatten(), Some(vec!["a/c".to_owned(), "b".to_owned()]));
        assert_eq!(folder.has(&["a/c", "a", "b"].map(str::to_owned), 3).ok(), Some(vec![true, false, true]));
        assert_eq!(folder.read("a/c", true).ok().flatten().as_deref(), Some(&b"a/c"[..]));
        assert!(folder.read("c", true).is_ok_and(|none| none.is_none()));
    }
}
