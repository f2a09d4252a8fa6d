//! `open_lake`: drives, signals and episodes of a lake.

use crate::error::{of_arrow, of_code, of_diagnostic, of_diagnostics, of_lake, warn};
use crate::signals::{Rows, batch, schema};
use crate::table::Table;
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use std::path::PathBuf;
use whyroad_engine::mine::{MineOptions, mine_drives, signals_of};
use whyroad_framework::Framework;
use whyroad_lake::mined::episode_table;
use whyroad_mining::RuleSet;
use whyroad_mining::language::Subject;
use whyroad_mining::rule::text::compile_text;
use whyroad_model::catalog::SignalScope;
use whyroad_model::{DriveId, Lang, ScenarioId, Severity};
use whyroad_signals::Catalog;

/// Opens a lake, as `whyroad ingest --lake DIR` made it.
#[pyfunction]
pub fn open_lake(path: PathBuf) -> PyResult<Lake> {
    whyroad_lake::Lake::open(path).map(|inner| Lake { inner }).map_err(|e| of_lake(&e))
}

/// A Parquet file as a table, with these columns (default: all).
#[pyfunction]
#[pyo3(signature = (path, columns=None))]
pub fn read_parquet(py: Python<'_>, path: PathBuf, columns: Option<Vec<String>>) -> PyResult<Table> {
    py.detach(|| {
        let file = std::fs::File::open(&path)?;
        let builder = ParquetRecordBatchReaderBuilder::try_new(file).map_err(of_arrow)?;
        let mask = match &columns {
            Some(names) => parquet::arrow::ProjectionMask::columns(
                builder.parquet_schema(),
                names.iter().map(String::as_str),
            ),
            None => parquet::arrow::ProjectionMask::all(),
        };
        let reader = builder.with_projection(mask).with_batch_size(1 << 16).build().map_err(of_arrow)?;
        let schema = arrow_array::RecordBatchReader::schema(&reader);
        let batches = reader.collect::<Result<_, _>>().map_err(of_arrow)?;
        Ok(Table::new(schema, batches))
    })
}

/// A lake of drives.
#[pyclass(frozen, module = "whyroad")]
pub struct Lake {
    inner: whyroad_lake::Lake,
}

#[pymethods]
impl Lake {
    /// Ids of the drives, sorted.
    fn drives(&self) -> Vec<String> {
        self.inner.drive_ids().iter().map(ToString::to_string).collect()
    }

    /// The lake's folder.
    #[getter]
    fn path(&self) -> PathBuf {
        self.inner.dir().to_owned()
    }

    /// Signals by name, one row per frame (`ego.speed`) or per target and frame (`target.gap`); one record batch per
    /// drive. Signals that `whyroad mine` stored are read; where there are none they are derived. Unknown is null.
    #[pyo3(signature = (names, drives=None))]
    fn signals(&self, py: Python<'_>, names: Vec<String>, drives: Option<Vec<String>>) -> PyResult<Table> {
        let catalog = Catalog::bundled();
        let mut resolved = Vec::new();
        let mut rows = None;
        for name in &names {
            let Some((def, _)) = catalog.resolve(name) else {
                let near = catalog.similar(name).join(", ");
                let hint = (!near.is_empty()).then(|| format!("did you mean {near}?"));
                return Err(of_code("rule.signal.unknown", format!("signal '{name}' not found"), hint));
            };
            if def.scope.is_on_demand() {
                return Err(PyValueError::new_err(format!(
                    "'{name}' is derived only for rules that ask for it: use mine(rule=...)"
                )));
            }
            let of = if def.id.scope() == SignalScope::Frame { Rows::Frames } else { Rows::Targets };
            if *rows.get_or_insert(of) != of {
                return Err(PyValueError::new_err("signals per frame and signals per target need two calls"));
            }
            resolved.push(def.name.clone());
        }
        let Some(rows) = rows else { return Err(PyValueError::new_err("name at least one signal")) };
        let schema = schema(catalog, rows, &resolved);
        let ids = match drives {
            Some(ids) => ids.into_iter().map(DriveId::from).collect(),
            None => self.inner.drive_ids(),
        };
        py.detach(|| {
            let mut batches = Vec::with_capacity(ids.len());
            for id in &ids {
                let table = self.stored(id, rows, &resolved).map_err(|e| of_lake(&e))?;
                batches.push(batch(table, rows, &resolved, &schema).map_err(of_arrow)?);
            }
            Ok(Table::new(schema, batches))
        })
    }

