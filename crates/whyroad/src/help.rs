//! Examples at the end of every `--help`. A test parses each of them with the real command line, so an example that no
//! longer works fails the build.

use clap::Command;

/// Path of a command (below `whyroad`) and its examples: what it does, and the line.
const EXAMPLES: &[(&str, &[(&str, &str)])] = &[
    ("taxonomy init", &[("A copy of the framework to edit", "whyroad taxonomy init my-framework")]),
    ("taxonomy list", &[("All safety classes in Chinese", "whyroad taxonomy list --l1 safety --lang zh")]),
    ("taxonomy show", &[("By short id", "whyroad taxonomy show cutin.urgent")]),
    (
        "taxonomy lint",
        &[
            ("The built-in framework", "whyroad taxonomy lint"),
            ("Your own framework folder", "whyroad taxonomy lint --framework my-framework"),
        ],
    ),
    (
        "taxonomy diff",
        &[("A framework folder against the built-in one", "whyroad taxonomy diff bundled my-framework")],
    ),
    (
        "taxonomy migrate",
        &[
            ("A commented mapping to fill in", "whyroad taxonomy migrate mapping.yaml --init"),
            (
                "Dry run on the store of the labeling service",
                "whyroad taxonomy migrate mapping.yaml --store whyroad-data --dry-run",
            ),
            (
                "A release and exported labels into a new folder",
                "whyroad taxonomy migrate mapping.yaml --release release --labels labels.jsonl --out carried",
            ),
        ],
    ),
    ("taxonomy docs", &[("Fail if a generated page is out of date", "whyroad taxonomy docs --check")]),
    ("taxonomy schemas", &[("Write the schemas to a folder", "whyroad taxonomy schemas --out schemas")]),
    (
        "validate",
        &[
            ("A folder of labels, messages in Chinese", "whyroad validate labels/ --lang zh"),
            ("From another program, as SARIF", "whyroad validate - --format sarif"),
            ("Against the recorded drives", "whyroad validate labels.jsonl --lake lake"),
            (
                "Quality of imported texts",
                "whyroad validate drafts.jsonl --lake lake --quality --format json",
            ),
        ],
    ),
    (
        "ingest",
        &[
            ("Detect the format", "whyroad ingest logs/ --lake lake"),
            (
                "One format, with its options",
                "whyroad ingest sumo fcd.xml.gz --net net.xml.gz --ego ego --lake lake",
            ),
            ("Options of a format", "whyroad ingest comma2k19 --dbc car.dbc --lake lake logs/"),
        ],
    ),
    ("dataset init", &[("A commented spec", "whyroad dataset init dataset.yaml")]),
    (
        "dataset build",
        &[
            (
                "From the accepted labels of the service",
                "whyroad dataset build --spec dataset.yaml --labels whyroad-data --lake lake --out release",
            ),
            (
                "From mined episodes, drafted by rule and marked as drafts",
                "whyroad dataset build --spec dataset.yaml --labels mined --drafts --lake lake --out release",
            ),
        ],
    ),
    (
        "dataset export",
        &[(
            "For ms-swift, Chinese traces only",
            "whyroad dataset export ms-swift release --out swift --traces zh",
        )],
    ),
    (
        "dataset verify",
        &[
            ("Everything", "whyroad dataset verify release"),
            ("Labels against the drives too", "whyroad dataset verify release --lake lake"),
        ],
    ),
    ("dataset diff", &[("What changed", "whyroad dataset diff release-1 release-2")]),
    ("dataset show", &[("By the beginning of its id", "whyroad dataset show release 3f2a")]),
    (
        "dataset score",
        &[(
            "On the test split, with a page",
            "whyroad dataset score release predictions.jsonl --page score.html",
        )],
    ),
    (
        "dataset doubtful",
        &[
            ("Decisions, by the baseline", "whyroad dataset doubtful release --target longitudinal"),
            (
                "Send the 50 most doubtful classes back for review",
                "whyroad dataset doubtful release --limit 50 --to-tasks review --lake lake --data labels",
            ),
        ],
    ),
    ("baseline train", &[("Into a model file", "whyroad baseline train release --out baseline.json")]),
    (
        "baseline evaluate",
        &[(
            "By leaf, with a page",
            "whyroad baseline evaluate release --model baseline.json --page baseline.html",
        )],
    ),
    (
        "inspect",
        &[
            ("The whole lake", "whyroad inspect --lake lake"),
            ("One drive, and the signals that it lacks", "whyroad inspect --lake lake --drive drive"),
            ("One clip, every signal", "whyroad inspect --lake lake --clip drive_000"),
            ("As JSON", "whyroad inspect --lake lake --format json"),
        ],
    ),
    (
        "lake list",
        &[
            (
                "Drives of a city in 2026",
                "whyroad lake list --lake lake --place Pittsburgh --since 2026-01-01",
            ),
            ("As JSON", "whyroad lake list --lake lake --format json"),
        ],
    ),
    (
        "lake compact",
        &[
            ("Pack all loose drives", "whyroad lake compact --lake lake"),
            (
                "Smaller packs, without stored signals",
                "whyroad lake compact --lake lake --size 100 --drop-signals",
            ),
        ],
    ),
    ("lake upgrade", &[("Check the layout of a lake", "whyroad lake upgrade --lake lake")]),
    (
        "lake delete",
        &[
            (
                "What would be deleted, and which releases and backups hold the drive",
                "whyroad lake delete drive --lake lake --mined mined --store whyroad-data/labels.db \
                 --releases releases --backups backups --dry-run",
            ),
            (
                "Drives of before 2026",
                "whyroad lake delete --older-than 2026-01-01 --lake lake --mined mined",
            ),
        ],
    ),
    (
        "media add",
        &[(
            "Ten images per second, from the start of the drive",
            "whyroad media add --lake lake --drive drive --camera front --pictures images --rate 10",
        )],
    ),
    ("signals list", &[("As JSON", "whyroad signals list --format json")]),
    ("signals show", &[("By alias", "whyroad signals show ttc")]),
    ("signals derive", &[("On two cores", "whyroad signals derive --lake lake --jobs 2")]),
    (
        "mine",
        &[
            ("All rules", "whyroad mine --lake lake --out mined"),
            ("One class", "whyroad mine --lake lake --scenario cutin --limit 100 --out mined-cutin"),
            (
                "A custom rule",
                "whyroad mine --lake lake --rule 'target.ttc < 2 s for 0.5 s' --name close --out close",
            ),
            (
                "A query, result as JSON",
                "whyroad mine --lake lake --query query.json --out asked --format json",
            ),
            ("Work lists for four workers", "whyroad mine --lake lake --plan 4 --out plan"),
            ("One worker", "whyroad mine --lake lake --drives plan/list-1.json --out parts/1"),
        ],
    ),
    (
        "merge",
        &[
            ("The parts of all workers", "whyroad merge parts --out mined"),
            ("Parts of lists that other programs made", "whyroad merge a b --lake lake --out mined"),
        ],
    ),
    (
        "accounts rotate-key",
        &[("A new key, with which all secrets are sealed", "whyroad accounts rotate-key")],
    ),
    (
        "judge",
        &[
            (
                "Labels of the service, one in ten for people",
                "whyroad judge labels.jsonl --lake lake --model https://host/v1 --model-name vlm --key-env VLM_KEY --people people.jsonl --out judged.jsonl",
            ),
            (
                "Drafts, at a local endpoint without a key",
                "whyroad judge drafts.jsonl --lake lake --model http://localhost:8000/v1 --out judged.jsonl --limit 50",
            ),
        ],
    ),
    (
        "agreement",
        &[
            ("Two annotators", "whyroad agreement ada.jsonl ben.jsonl"),
            (
                "A project with several annotators per episode",
                "whyroad agreement --project first --data labels",
            ),
            ("A judge and people", "whyroad agreement judged.jsonl people.jsonl"),
        ],
    ),
    (
        "ask",
        &[
            (
                "Show the rule and what it finds",
                "whyroad ask 'A truck cuts in close ahead' --lake lake --model http://localhost:8000/v1 --out asked",
            ),
            ("The rule alone", "whyroad ask 'The ego brakes hard' --model https://host/v1 --key-env LLM_KEY"),
        ],
    ),
    (
        "draft",
        &[
            ("By rule, in Chinese", "whyroad draft --lake lake --from mined --texts zh --out drafts.jsonl"),
            (
                "By a model, within a budget",
                "whyroad draft --lake lake --from mined --model https://host/v1 --model-name vlm --key-env VLM_KEY --max-requests 500 --out drafts.jsonl",
            ),
        ],
    ),
    (
        "migrate",
        &[
            ("Labels of an older layout", "whyroad migrate old.jsonl --out labels.jsonl"),
            ("Back to format 2.0", "whyroad migrate labels.jsonl --to 2.0"),
        ],
    ),
    (
        "robustness",
        &[
            ("All perturbations, with a page", "whyroad robustness --lake lake --page robustness.html"),
            (
                "Two perturbations, exit code 1 below 0.95",
                "whyroad robustness --lake lake --perturbation correlated --perturbation 2hz --floor 0.95",
            ),
        ],
    ),
    (
        "explain",
        &[
            (
                "Why a class was found in a clip, or why not",
                "whyroad explain cutin.urgent --lake lake --clip drive_000",
            ),
            (
                "For a program: every condition over time",
                "whyroad explain cutin.urgent --lake lake --clip drive_000 --format json",
            ),
        ],
    ),
    (
        "other",
        &[
            ("As a page with scenes", "whyroad other --episodes mined --lake lake --page other.html"),
            (
                "A labeling task for each of the ten largest groups",
                "whyroad other --episodes mined --lake lake --limit 10 --to-tasks first --data labels",
            ),
        ],
    ),
    (
        "rules check",
        &[(
            "All errors of a rule file",
            "whyroad rules check my-framework/scenarios/reactive_agent/cutin.yaml",
        )],
    ),
    (
        "evaluate",
        &[(
            "Precision and recall against ground truth",
            "whyroad evaluate --truth truth.jsonl --episodes mined",
        )],
    ),
    (
        "calibrate",
        &[
            (
                "From verdicts of people on mined episodes, into a framework folder",
                "whyroad calibrate --episodes mined --verdicts verdicts.jsonl --out my-framework/schema/calibration.yaml",
            ),
            (
                "From ground truth alone",
                "whyroad calibrate --episodes mined --truth truth.jsonl --fresh --out calibration.yaml",
            ),
        ],
    ),
    (
        "compare",
        &[
            (
                "Two mined folders, judged by accepted labels",
                "whyroad compare mined mined-new --labels accepted.jsonl --examples",
            ),
            (
                "Effects of changed rules, as a page",
                "whyroad compare bundled my-framework --lake lake --labels whyroad-data --out compare.html",
            ),
            ("Two releases", "whyroad compare release-1 release-2 --out compare.html"),
        ],
    ),
    (
        "serve",
        &[
            ("Bundled drives, nothing to prepare", "whyroad serve"),
            ("A lake and mined episodes", "whyroad serve --lake lake --mined mined --data labels"),
            (
                "With a language model for drafts and judgments",
                "whyroad serve --lake lake --mined mined --data labels --model https://host/v1 --model-name vlm --key-env VLM_KEY",
            ),
        ],
    ),
    (
        "tasks create",
        &[(
            "At most 200 tasks",
            "whyroad tasks create --from mined --project first --lake lake --limit 200 --data labels",
        )],
    ),
    ("tasks list", &[("Tasks of a project", "whyroad tasks list --project first --data labels")]),
    (
        "tasks export",
        &[("Accepted labels as JSON Lines", "whyroad tasks export --project first --data labels")],
    ),
    (
        "tasks import",
        &[(
            "Labels become drafts",
            "whyroad tasks import drafts.jsonl --project first --lake lake --data labels",
        )],
    ),
    (
        "labels import",
        &[
            (
                "Reasoning texts of PhysicalAI-AV, for drives of `ingest pai`",
                "whyroad labels import ood-reasoning pai/reasoning --lake lake --out drafts.jsonl",
            ),
            (
                "Output of the auto-labeler, all of one class",
                "whyroad labels import auto-labeler run1 --scenario cutin.urgent --lake lake --out drafts.jsonl",
            ),
        ],
    ),
    ("accounts list", &[("Accounts of a store", "whyroad accounts list --data labels")]),
    ("accounts password", &[("A new password, printed once", "whyroad accounts password ada --data labels")]),
    ("backup", &[("One file", "whyroad backup --data labels --out labels.backup")]),
    ("restore", &[("Into an empty store", "whyroad restore --from labels.backup --data labels-2")]),
    (
        "report",
        &[
            ("A page to open in a browser", "whyroad report --lake lake --mined mined --out report.html"),
            (
                "In Chinese, at most 100 episodes with an image",
                "whyroad report --lake lake --mined mined --max-episodes 100 --lang zh",
            ),
            (
                "With labeling and releases, and the numbers as CSV and Parquet",
                "whyroad report --lake lake --mined mined --labels whyroad-data --release release --tables tables",
            ),
            (
                "Leaves with fewer than 50 labels, and the cost of a label",
                "whyroad report --lake lake --mined mined --labels whyroad-data --target 50 --rate 60 --summary",
            ),
        ],
    ),
    ("demo", &[("Everything, into a folder", "whyroad demo --out demo")]),
    ("completions", &[("For bash", "whyroad completions bash")]),
    ("man", &[("Into the user's manual folder", "whyroad man --out ~/.local/share/man/man1")]),
];

