//! The computer that made a result.

use serde::{Deserialize, Serialize};

/// Properties of a computer that determine the speed of a render.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Machine {
    /// Model name of the processor, or its architecture if the name is not known.
    pub cpu: String,
    /// Number of hardware threads.
    pub threads: usize,
}

impl Machine {
    /// The computer that runs this program.
    pub fn this() -> Self {
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
