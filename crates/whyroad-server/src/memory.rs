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
        const LIMIT: (&str, &str) = ("MALLOC_ARENA_MAX", "2");
        let mut args = std::env::args_os();
        let (Some(name), Ok(program)) = (args.next(), std::env::current_exe()) else { return };
        if std::env::var_os(LIMIT.0).is_none() {
            // Returns only where it fails.
            let _ = std::process::Command::new(program).arg0(name).args(args).env(LIMIT.0, LIMIT.1).exec();
        }
    }
}
