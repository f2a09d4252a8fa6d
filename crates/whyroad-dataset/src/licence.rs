//! Licenses: the known ones, the permitted uses of a release that contains them, and the license that it declares. The
//! data is in `schema/licences.yaml`.

use crate::spec::{Licences, Use};
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;
use whyroad_framework::yaml_text;
use whyroad_model::yaml::{Fields, FileReport, FormCodes, Node};
use whyroad_model::{Bilingual, Diagnostic, Severity};

/// The table that is built in.
pub const BUNDLED: &str = include_str!("../../../schema/licences.yaml");
/// Declared by a release that may only be used internally and has no single license.
const INTERNAL: &str = "LicenseRef-Internal";

const TABLE: &str = "dataset.licence.table";
/// Shorter names of sources could be the beginning of anything.
const SHORTEST_SOURCE: usize = 4;

static FORM: FormCodes =
    FormCodes { syntax: TABLE, missing: TABLE, unknown: TABLE, kind: TABLE, duplicate: TABLE, empty: TABLE };

/// One license.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Licence {
    /// SPDX id, or `LicenseRef-...`.
    pub id: String,
    /// Other names, matched without regard to case.
    pub names: Vec<String>,
    /// Public data sets under this license.
    #[serde(default)]
    pub data_sets: Vec<String>,
    /// Its text.
    pub url: Option<String>,
    /// Permitted uses of a data set under it.
    pub permits: Vec<Use>,
    /// Must be kept by a release that contains it.
    pub share_alike: bool,
    /// Its obligations.
    pub attribution: Option<String>,
}

/// All known licenses, in the order of the file.
#[derive(Clone, Debug, PartialEq)]
pub struct LicenceTable {
    /// Version of the file.
    pub version: String,
    /// The licenses.
    pub licences: Vec<Licence>,
}

impl LicenceTable {
    /// Reads `schema/licences.yaml`.
    ///
    /// # Errors
    /// All errors in it.
    pub fn read(text: &str, file: &str) -> Result<Self, Vec<Diagnostic>> {
        let mut r = FileReport::new(file, text, &FORM);
        let mut table = Self { version: String::new(), licences: Vec::new() };
        if let Some(root) = yaml_text::parse(&mut r, text)
            && let Some(mut f) = Fields::open(&root, &mut r)
        {
            table.version = f.text("version", &mut r).unwrap_or_default();
            table.licences = f.list("licences", &mut r).iter().filter_map(|n| licence(n, &mut r)).collect();
            f.close(&mut r);
        }
        if r.diagnostics.iter().any(|d| d.severity == Severity::Error) {
            Err(r.diagnostics)
        } else {
            Ok(table)
        }
    }

    /// The license that a drive states, by id or by another name.
    pub fn find(&self, stated: &str) -> Option<&Licence> {
        let same = |name: &String| name.eq_ignore_ascii_case(stated.trim());
        self.licences.iter().find(|l| same(&l.id) || l.names.iter().any(same))
    }

    /// The license of the public data set that a drive comes from, by the name of its source: `nuscenes`, or the
    /// beginning of a name, `waymo`.
    pub fn of_source(&self, source: &str) -> Option<&Licence> {
        let plain = |name: &str| -> String {
            name.chars().filter(|c| c.is_alphanumeric()).flat_map(char::to_lowercase).collect()
        };
        let source = plain(source);
        let is_it = |name: &String| source.len() >= SHORTEST_SOURCE && plain(name).starts_with(&source);
        self.licences.iter().find(|l| l.data_sets.iter().any(is_it))
    }

    /// Why data under `licence` may not be in a release of this purpose; `None` when it may.
    pub fn objection(&self, licence: &Licence, spec: &Licences) -> Option<Diagnostic> {
        let id = &licence.id;
        if !licence.permits.contains(&spec.purpose) {
            let purpose = word(spec.purpose);
            let permitted = licence.permits.iter().map(|u| word(*u)).collect::<Vec<_>>().join(", ");
            let d = Diagnostic::error(
                "dataset.licence.forbidden",
                Bilingual::new(
                    format!("许可 {id} 不允许用途 {purpose}"),
                    format!("license {id} does not permit the purpose {purpose}"),
                ),
            );
            return Some(d.with_hint(Bilingual::new(
                format!("用 licences.allow 只取其他许可的数据，或将 purpose 设为它允许的用途：{permitted}"),
                format!(
                    "leave such data out with licences.allow, or set a purpose that it permits: {permitted}"
                ),
            )));
        }
        None
    }