    /// The episodes of a folder that `whyroad mine --out DIR` wrote.
    fn episodes(&self, py: Python<'_>, mined: PathBuf) -> PyResult<Table> {
        read_parquet(py, mined.join("episodes.parquet"), None)
    }

    /// Episodes that the bundled rules find (default), or a custom rule (`rule="target.gap < 10 m for 1 s"`); the
    /// columns are those of `episodes.parquet`. `scenario` keeps one class: an L1, L2 or leaf; `drives` searches only
    /// these.
    #[pyo3(signature = (rule=None, *, target=None, scenario=None, drives=None, jobs=None))]
    fn mine(
        &self,
        py: Python<'_>,
        rule: Option<&str>,
        target: Option<&str>,
        scenario: Option<&str>,
        drives: Option<Vec<String>>,
        jobs: Option<usize>,
    ) -> PyResult<Table> {
        let framework = Framework::bundled();
        let catalog = Catalog::bundled();
        let class = match scenario {
            Some(text) => match framework.taxonomy.resolve(text) {
                whyroad_framework::Resolution::Found(id) => Some(id),
                _ => {
                    return Err(of_code("taxonomy.class.unknown", format!("class '{text}' not found"), None));
                }
            },
            None => None,
        };
        let (all, _) = RuleSet::of_framework(framework, catalog);
        let rules = match rule {
            Some(text) => {
                let subject = match target {
                    Some(word) => Some(Subject::from_word(word).ok_or_else(|| {
                        of_code("rule.target", format!("'{word}' is not a kind of target"), None)
                    })?),
                    None => None,
                };
                let own = ScenarioId { l1: whyroad_mining::rule::OTHER.to_owned(), l2: None, l3: None };
                let rule =
                    compile_text(text, subject, &own, catalog, "rule").map_err(|d| of_diagnostic(&d))?;
                RuleSet { rules: vec![rule], ..all }
            }
            None => all.with_decision_moments(catalog),
        };
        let options = MineOptions { jobs, lang: Lang::En, ..MineOptions::default() };
        let ids = match drives {
            Some(ids) => ids.into_iter().map(DriveId::from).collect(),
            None => self.inner.drive_ids(),
        };
        let mined = py.detach(|| mine_drives(&self.inner, &rules, &options, &ids));
        if mined.drives.is_empty() && mined.diagnostics.iter().any(|d| d.severity == Severity::Error) {
            return Err(of_diagnostics(&mined.diagnostics));
        }
        warn(py, &mined.diagnostics)?;
        let wanted = |id: &ScenarioId| class.as_ref().is_none_or(|c| id.is_within(c));
        let all = mined.drives.iter().flat_map(|d| &d.episodes).map(|e| &e.record);
        let episodes: Vec<_> = all.filter(|r| wanted(&r.scenario_id)).collect();
        let batch = episode_table(&episodes).map_err(of_arrow)?;
        Ok(Table::new(batch.schema(), vec![batch]))
    }

    fn __repr__(&self) -> String {
        format!("whyroad.Lake({:?}, {} drives)", self.inner.dir(), self.inner.drive_ids().len())
    }
}

impl Lake {
    /// Stored signals of a drive, reduced to what is asked for; derived where none are stored.
    fn stored(
        &self,
        id: &DriveId,
        rows: Rows,
        names: &[String],
    ) -> Result<whyroad_model::SignalTable, whyroad_lake::LakeError> {
        let mut table = match self.inner.signals(id, whyroad_signals::VERSION)? {
            Some(file) => file.read_table(0)?,
            None => signals_of(&self.inner, id)?,
        };
        let keep = |columns: &mut std::collections::BTreeMap<String, whyroad_model::Column>| {
            columns.retain(|name, _| names.iter().any(|n| n == name));
        };
        match rows {
            Rows::Frames => keep(&mut table.frame_columns),
            Rows::Targets => keep(&mut table.target_columns),
        }
        Ok(table)
    }
}
