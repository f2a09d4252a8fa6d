//! Where the labeling service stores its data: the options that `serve`, `tasks`, `accounts`, `backup` and `restore`
//! share.

use crate::{Global, framework_folder};
use anyhow::anyhow;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use whyroad_framework::Framework;
use whyroad_model::Lang;
use whyroad_server::domain::project::{Project, Settings};
use whyroad_server::problem::Problem;
use whyroad_server::secret;
use whyroad_server::store::{Store, StoreLocation, key_file};

/// Where the key of a store is, for commands that read labels from one.
#[derive(clap::Args, Clone, Debug, Default)]
pub(crate) struct KeyArgs {
    /// Folder of the service's data: with a PostgreSQL store, its key file
    #[arg(long, value_name = "DIR", default_value = "whyroad-data", env = "WHYROAD_DATA_DIR")]
    data: PathBuf,
    /// Key file of the store [default: beside the SQLite file, or labels.db.key in --data]
    #[arg(long, value_name = "FILE", env = "WHYROAD_KEY_FILE")]
    key_file: Option<PathBuf>,
}

impl KeyArgs {
    /// The store that a `--labels` or `--store` argument names: see [`open_store_with`].
    pub(crate) fn open(&self, source: &str, lang: Lang) -> anyhow::Result<Store> {
        open_store_with(source, &self.data, self.key_file.clone(), lang)
    }
}

/// The store that a `--labels` or `--store` argument names: a SQLite file, the folder with `labels.db`, or a PostgreSQL
/// address, of a service with the folder `data` and, where it is not the default one, the key file `key`. Related files
/// are searched where the service keeps them: beside the file, or in the service's folder.
pub(crate) fn open_store_with(
    source: &str,
    data: &Path,
    key: Option<PathBuf>,
    lang: Lang,
) -> anyhow::Result<Store> {
    let below = Path::new(source).join("labels.db");
    let location = match StoreLocation::parse(source) {
        StoreLocation::File(_) if below.is_file() => StoreLocation::File(below),
        other => other,
    };
    let folder = match &location {
        StoreLocation::File(path) if !path.is_file() => {
            return Err(anyhow!(match lang {
                Lang::Zh => format!("没有存储 {}", path.display()),
                Lang::En => format!("no store at {}", path.display()),
            }));
        }
        StoreLocation::File(path) => path.parent().unwrap_or(Path::new(".")).to_path_buf(),
        StoreLocation::Server(_) => data.to_owned(),
    };
    let key = key.unwrap_or_else(|| key_file(&location, &folder));
    Store::open_with_key(&location, &folder, &key).map_err(|p| error(&p, lang))
}

/// Options for the location of the store.
#[derive(clap::Args, Clone, Debug)]
pub(crate) struct StoreArgs {
    /// Store of tasks and labels: a SQLite file, or postgres://user:password@host/database
    #[arg(long, value_name = "URL", env = "WHYROAD_STORE", hide_env_values = true)]
    store: Option<String>,
    /// Folder for the service's data; the store is labels.db in it unless --store names another
    #[arg(long, value_name = "DIR", default_value = "whyroad-data", env = "WHYROAD_DATA_DIR")]
    pub data: PathBuf,
    /// File with the key for secrets in the store; created when it does not exist [default: beside the SQLite file,
    /// with .key at the end; for a database server labels.db.key in --data]
    #[arg(long, value_name = "FILE", env = "WHYROAD_KEY_FILE")]
    key_file: Option<PathBuf>,
}

impl StoreArgs {
    /// Location of the store by the options.
    pub(crate) fn location(&self) -> StoreLocation {
        match &self.store {
            Some(text) => StoreLocation::parse(text),
            None => StoreLocation::File(self.data.join("labels.db")),
        }
    }

    /// Where the key file is.
    pub(crate) fn key_file(&self) -> PathBuf {
        self.key_file.clone().unwrap_or_else(|| key_file(&self.location(), &self.data))
    }

    /// Opens the store; creates it when it does not exist.
    pub(crate) fn open(&self, lang: Lang) -> anyhow::Result<Store> {
        let location = self.location();
        let key = self.key_file();
        let store = Store::open_with_key(&location, &self.data, &key).map_err(|p| error(&p, lang))?;
        if let Some(kept) = store.kept.as_ref().map(|p| p.display()) {
            match lang {
                Lang::Zh => say!("存储已升级到本程序的版本；升级前的内容在 {kept}"),
                Lang::En => {
                    say!(
                        "the store was upgraded to this program's version; the previous content is in {kept}"
                    )
                }
            }
        }
        Ok(store)
    }

    /// Opens the store of a service that has run before: a mistyped path must not create an empty one.
    pub(crate) fn open_existing(&self, lang: Lang) -> anyhow::Result<Store> {
        if let StoreLocation::File(path) = self.location()
            && !path.is_file()
        {
            return Err(anyhow!(match lang {
                Lang::Zh =>
                    format!("没有存储 {}；用 --data 或 --store 指定，`whyroad serve` 会新建", path.display()),
                Lang::En => format!(
                    "no store at {}; name it with --data or --store; `whyroad serve` creates one",
                    path.display()
                ),
            }));
        }
        self.open(lang)
    }
}

/// A refusal of the service in the user's language.
pub(crate) fn error(problem: &Problem, lang: Lang) -> anyhow::Error {
    anyhow!("{}: {}", problem.code, problem.text.get(lang))
}

/// The framework for the lifetime of the program: all threads of the service read it.
pub(crate) fn framework(global: &Global) -> anyhow::Result<&'static Framework> {
    if global.framework.is_none() {
        return Ok(Framework::bundled());
    }
    let (framework, _) = framework_folder::load(global)?;
    Ok(Box::leak(Box::new(framework)))
}

/// A project of this name, not yet stored; its drafts are in the user's language.
pub(crate) fn new_project(name: &str, lang: Lang) -> anyhow::Result<Project> {
    let word = if lang == Lang::Zh { "zh" } else { "en" };
    Ok(Project {
        id: secret::id().map_err(|p| error(&p, lang))?,
        name: name.to_owned(),
        guide: String::new(),
        quota: BTreeMap::new(),
        settings: Settings { lang: word.to_owned(), ..Settings::default() },
        roles: vec![],
    })
}