    /// True when the spec's `allow` lists the license, or lists nothing.
    pub fn is_allowed(&self, licence: &Licence, spec: &Licences) -> bool {
        let same = |stated: &String| self.find(stated).is_some_and(|l| l.id == licence.id);
        spec.allow.is_empty() || spec.allow.iter().any(same)
    }

    /// The license that a release with drives under `ids` declares, or why they cannot be combined.
    ///
    /// # Errors
    /// A share-alike license together with one that it cannot be combined with.
    pub fn declared(&self, ids: &BTreeSet<String>, purpose: Use) -> Result<String, Box<Diagnostic>> {
        let all: Vec<&Licence> = self.licences.iter().filter(|l| ids.contains(&l.id)).collect();
        let shared = all.iter().filter(|l| l.share_alike);
        let conflict = shared.clone().find_map(|s| {
            let keeps = |l: &&&Licence| {
                l.id == s.id || (!l.share_alike && s.permits.iter().all(|u| l.permits.contains(u)))
            };
            all.iter().find(|l| !keeps(l)).map(|l| (s, l))
        });
        match (conflict, all.as_slice()) {
            (Some(_), _) if purpose == Use::Internal => Ok(INTERNAL.to_owned()),
            (Some((s, l)), _) => Err(Box::new(
                Diagnostic::error(
                    "dataset.licence.conflict",
                    Bilingual::new(
                        format!("{}（相同方式共享）不能与 {} 合并后发布", s.id, l.id),
                        format!(
                            "{} (share-alike) cannot be combined with {} in a release that is distributed",
                            s.id, l.id
                        ),
                    ),
                )
                .with_hint(Bilingual::new(
                    "用 licences.allow 只取其中之一，或将 purpose 设为 internal",
                    "select one of them with licences.allow, or set purpose: internal",
                )),
            )),
            (None, []) => Ok(INTERNAL.to_owned()),
            (None, [only]) => Ok(only.id.clone()),
            (None, several) => {
                let least = several.iter().map(|l| l.permits.len()).min().unwrap_or(0);
                let alike = several.iter().rfind(|l| l.share_alike);
                let strict = several.iter().rfind(|l| l.permits.len() == least);
                Ok(alike.or(strict).map_or_else(|| INTERNAL.to_owned(), |l| l.id.clone()))
            }
        }
    }
}

fn word(purpose: Use) -> &'static str {
    match purpose {
        Use::Internal => "internal",
        Use::Research => "research",
        Use::Commercial => "commercial",
    }
}

