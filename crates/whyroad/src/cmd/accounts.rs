//! `whyroad accounts`: accounts that can sign in to the labeling service, and new passwords for those who lost theirs.
//! For operators of the service: they have the store and need no account.

use crate::output::Print;
use crate::store_args::error;
use crate::{Global, output, store_args};
use anyhow::anyhow;
use serde_json::{Value, json};
use std::fmt::Write as _;
use std::process::ExitCode;
use whyroad_model::Lang;
use whyroad_server::problem::Problem;
use whyroad_server::secret;
use whyroad_server::service::people;

/// Random bytes of a generated password; twice as many characters in hexadecimal.
const PASSWORD_BYTES: usize = 10;

/// Arguments of `whyroad accounts`.
#[derive(clap::Args)]
pub(crate) struct Args {
    #[command(subcommand)]
    what: What,
}

#[derive(clap::Subcommand)]
enum What {
    /// List accounts
    List {
        #[command(flatten)]
        print: Print,
        #[command(flatten)]
        store: store_args::StoreArgs,
    },
    /// Give an account a new password, which is printed, and end its sessions
    Password {
        /// Name of the account
        #[arg(value_name = "NAME")]
        name: String,
        #[command(flatten)]
        print: Print,
        #[command(flatten)]
        store: store_args::StoreArgs,
    },
    /// Seal the secrets in the store (signing keys of webhooks, key of the CSRF values) with a new key; stop the
    /// service before
    RotateKey {
        #[command(flatten)]
        store: store_args::StoreArgs,
    },
}

pub(crate) fn run(global: &Global, args: Args) -> anyhow::Result<ExitCode> {
    match args.what {
        What::List { print, store } => list(&store, print, global.lang),
        What::Password { name, print, store } => password(&store, &name, print, global.lang),
        What::RotateKey { store } => rotate_key(&store, global.lang),
    }
}

fn rotate_key(store: &store_args::StoreArgs, lang: Lang) -> anyhow::Result<ExitCode> {
    let sealed = store.open_existing(lang)?.rotate_key().map_err(|p| error(&p, lang))?;
    let file = store.key_file();
    match lang {
        Lang::Zh => say!(
            "{sealed} 个密文已用新密钥重新加密；密钥文件 {}；较早的备份仍需原来的密钥文件",
            file.display()
        ),
        Lang::En => say!(
            "{sealed} secrets sealed with a new key, which is in {}; earlier backups still need the earlier key file",
            file.display()
        ),
    }
    Ok(output::FINE)
}

fn list(store: &store_args::StoreArgs, print: Print, lang: Lang) -> anyhow::Result<ExitCode> {
    let all = store.open_existing(lang)?.read(people::all).map_err(|p| error(&p, lang))?;
    let (admin, disabled) = match lang {
        Lang::Zh => ("管理员", "已停用"),
        Lang::En => ("administrator", "disabled"),
    };
    let rows: Vec<Value> = all
        .iter()
        .map(|u| json!({ "name": u.name, "display": u.display, "admin": u.admin, "disabled": u.disabled }))
        .collect();
    print.put(&rows, || {
        let mut out = String::new();
        for user in &all {
            let marks = [(user.admin, admin), (user.disabled, disabled)];
            let marks: Vec<&str> = marks.iter().filter(|m| m.0).map(|m| m.1).collect();
            let _ = writeln!(out, "{:<24}  {}  {}", user.name, user.display, marks.join(", "));
        }
        out
    })?;
    Ok(output::FINE)
}

fn password(store: &store_args::StoreArgs, name: &str, print: Print, lang: Lang) -> anyhow::Result<ExitCode> {
    let store = store.open_existing(lang)?;
    let problem = |p: Problem| error(&p, lang);
    let fresh = secret::random(PASSWORD_BYTES).map_err(problem)?;
    let hash = secret::hash_password(&fresh).map_err(problem)?;
    let wanted = name.to_owned();
    let found = store.write(move |tx| match people::find(tx, &wanted)? {
        Some(user) => people::set_password(tx, &user.id, &hash).map(|()| Some(user)),
        None => Ok(None),
    });
    let user = found.map_err(problem)?.ok_or_else(|| match lang {
        Lang::Zh => anyhow!("没有账号 '{name}'；`whyroad accounts list` 列出所有账号"),
        Lang::En => anyhow!("no account '{name}'; `whyroad accounts list` lists all accounts"),
    })?;
    match lang {
        Lang::Zh => say!("{} 的新密码（请登录后更改）：", user.name),
        Lang::En => say!("new password of {} (change it after signing in):", user.name),
    }
    print.put(&json!({ "name": user.name, "password": fresh }), || format!("{fresh}\n"))?;
    Ok(output::FINE)
}