/// `command` with the examples of each of its subcommands in their long and short help.
pub(crate) fn with_examples(command: Command) -> Command {
    EXAMPLES.iter().fold(command, |command, (path, examples)| {
        let words: Vec<&str> = path.split(' ').collect();
        add(command, &words, &text(examples))
    })
}

fn text(examples: &[(&str, &str)]) -> String {
    let lines: Vec<String> = examples.iter().map(|(about, line)| format!("  # {about}\n  {line}")).collect();
    format!("Examples:\n{}", lines.join("\n"))
}

fn add(command: Command, path: &[&str], text: &str) -> Command {
    match path {
        [] => command.after_help(text.to_owned()),
        [first, rest @ ..] if command.find_subcommand(first).is_some() => {
            command.mut_subcommand(*first, |sub| add(sub, rest, text))
        }
        _ => command,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Cli;
    use clap::CommandFactory as _;

    /// Words of a line; single quotes keep spaces.
    fn words(line: &str) -> Vec<String> {
        let parts = line.split('\'').enumerate();
        parts
            .flat_map(|(i, part)| {
                if i % 2 == 1 {
                    vec![part.to_owned()]
                } else {
                    part.split_whitespace().map(str::to_owned).collect()
                }
            })
            .collect()
    }

    fn leaves(command: &Command, path: &str, out: &mut Vec<String>) {
        for sub in command.get_subcommands().filter(|s| !s.is_hide_set() && s.get_name() != "help") {
            let path = format!("{path} {}", sub.get_name()).trim().to_owned();
            let own = EXAMPLES.iter().any(|(p, _)| *p == path);
            if own || !sub.has_subcommands() {
                out.push(path);
            } else {
                leaves(sub, &path, out);
            }
        }
    }

    #[test]
    fn every_command_has_an_example() {
        let mut all = Vec::new();
        leaves(&Cli::command(), "", &mut all);
        assert!(all.len() > 20, "{all:?}");
        let without: Vec<&String> =
            all.iter().filter(|path| !EXAMPLES.iter().any(|(p, _)| p == path)).collect();
        assert!(without.is_empty(), "no example in --help of: {without:?}");
        let of_nothing: Vec<&str> =
            EXAMPLES.iter().map(|(p, _)| *p).filter(|p| !all.iter().any(|path| path == p)).collect();
        assert!(of_nothing.is_empty(), "examples of commands that do not exist: {of_nothing:?}");
    }

    /// Commands without `--format`, each with the reason.
    const WITHOUT_FORMAT: &[(&str, &str)] = &[
        ("taxonomy init", "writes files"),
        ("taxonomy docs", "writes files"),
        ("taxonomy schemas", "writes files"),
        ("dataset init", "writes a file"),
        ("baseline train", "writes a file"),
        ("signals derive", "writes files"),
        ("backup", "writes a file"),
        ("restore", "fills a store"),
        ("accounts rotate-key", "changes a store"),
        ("serve", "runs until it is stopped"),
        ("tasks export", "prints JSON Lines only"),
        ("migrate", "prints JSON Lines only"),
        ("demo", "writes a report, shows the other commands"),
        ("completions", "prints a script"),
        ("man", "writes files"),
    ];

    fn find<'c>(command: &'c Command, path: &str) -> &'c Command {
        path.split(' ').fold(command, |c, word| c.find_subcommand(word).expect("a command"))
    }

    #[test]
    fn every_command_that_prints_data_takes_format_json() {
        let (line, mut all) = (Cli::command(), Vec::new());
        leaves(&line, "", &mut all);
        for path in &all {
            let option = find(&line, path).get_arguments().find(|a| a.get_long() == Some("format"));
            let reason = WITHOUT_FORMAT.iter().find(|(p, _)| p == path);
            assert_eq!(option.is_some(), reason.is_none(), "{path}: --format or a reason why it has none");
            let Some(option) = option else { continue };
            let values: Vec<String> =
                option.get_possible_values().iter().map(|v| v.get_name().to_owned()).collect();
            assert_eq!(values[..2], ["text", "json"], "{path}");
            assert_eq!(option.get_default_values(), ["text"], "{path}");
            assert_eq!(option.get_value_names().unwrap_or_default(), ["FORMAT"], "{path}");
        }
        assert!(all.len() > WITHOUT_FORMAT.len() * 2, "{all:?}");
    }

    #[test]
    fn examples_are_written_here_alone() {
        // `with_examples` would replace what a command states itself.
        let (line, mut all) = (Cli::command(), Vec::new());
        leaves(&line, "", &mut all);
        let own: Vec<&String> = all.iter().filter(|p| find(&line, p).get_after_help().is_some()).collect();
        assert!(own.is_empty(), "{own:?}");
    }

    #[test]
    fn every_example_is_a_valid_command_line() {
        for (path, examples) in EXAMPLES {
            for (_, line) in *examples {
                let parsed = Cli::command().try_get_matches_from(words(line));
                assert!(parsed.is_ok(), "{path}: {line}\n{}", parsed.unwrap_err());
                assert!(line.starts_with(&format!("whyroad {path}")), "{line} is not an example of {path}");
            }
        }
    }
}