fn licence(node: &Node, r: &mut FileReport<'_>) -> Option<Licence> {
    let mut f = Fields::open(node, r)?;
    let id = f.text("id", r);
    let mut texts = |field: &'static str, r: &mut FileReport<'_>| -> Vec<String> {
        f.list(field, r).iter().filter_map(|n| r.text(n)).collect()
    };
    let (names, data_sets) = (texts("names", r), texts("data_sets", r));
    let url = f.text_opt("url", r);
    let attribution = f.text_opt("attribution", r);
    let share_alike = f.text_opt("share_alike", r).as_deref() == Some("true");
    let mut permits = Vec::new();
    if let Some(list) = f.need("permits", r) {
        for n in r.items(list) {
            match r.text(n).as_deref() {
                Some("internal") => permits.push(Use::Internal),
                Some("research") => permits.push(Use::Research),
                Some("commercial") => permits.push(Use::Commercial),
                Some(other) => r.error(
                    TABLE,
                    n,
                    format!("未知用途 '{other}'"),
                    format!("'{other}' is not internal, research or commercial"),
                ),
                None => {}
            }
        }
    }
    f.close(r);
    Some(Licence { id: id?, names, data_sets, url, permits, share_alike, attribution })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn declared(ids: &[&str], purpose: Use) -> Result<String, &'static str> {
        let table = LicenceTable::read(BUNDLED, "licences.yaml").unwrap();
        let ids = ids.iter().map(|s| (*s).to_owned()).collect();
        table.declared(&ids, purpose).map_err(|d| d.code)
    }

    #[test]
    fn the_strictest_licence_is_declared() {
        assert_eq!(declared(&["MIT"], Use::Research).unwrap(), "MIT");
        assert_eq!(declared(&["MIT", "CC-BY-NC-SA-4.0"], Use::Research).unwrap(), "CC-BY-NC-SA-4.0");
        assert_eq!(declared(&["MIT", "CC-BY-NC-4.0"], Use::Research).unwrap(), "CC-BY-NC-4.0");
        assert_eq!(declared(&["MIT", "CC-BY-4.0"], Use::Commercial).unwrap(), "CC-BY-4.0");
    }

    /// `data_sets` of schema/licences.yaml; ScenarioNet calls its sources `nuscenes`, `waymo`, `nuplan`, `pg`.
    #[test]
    fn a_source_that_is_a_public_data_set_is_under_its_license() {
        let table = LicenceTable::read(BUNDLED, "licences.yaml").unwrap();
        let of = |source: &str| table.of_source(source).map(|l| l.id.as_str());
        assert_eq!(of("nuscenes"), Some("CC-BY-NC-SA-4.0"));
        assert_eq!(of("waymo"), Some("LicenseRef-Waymo-Open-Dataset"));
        assert_eq!(of("argoverse2"), Some("CC-BY-NC-SA-4.0"));
        assert_eq!((of("pg"), of("fleet"), of("sumo"), of("")), (None, None, None, None));
    }

    #[test]
    fn share_alike_licences_that_contradict_are_not_combined() {
        for other in ["CC-BY-SA-4.0", "ODbL-1.0"] {
            let code = declared(&["CC-BY-NC-SA-4.0", other], Use::Research).unwrap_err();
            assert_eq!(code, "dataset.licence.conflict");
            assert_eq!(declared(&["CC-BY-NC-SA-4.0", other], Use::Internal).unwrap(), INTERNAL);
        }
        // Share-alike without the non-commercial clause, with a source that forbids commercial use.
        assert!(declared(&["CC-BY-SA-4.0", "CC-BY-NC-4.0"], Use::Research).is_err());
    }

    #[test]
    fn data_that_may_not_be_handed_on_is_refused_in_every_combination() {
        let table = LicenceTable::read(BUNDLED, "licences.yaml").unwrap();
        let code = |id: &str, purpose| {
            let spec = Licences { purpose, allow: vec![], assume: None };
            table.objection(table.find(id).unwrap(), &spec).map(|d| d.code)
        };
        for id in ["LicenseRef-NVIDIA-Autonomous-Vehicle-Dataset", "LicenseRef-Waymo-Open-Dataset"] {
            for purpose in [Use::Research, Use::Commercial] {
                assert_eq!(code(id, purpose), Some("dataset.licence.forbidden"), "{id}");
            }
            assert_eq!(code(id, Use::Internal), None);
            // Together with open data it stays unchanged; with share-alike data neither license can be kept.
            assert_eq!(declared(&[id, "MIT"], Use::Internal).unwrap(), id);
            assert_eq!(
                declared(&[id, "CC-BY-NC-SA-4.0"], Use::Research).unwrap_err(),
                "dataset.licence.conflict"
            );
            assert_eq!(declared(&[id, "CC-BY-NC-SA-4.0"], Use::Internal).unwrap(), INTERNAL);
        }
        // The name that earlier versions of this file gave it.
        let nvidia = table.find("LicenseRef-NVIDIA-PhysicalAI-AV").unwrap();
        assert_eq!(nvidia.id, "LicenseRef-NVIDIA-Autonomous-Vehicle-Dataset");
        // By its publishers: CC BY-NC-SA 4.0 (Argoverse 2, nuScenes), MIT (comma2k19).
        for (set, id) in
            [("Argoverse 2", "CC-BY-NC-SA-4.0"), ("nuScenes", "CC-BY-NC-SA-4.0"), ("comma2k19", "MIT")]
        {
            assert!(table.find(id).unwrap().data_sets.iter().any(|s| s == set), "{set}");
        }
        assert_eq!(code("CC-BY-NC-SA-4.0", Use::Commercial), Some("dataset.licence.forbidden"));
        assert_eq!(code("CC-BY-NC-SA-4.0", Use::Research), None);
    }

    #[test]
    fn names_are_found_without_case_and_purposes_are_checked() {
        let table = LicenceTable::read(BUNDLED, "licences.yaml").unwrap();
        let apache = table.find("apache 2.0").unwrap();
        assert_eq!(apache.id, "Apache-2.0");
        assert!(table.find("GPL-3.0").is_none());
        let spec = |purpose, allow: &[&str]| Licences {
            purpose,
            allow: allow.iter().map(|s| (*s).to_owned()).collect(),
            assume: None,
        };
        assert!(table.objection(apache, &spec(Use::Commercial, &[])).is_none());
        assert!(table.is_allowed(apache, &spec(Use::Commercial, &[])));
        assert!(!table.is_allowed(apache, &spec(Use::Commercial, &["MIT"])));
        let nc = table.find("CC-BY-NC-SA-4.0").unwrap();
        assert_eq!(
            table.objection(nc, &spec(Use::Commercial, &[])).unwrap().code,
            "dataset.licence.forbidden"
        );
    }
}
