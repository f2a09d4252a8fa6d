//! CPU time of this process.

/// What the threads of this process, all of which live on, have had of the processors so far, s; NaN where the system
/// does not tell.
pub fn cpu_seconds() -> f64 {
    let tasks = std::fs::read_dir("/proc/self/task").into_iter().flatten().flatten();
    let of_task = |task: std::fs::DirEntry| {
        let text = std::fs::read_to_string(task.path().join("schedstat")).ok()?;
        text.split_whitespace().next()?.parse::<f64>().ok()
    };
    let each: Option<Vec<f64>> = tasks.map(of_task).collect();
    each.filter(|e| !e.is_empty()).map_or(f64::NAN, |e| e.iter().sum::<f64>() / 1e9)
}
