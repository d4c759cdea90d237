//! Answers of services that serve city models (OGC API Features of 3DBAG): features with the header
//! that holds their transform. In: JSON text. Out: the header and the features, if the text is such
//! an answer.

use serde::Deserialize;
use serde::de::IgnoredAny;

use crate::formats::cityjson::document::Document;

/// Header and features of an answer.
pub(super) struct Answer<'a> {
    pub metadata: Document<'a>,
    pub features: Vec<Document<'a>>,
}

/// An answer with one item in `feature`, or with a collection in `features`.
#[derive(Deserialize)]
struct Text<'a> {
    #[serde(borrow)]
    metadata: Document<'a>,
    #[serde(default, borrow)]
    feature: Option<Document<'a>>,
    #[serde(default, borrow)]
    features: Vec<Document<'a>>,
}

/// A collection whose items have the form of a single answer, each with its own header.
#[derive(Deserialize)]
struct Collection<'a> {
    #[serde(borrow)]
    features: Vec<Text<'a>>,
}

/// Outline of a text, which tells an answer from a city model at little cost: a city model has
/// objects and no features.
#[derive(Deserialize)]
struct Sketch {
    feature: Option<IgnoredAny>,
    features: Option<IgnoredAny>,
    #[serde(rename = "CityObjects")]
    objects: Option<IgnoredAny>,
}

/// Reads an answer; returns `None` if the text is not one.
pub(super) fn of(text: &[u8]) -> Option<Answer<'_>> {
    // City models are large and name their type at the start; other texts are searched for
    // features.
    let head = text.get(..text.len().min(64)).unwrap_or_default();
    if head.windows(10).any(|window| window == b"\"CityJSON\"") {
        return None;
    }
    let sketch: Sketch = serde_json::from_slice(text).ok()?;
    if sketch.objects.is_some() || (sketch.feature.is_none() && sketch.features.is_none()) {
        return None;
    }
    if let Ok(Text { metadata, feature, features }) = serde_json::from_slice::<Text>(text) {
        let features: Vec<Document> = feature.into_iter().chain(features).collect();
        if metadata.kind.0 == "CityJSON" && features.iter().all(|feature| feature.kind.0 == "CityJSONFeature") {
            return Some(Answer { metadata, features });
        }
    }
    let Collection { features } = serde_json::from_slice(text).ok()?;
    let mut items = features.into_iter();
    let first = items.next()?;
    let mut answer = Answer { metadata: first.metadata, features: first.feature.into_iter().collect() };
    for item in items {
        // Items of a collection usually share scale and translation; items that do not would need a
        // header of their own.
        if item.metadata.transform != answer.metadata.transform {
            return None;
        }
        answer.features.extend(item.feature);
    }
    (answer.metadata.kind.0 == "CityJSON").then_some(answer)
}
