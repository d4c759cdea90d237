//! Answers of services that serve city models (OGC API Features of 3DBAG): features beside the header that they count in. In: JSON text. Out:
//! the header and the features, if it is such an answer.

use serde::Deserialize;
use serde::de::IgnoredAny;

use crate::formats::cityjson::document::Document;

/// The header and the features of an answer.
pub(super) struct Answer<'a> {
    pub metadata: Document<'a>,
    pub features: Vec<Document<'a>>,
}

/// `feature` of one item, `features` of a collection.
#[derive(Deserialize)]
struct Text<'a> {
    #[serde(borrow)]
    metadata: Document<'a>,
    #[serde(default, borrow)]
    feature: Option<Document<'a>>,
    #[serde(default, borrow)]
    features: Vec<Document<'a>>,
}

/// Items of a collection as each of them is answered alone, with a header of its own.
#[derive(Deserialize)]
struct Collection<'a> {
    #[serde(borrow)]
    features: Vec<Text<'a>>,
}

/// What tells an answer from a city model at little cost: the other one has objects, and no features.
#[derive(Deserialize)]
struct Sketch {
    feature: Option<IgnoredAny>,
    features: Option<IgnoredAny>,
    #[serde(rename = "CityObjects")]
    objects: Option<IgnoredAny>,
}

/// Reads an answer; `None` if the text is none.
pub(super) fn of(text: &[u8]) -> Option<Answer<'_>> {
    // City models are large, and begin as such; only a text that names features is looked through.
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
        // Items count in the same steps from the same origin as a rule; those that do not would need a header of their own.
        if item.metadata.transform != answer.metadata.transform {
            return None;
        }
        answer.features.extend(item.feature);
    }
    (answer.metadata.kind.0 == "CityJSON").then_some(answer)
}
