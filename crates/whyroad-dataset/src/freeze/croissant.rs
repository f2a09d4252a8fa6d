//! Croissant 1.1 metadata (JSON-LD) of a release: every data file with its hash, and the top-level columns of each
//! split.

use super::DATA;
use super::manifest::Manifest;
use crate::item::SplitName;
use crate::sample::schema::schema;
use arrow_schema::DataType;
use serde_json::{Value, json};

/// The document.
pub(crate) fn croissant(m: &Manifest) -> String {
    let data = m.files.iter().filter(|f| f.path.starts_with(DATA));
    let mut distribution: Vec<Value> = data
        .clone()
        .map(|f| {
            json!({
                "@type": "cr:FileObject",
                "@id": f.path,
                "name": f.path,
                "contentUrl": f.path,
                "contentSize": format!("{} B", f.bytes),
                "encodingFormat": "application/x-parquet",
                "sha256": f.sha256,
            })
        })
        .collect();
    let mut records = Vec::new();
    for split in SplitName::ALL.map(SplitName::name) {
        let prefix = format!("{DATA}/{split}-");
        if !data.clone().any(|f| f.path.starts_with(&prefix)) {
            continue;
        }
        distribution.push(json!({
            "@type": "cr:FileSet",
            "@id": split,
            "name": split,
            "encodingFormat": "application/x-parquet",
            "includes": format!("{DATA}/{split}-*.parquet"),
        }));
        records.push(json!({
            "@type": "cr:RecordSet",
            "@id": format!("{split}-samples"),
            "name": format!("{split}-samples"),
            "description": "One record per sample.",
            "field": fields(split),
        }));
    }
    let licence = m.licences.iter().find(|l| l.id == m.licence).and_then(|l| l.url.clone());
    let title = m.title.as_deref().unwrap_or(&m.name);
    let document = json!({
        "@context": context(),
        "@type": "sc:Dataset",
        "conformsTo": "http://mlcommons.org/croissant/1.1",
        "name": m.name,
        "description": format!("{title}: Chain-of-Causation driving data, {} samples.", m.counts.samples),
        "license": licence.unwrap_or_else(|| m.licence.clone()),
        "version": semantic(&m.version),
        "citeAs": format!("{title}, version {}", m.version),
        "url": ".",
        "distribution": distribution,
        "recordSet": records,
    });
    let text = serde_json::to_string_pretty(&document).unwrap_or_default();
    format!("{text}\n")
}

/// Croissant wants `major.minor.patch`.
fn semantic(version: &str) -> String {
    let parts: Vec<&str> = version.split('.').collect();
    let numbers = parts.iter().all(|p| !p.is_empty() && p.bytes().all(|b| b.is_ascii_digit()));
    match (numbers, parts.len()) {
        (true, 1) => format!("{version}.0.0"),
        (true, 2) => format!("{version}.0"),
        _ => version.to_owned(),
    }
}

/// The columns that are one value per sample; lists and groups are described in the reference.
fn fields(split: &str) -> Vec<Value> {
    let schema = schema();
    let plain = schema.fields().iter().filter_map(|f| {
        let kind = match f.data_type() {
            DataType::Utf8 => "sc:Text",
            DataType::Float64 => "sc:Float",
            _ => return None,
        };
        Some(json!({
            "@type": "cr:Field",
            "@id": format!("{split}-samples/{}", f.name()),
            "name": f.name(),
            "dataType": kind,
            "source": { "fileSet": { "@id": split }, "extract": { "column": f.name() } },
        }))
    });
    plain.collect()
}

/// The context that the specification gives.
fn context() -> Value {
    serde_json::from_str(CONTEXT).unwrap_or_default()
}

const CONTEXT: &str = r#"{
    "@language": "en",
    "@vocab": "https://schema.org/",
    "arrayShape": "cr:arrayShape",
    "citeAs": "cr:citeAs",
    "column": "cr:column",
    "conformsTo": "dct:conformsTo",
    "containedIn": "cr:containedIn",
    "cr": "http://mlcommons.org/croissant/",
    "data": { "@id": "cr:data", "@type": "@json" },
    "dataBiases": "cr:dataBiases",
    "dataCollection": "cr:dataCollection",
    "dataType": { "@id": "cr:dataType", "@type": "@vocab" },
    "dct": "http://purl.org/dc/terms/",
    "equivalentProperty": "cr:equivalentProperty",
    "examples": { "@id": "cr:examples", "@type": "@json" },
    "excludes": "cr:excludes",
    "extract": "cr:extract",
    "field": "cr:field",
    "fileObject": "cr:fileObject",
    "fileProperty": "cr:fileProperty",
    "fileSet": "cr:fileSet",
    "format": "cr:format",
    "includes": "cr:includes",
    "isArray": "cr:isArray",
    "isLiveDataset": "cr:isLiveDataset",
    "jsonPath": "cr:jsonPath",
    "key": "cr:key",
    "md5": "cr:md5",
    "parentField": "cr:parentField",
    "path": "cr:path",
    "personalSensitiveInformation": "cr:personalSensitiveInformation",
    "prov": "http://www.w3.org/ns/prov#",
    "rai": "http://mlcommons.org/croissant/RAI/",
    "recordSet": "cr:recordSet",
    "references": "cr:references",
    "regex": "cr:regex",
    "repeated": "cr:repeated",
    "replace": "cr:replace",
    "samplingRate": "cr:samplingRate",
    "sc": "https://schema.org/",
    "separator": "cr:separator",
    "source": "cr:source",
    "subField": "cr:subField",
    "transform": "cr:transform"
}"#;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_context_is_json_and_versions_are_semantic() {
        assert!(context()["recordSet"].is_string());
        assert_eq!(["1", "2.1", "1.2.3", "2026-11"].map(semantic), ["1.0.0", "2.1.0", "1.2.3", "2026-11"]);
    }
}
