//! A pack on its way to disk: the files of the drives become the row groups of the pack's files.

use super::catalog::{DriveEntry, sync_folder};
use super::member::{Member, MemberSignals};
use super::open_pack::{DRIVES, DRIVES_ORDER, NOTES, NOTES_ORDER, SIGNALS};
use super::splice::{self, Part, Schemas, with_drive_id};
use crate::columns::TableBuilder;
use crate::signals::{self, Contents};
use crate::tables::SCENE;
use crate::{LakeError, file};
use arrow_schema::{Field, Schema};
use parquet::file::metadata::KeyValue;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;
use std::sync::Arc;
use whyroad_model::DriveId;

/// The columns of each scene table: drives in which they differ (older versions) are not in one pack.
type SceneColumns = BTreeMap<&'static str, Schema>;

/// Divides drives, sorted by id, so that the tables of each part have the same columns.
pub(super) fn alike(members: Vec<Member>, schemas: &mut Schemas) -> Result<Vec<Vec<Member>>, LakeError> {
    let mut parts: Vec<(SceneColumns, Vec<Member>)> = Vec::new();
    for member in members {
        let mut columns = SceneColumns::new();
        for (name, part) in &member.tables {
            columns.insert(name, with_drive_id(&*schemas.of(part)?));
        }
        let fits = |of: &SceneColumns| columns.iter().all(|(name, c)| of.get(name).is_none_or(|o| o == c));
        match parts.iter_mut().find(|(of, _)| fits(of)) {
            Some((of, alike)) => {
                of.extend(columns);
                alike.push(member);
            }
            None => parts.push((columns, vec![member])),
        }
    }
    Ok(parts.into_iter().map(|(_, members)| members).collect())
}

/// Writes the pack `name` of these drives, sorted by id; all of it is on the disk when this returns.
pub(super) fn pack(
    packs: &Path,
    name: &str,
    members: &[Member],
    schemas: &mut Schemas,
) -> Result<Vec<DriveEntry>, LakeError> {
    let dir = packs.join(name);
    fs::create_dir_all(&dir).map_err(LakeError::io(&dir))?;
    for (table, order) in SCENE {
        let parts: Vec<(&DriveId, &Part)> =
            members.iter().filter_map(|m| Some((&m.id, m.tables.get(table)?))).collect();
        let Some((_, first)) = parts.first() else { continue };
        let schema = with_drive_id(&*schemas.of(first)?);
        splice::write(&dir.join(format!("{table}.parquet")), &schema, order, vec![], &parts)?;
    }
    let stored: Vec<&MemberSignals> = members.iter().filter_map(|m| m.signals.as_ref()).collect();
    if !stored.is_empty() {
        write_signals(&dir.join(SIGNALS), &stored, schemas)?;
    }
    let notes = members.iter().filter(|m| !m.notes.is_empty());
    let batches: Vec<_> = notes
        .map(|m| {
            let table = TableBuilder::default()
                .texts(splice::DRIVE_ID, m.notes.iter().map(|_| m.id.as_str()))
                .texts("name", m.notes.keys())
                .bytes("content", m.notes.values().map(Vec::as_slice));
            table.finish().map_err(|e| LakeError::broken(&dir, e))
        })
        .collect::<Result<_, _>>()?;
    if let Some(first) = batches.first() {
        let properties = file::properties(NOTES_ORDER, vec![]).build();
        file::write_batches(&dir.join(format!("{NOTES}.parquet")), &first.schema(), &batches, properties)?;
    }
    let manifests = members
        .iter()
        .map(|m| serde_json::to_string(&m.manifest).map_err(|e| LakeError::broken(&dir, e)))
        .collect::<Result<Vec<_>, _>>()?;
    let drives = TableBuilder::default()
        .texts(splice::DRIVE_ID, members.iter().map(|m| m.id.as_str()))
        .texts("manifest", &manifests)
        .indices("notes", members.iter().map(|m| u32::try_from(m.notes.len()).unwrap_or(u32::MAX)))
        .texts("fingerprint", members.iter().map(|m| &m.fingerprint));
    file::write_table(&dir.join(DRIVES), drives, DRIVES_ORDER)?;
    sync_folder(&dir)?;
    members.iter().zip(0..).map(|(m, row)| entry(m, name, row)).collect()
}

