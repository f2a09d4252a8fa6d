//! Licenses of the public data sets that adapters read, as `schema/licences.yaml` has them (`data_sets`).

/// Argoverse 2.
pub(crate) const ARGOVERSE_2: &str = "CC-BY-NC-SA-4.0";
/// nuScenes and nuPlan.
pub(crate) const NUSCENES: &str = "CC-BY-NC-SA-4.0";
/// Waymo Open Dataset.
pub(crate) const WAYMO: &str = "LicenseRef-Waymo-Open-Dataset";

/// The license of the public data set that a scenario was converted from, by the beginning of its name; `None` where it
/// is not known.
pub(crate) fn of_data_set(name: &str) -> Option<&'static str> {
    let name = name.to_lowercase();
    let known = [
        ("nuscenes", NUSCENES),
        ("nuplan", NUSCENES),
        ("argoverse", ARGOVERSE_2),
        ("av2", ARGOVERSE_2),
        ("waymo", WAYMO),
    ];
    known.iter().find(|(begins, _)| name.starts_with(begins)).map(|(_, licence)| *licence)
}
