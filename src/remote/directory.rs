//! A folder wherever it lies. In: a path, or an address that objects lie below. Out: places of what is in it, which of them are there, what
//! small ones hold. Whoever has many of them to look at looks at some at the same time.

use std::path::{Path, PathBuf};

use rayon::prelude::*;

use super::stored;
use crate::naming::{is_address, shown};
use heliotile_core::archive::ReadAt;
use heliotile_core::error::{Error, Result};

/// Objects of a store that are looked at together: each is waited for.
const AT_ONCE: usize = 16;
/// For more names than these a store is asked for its list,
const LISTED_FROM: usize = 64;
/// if they are more than this share of what it lists.
const LISTED_SHARE: usize = 20;

/// Largest small file: the plan of some millions of parts.
const MOST_BYTES: u64 = 1 << 30;

/// A folder of a file system, or what lies below an address.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Directory(PathBuf);

impl Directory {
    /// The folder at a place.
    pub fn at(place: &Path) -> Self {
        Directory(place.to_path_buf())
    }

    /// Where it is.
    pub fn place(&self) -> &Path {
        &self.0
    }

    /// Whether it has an address.
    pub fn is_remote(&self) -> bool {
        is_address(&self.0)
    }

    /// Where a file in it is; of a signed address each has the signature.
    pub fn join(&self, name: &str) -> PathBuf {
        if !self.is_remote() {
            return self.0.join(name);
        }
        let text = self.0.to_string_lossy();
        let (path, rest) = text.split_at(text.find(['?', '#']).unwrap_or(text.len()));
        format!("{}/{name}{rest}", path.trim_end_matches('/')).into()
    }

    /// What a small file in it holds, of one version; none if it is not there. `sure`: what may not be read is an error, and not taken for
    /// nothing.
    pub fn read(&self, name: &str, sure: bool) -> Result<Option<Vec<u8>>> {
        let place = self.join(name);
        if !is_address(&place) {
            return place.is_file().then(|| std::fs::read(&place).map_err(Error::io(&place, "read"))).transpose();
        }
        let Some(file) = stored::find(&place, false, sure)? else { return Ok(None) };
        if file.length() > MOST_BYTES {
            let what = format!("bytes of {}", shown(&place).display());
            return Err(Error::Limit { what, value: file.length(), max: MOST_BYTES });
        }
        let length = usize::try_from(file.length()).unwrap_or(usize::MAX);
        file.copy_at(0, length).map(Some).map_err(Error::unread(&shown(&place)))
    }

    /// Which of some files are there, of so many that may be.
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

    /// Names of all files below it in their order, `a/b` for one in a folder of it; none where a server does not tell.
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

    /// Does something with each of some items, with many at the same time.
    pub fn each<T: Sync, R: Send>(&self, items: &[T], each: impl Fn(&T) -> Result<R> + Sync) -> Result<Vec<R>> {
        let all = || items.par_iter().map(&each).collect();
        if !self.is_remote() {
            return all();
        }
        let threads = rayon::ThreadPoolBuilder::new().num_threads(AT_ONCE.min(items.len().max(1))).build();
        // Without threads of their own they take turns on those that there are.
        threads.map_or_else(|_| all(), |threads| threads.install(all))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of 4 addresses and a path a file in them is where it should be, before a signature and behind one slash; two of three names are there.
    #[test]
    fn places() {
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
