//! The machine on which a result was computed.

/// Name of the processor and number of threads in use.
pub fn processor() -> String {
    let name = std::fs::read_to_string("/proc/cpuinfo")
        .ok()
        .and_then(|text| {
            let line = text.lines().find(|line| line.starts_with("model name"))?;
            Some(line.split_once(':')?.1.trim().to_owned())
        })
        .unwrap_or_else(|| format!("unknown processor ({})", std::env::consts::ARCH));
    format!("{} threads of {name}", rayon::current_num_threads())
}