fn entry(member: &Member, pack: &str, row: u32) -> Result<DriveEntry, LakeError> {
    let (start, end) = member.span()?;
    Ok(DriveEntry {
        pack: Some(pack.to_owned()),
        row,
        bytes: member.bytes(),
        ..member.manifest.entry(start, end)
    })
}

/// Which of a drive's two files.
type PartOf = fn(&MemberSignals) -> &Part;

/// Columns of one of the two files.
#[derive(Default)]
struct SignalColumns {
    /// Object and time.
    keys: Vec<Arc<Field>>,
    /// The signals of all drives.
    signals: BTreeMap<String, Arc<Field>>,
    /// Those of each drive.
    of_drives: Vec<BTreeSet<String>>,
}

impl SignalColumns {
    fn of(stored: &[&MemberSignals], part: PartOf, schemas: &mut Schemas) -> Result<Self, LakeError> {
        let mut out = Self::default();
        for drive in stored {
            let (schema, path) = (schemas.of(part(drive))?, &part(drive).path);
            let (signals, keys): (Vec<_>, Vec<_>) =
                schema.fields().iter().cloned().partition(|f| f.name().contains('.'));
            if out.keys.is_empty() {
                out.keys = keys;
            } else if out.keys != keys {
                return Err(LakeError::broken(
                    path,
                    "its columns before the signals are not those of other drives",
                ));
            }
            out.of_drives.push(signals.iter().map(|f| f.name().clone()).collect());
            for field in signals {
                let known = out.signals.entry(field.name().clone()).or_insert_with(|| Arc::clone(&field));
                if known.data_type() != field.data_type() {
                    let reason = format!("column '{}' is of another type than in other drives", field.name());
                    return Err(LakeError::broken(path, reason));
                }
            }
        }
        Ok(out)
    }

    /// Columns that a drive does not have.
    fn absent(&self, drive: usize) -> impl Iterator<Item = &String> {
        self.signals.keys().filter(move |name| !self.of_drives[drive].contains(*name))
    }
}

fn write_signals(dir: &Path, stored: &[&MemberSignals], schemas: &mut Schemas) -> Result<(), LakeError> {
    fs::create_dir_all(dir).map_err(LakeError::io(dir))?;
    let version = stored[0].version.clone();
    let files: [(&str, PartOf); 2] = [("frames.parquet", |s| &s.frames), ("targets.parquet", |s| &s.targets)];
    let mut columns = Vec::new();
    for (_, part) in files {
        columns.push(SignalColumns::of(stored, part, schemas)?);
    }
    let drives = stored.iter().enumerate().map(|(i, s)| {
        let mut drive = s.stored.clone();
        drive.version = (s.version != version).then(|| s.version.clone());
        // Absent columns stay absent, even if the source had them.
        let absent = columns.iter().flat_map(|c| c.absent(i)).cloned().chain(drive.absent);
        let absent: BTreeSet<String> = absent.filter(|n| !drive.unavailable.contains_key(n)).collect();
        drive.absent = absent.into_iter().collect();
        drive
    });
    let contents = Contents { version: version.clone(), drives: drives.collect() };
    let text = serde_json::to_string(&contents).map_err(|e| LakeError::broken(dir, e))?;
    for ((name, part), columns) in files.into_iter().zip(columns) {
        let fields = columns.keys.into_iter().chain(columns.signals.into_values());
        let schema = Schema::new(fields.collect::<Vec<_>>());
        let parts: Vec<(&DriveId, &Part)> = stored.iter().map(|s| (&s.stored.drive_id, part(s))).collect();
        let stated = if name == "frames.parquet" { text.clone() } else { signals::digest(&text) };
        let more = vec![KeyValue::new(signals::KEY.to_owned(), stated)];
        splice::write(&dir.join(name), &schema, signals::ROW_ORDER, more, &parts)?;
    }
    sync_folder(dir)
}
