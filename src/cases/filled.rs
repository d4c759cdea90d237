//! Requests from texts, as faces hand them over. In: names of fields with their texts. Out: a
//! request whose files were checked, and what results state of it.

use std::path::{Path, PathBuf};

use heliotile_core::error::{Error, Result};
use heliotile_core::text::without_secrets;
use heliotile_files::writing::claim::OutputGuard;
use heliotile_requests::{InputKind, Many, Request, Role, Row, complete, filled};
use heliotile_results::Provenance;
use serde_json::{Map, Number, Value};

use super::ready::ready;

/// Texts of the fields that a user filled, by name.
pub type Given = Vec<(String, Vec<String>)>;

/// A request whose files were checked. Its outputs are claimed until it is dropped.
pub struct Prepared<R> {
    /// Request.
    pub request: R,
    /// Files that it reads, without archives and scenes, which have hashes of their own.
    inputs: Vec<PathBuf>,
    _claimed: OutputGuard,
}

impl<R> Prepared<R> {
    /// Adds the hashes of weather, tables and other small files that the request reads to `about`.
    ///
    /// # Errors
    /// A file cannot be read.
    pub fn told_in(&self, about: Provenance) -> Result<Provenance> {
        about.with_inputs(&self.inputs)
    }
}

/// Fills a request and checks it: ranges, fields that exclude each other, files that are not there
/// or of another kind, and outputs that would replace an input or each other. `known` names fields
/// that the face fills in another way, `in_memory` files that are none.
pub fn prepared<R: Request + Default>(
    given: &Given,
    known: &[&str],
    in_memory: &dyn Fn(&Path) -> bool,
) -> Result<Prepared<R>> {
    let names: Vec<&str> = given.iter().map(|(name, _)| name.as_str()).chain(known.iter().copied()).collect();
    let request = filled::<R>(given).map_err(Error::refused)?;
    complete(&R::rows(), &R::groups(), &names).map_err(Error::refused)?;
    let claimed = ready(&request, names.contains(&"geo"), in_memory)?;
    let mut inputs = Vec::new();
    request.files(&mut |_, role, path| match role {
        Role::Input(InputKind::Archive | InputKind::SceneOrArchive | InputKind::Scene) => {}
        Role::Input(_) if !in_memory(path) => inputs.push(path.to_path_buf()),
        Role::Input(_) | Role::Value | Role::Output(_) | Role::Neutral => {}
    });
    Ok(Prepared { request, inputs, _claimed: claimed })
}

/// Returns the fields that change values with their texts, or with those of their defaults, for
/// the provenance of results. The default of a field that belongs to another one counts only if
/// that one is given.
pub fn stated(rows: &[Row], given: &Given) -> Map<String, Value> {
    let texts = |row: &Row| given.iter().find(|(name, _)| name == row.name).map(|(_, texts)| texts.clone());
    let value = |row: &Row| {
        let typed = texts(row);
        if row.many == Many::Flag {
            return typed.map(|_| Value::Bool(true));
        }
        let counts = row.requires.is_empty() || given.iter().any(|(name, _)| row.requires.contains(&name.as_str()));
        let all = typed.or_else(|| row.default_texts().filter(|_| counts))?;
        let all: Vec<Value> = all.iter().map(|text| value_of(&without_secrets(text))).collect();
        match row.many {
            Many::List => Some(Value::Array(all)),
            _ => all.into_iter().last(),
        }
    };
    let stated = rows.iter().filter(|row| row.is_stated());
    stated.filter_map(|row| Some((row.name.to_owned(), value(row)?))).collect()
}

/// Returns a JSON number if the text is one, else a string.
fn value_of(text: &str) -> Value {
    text.parse::<Number>().map_or_else(|_| Value::from(text), Value::Number)
}
