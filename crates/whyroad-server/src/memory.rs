//! Memory of a process with many threads.

/// Limits the number of the allocator's arenas, so that the memory of a service that answers many people does not grow.
///
/// glibc gives each of up to eight threads per core an arena, and every arena keeps the most that its threads held at
/// once. The limit is read when a process starts, so the program is started again in this process with
/// `MALLOC_ARENA_MAX=2`. Returns where that variable is set already, on other systems, and where the program cannot be
/// started again: it then runs without the limit. Call it before anything else.
pub fn limit_arenas() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    {
        use std::os::unix::process::CommandExt as _;
        let mut args = std::env::args_os();
        let (Some(name), Ok(program)) = (args.next(), std::env::current_exe()) else { return };
        if std::env::var_os(ARENAS).is_none() && std::env::var_os(RESTARTED).is_none() {
            let mut again = std::process::Command::new(program);
            // Returns only where it fails.
            let _ = again.arg0(name).args(args).env(ARENAS, "2").env(RESTARTED, "1").exec();
        }
    }
}

/// The variable of glibc.
const ARENAS: &str = "MALLOC_ARENA_MAX";
/// Set where the program was started again: glibc removes its own variable from programs with file capabilities, which
/// would start again for ever.
const RESTARTED: &str = "WHYROAD_RESTARTED";

/// Removes what [`limit_arenas`] set from the environment of another program.
pub(crate) fn without_limit(command: &mut std::process::Command) -> &mut std::process::Command {
    if std::env::var_os(RESTARTED).is_some() {
        command.env_remove(ARENAS).env_remove(RESTARTED);
    }
    command
}
