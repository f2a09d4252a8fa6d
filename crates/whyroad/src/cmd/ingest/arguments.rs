//! Arguments of `whyroad ingest`: one subcommand per format, built from the options that its adapter declares, and a
//! form without a format, which recognizes it.

use crate::output::DataFormat;
use crate::output::reason::{Reason, reason};
use clap::builder::ValueParser;
use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{Arg, ArgAction, ArgMatches, Command, value_parser};
use std::path::{Path, PathBuf};
use whyroad_ingest::{
    AdapterRef, LICENCE, MAP_OPTIONS, OptionSpec, OptionType, OptionValue, Options, START, formats,
};
use whyroad_model::{Bilingual, DriveId};

/// The user's request.
pub(crate) struct Args {
    pub format: Option<AdapterRef>,
    pub paths: Vec<PathBuf>,
    pub lake: PathBuf,
    pub options: Options,
    pub print: DataFormat,
    pub meta: Option<PathBuf>,
}

/// Options without a format: those whose meaning is the same for every format.
const SHARED: &[OptionSpec] = &[START, LICENCE];

impl clap::Args for Args {
    fn augment_args(command: Command) -> Command {
        let command = with_common(command)
            .args(SHARED.iter().chain(MAP_OPTIONS).map(argument))
            .arg(paths().required(true))
            .args_conflicts_with_subcommands(false)
            .subcommand_negates_reqs(true)
            .subcommand_help_heading("Formats")
            .subcommand_value_name("FORMAT")
            .disable_help_subcommand(true)
            .override_usage("whyroad ingest [FORMAT] [OPTIONS] --lake <DIR> <PATH>...");
        command.subcommands(formats::ALL.iter().map(|adapter| {
            let adapter = adapter.0.about();
            Command::new(adapter.name)
                .about(adapter.summary)
                .override_usage(format!("whyroad ingest {} [OPTIONS] --lake <DIR> <PATH>...", adapter.name))
                .arg(paths().required(true))
                .args(adapter.options.iter().chain(MAP_OPTIONS).map(argument))
                .after_help(format!("Example:\n  whyroad ingest {}", adapter.example))
        }))
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

/// Options of `ingest` that may be given before or after the format.
fn with_common(command: Command) -> Command {
    command
        .arg(
            Arg::new("lake")
                .long("lake")
                .value_name("DIR")
                .value_parser(value_parser!(PathBuf))
                .global(true)
                .help("Lake to write into; created if it does not exist (required)"),
        )
        .arg(
            Arg::new("drive-id")
                .long("drive-id")
                .value_name("ID")
                .value_parser(ValueParser::new(drive_id))
                .global(true)
                .help("Id of the drive; only with a single source"),
        )
        .arg(
            Arg::new("meta")
                .long("meta")
                .value_name("CSV")
                .value_parser(value_parser!(PathBuf))
                .global(true)
                .help("Facts about drives of the lake: drive_id, and any of session, vehicle, latitude, longitude, datum, place, licence"),
        )
        .arg(
            Arg::new("print")
                .long("format")
                .value_name("FORMAT")
                .value_parser(value_parser!(DataFormat))
                .default_value("text")
                .global(true)
                .help("How to print the result"),
        )
}

fn paths() -> Arg {
    Arg::new("paths")
        .value_name("PATH")
        .num_args(1..)
        .value_parser(value_parser!(PathBuf))
        .help("Log folders, files, or folders of them")
}

/// The text, if it can be the id of a drive.
fn drive_id(text: &str) -> Result<String, Reason> {
    DriveId::from(text).is_folder_safe().then(|| text.to_owned()).ok_or_else(|| {
        Reason::from(Bilingual::new(
            "行程编号由 1 至 128 个 ASCII 字母、数字与 - _ . 组成，且不以 . 开头",
            "an id of a drive has 1 to 128 ASCII letters, digits, - _ and ., and does not begin with a full stop",
        ))
    })
}

/// The command-line argument of a declared option.
fn argument(option: &OptionSpec) -> Arg {
    let action = match (option.value, option.repeatable) {
        (OptionType::Flag, _) => ArgAction::SetTrue,
        (_, true) => ArgAction::Append,
        (_, false) => ArgAction::Set,
    };
    let mut help = option.help.to_owned();
    help[..1].make_ascii_uppercase();
    let mut arg = Arg::new(option.name)
        .long(option.name)
        .help(help)
        .action(action)
        .conflicts_with_all(option.conflicts);
    if option.value != OptionType::Flag {
        let spec = option.clone();
        let parse = move |text: &str| spec.parse(text).map_err(Reason::from);
        arg = arg
            .value_name(option.value_name)
            .allow_hyphen_values(option.signed)
            .value_parser(ValueParser::new(parse));
    }
    match option.requires {
        Some(other) => arg.requires(other),
        None => arg,
    }
}

impl clap::FromArgMatches for Args {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let (format, used) = match matches.subcommand() {
            Some((name, sub)) => (formats::by_name(name), sub),
            None => (None, matches),
        };
        let paths: Vec<PathBuf> = used.get_many("paths").into_iter().flatten().cloned().collect();
        if format.is_none() {
            refuse_unknown_format(&paths)?;
        }
        let mut options = Options::default();
        options.drive_id = used.get_one::<String>("drive-id").map(|id| DriveId::from(id.as_str()));
        for option in format.map_or(SHARED, |f| f.0.about().options).iter().chain(MAP_OPTIONS) {
            if option.value == OptionType::Flag {
                if used.get_flag(option.name) {
                    options.set(option, OptionValue::Flag);
                }
            } else if let Some(values) = used.get_many::<OptionValue>(option.name) {
                values.cloned().for_each(|value| options.set(option, value));
            }
        }
        let lake = used.get_one::<PathBuf>("lake").cloned().ok_or_else(|| {
            let mut error = clap::Error::new(ErrorKind::MissingRequiredArgument);
            error.insert(ContextKind::InvalidArg, ContextValue::Strings(vec!["--lake <DIR>".to_owned()]));
            error
        })?;
        let print = used.get_one::<DataFormat>("print").copied().unwrap_or(DataFormat::Text);
        let meta = used.get_one::<PathBuf>("meta").cloned();
        Ok(Self { format, paths, lake, options, print, meta })
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

/// A first argument that is not a path, but looks like a format, is a usage error: nothing is written.
fn refuse_unknown_format(paths: &[PathBuf]) -> Result<(), clap::Error> {
    let Some(first) = paths.first().filter(|p| !p.exists() && is_one_word(p)) else { return Ok(()) };
    let name = first.display().to_string();
    let closest = formats::closest(&name);
    if closest.is_none() && paths.len() == 1 {
        // A path that does not exist; the search for sources reports it.
        return Ok(());
    }
    let mut error = clap::Error::new(ErrorKind::InvalidSubcommand);
    error.insert(ContextKind::InvalidSubcommand, ContextValue::String(name));
    if let Some(closest) = closest {
        error.insert(ContextKind::SuggestedSubcommand, ContextValue::Strings(vec![closest.to_owned()]));
    } else {
        let known: Vec<&str> = formats::ALL.iter().map(|a| a.0.name()).collect();
        let formats =
            reason(format!("格式有 {}", known.join("、")), format!("the formats are {}", known.join(", ")));
        let formats = formats.to_string().into();
        error.insert(ContextKind::Suggested, ContextValue::StyledStrs(vec![formats]));
    }
    Err(error)
}

fn is_one_word(path: &Path) -> bool {
    let text = path.to_string_lossy();
    !text.is_empty() && text.chars().all(|c| c.is_ascii_alphanumeric() || matches!(c, '-' | '_'))
}
