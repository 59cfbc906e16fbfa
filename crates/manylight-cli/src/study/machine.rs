//! On what the runs were made.

use serde::{Deserialize, Serialize};

/// A machine, as far as times depend on it.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub(crate) struct Machine {
    /// The name that the processor gives itself.
    pub(crate) cpu: String,
    /// Threads that the machine runs at a time.
    pub(crate) threads: usize,
}

impl Machine {
    /// This one.
    pub(crate) fn this() -> Self {
        let information = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
        let name = information
            .lines()
            .find_map(|line| line.strip_prefix("model name")?.split_once(':'));
        Machine {
            cpu: name
                .map_or(std::env::consts::ARCH, |(_, name)| name.trim())
                .into(),
            threads: std::thread::available_parallelism().map_or(1, |n| n.get()),
        }
    }
}
