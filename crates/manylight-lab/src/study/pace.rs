//! Estimate of the remaining time of a study.

use super::runs::Run;

/// Estimates the time of runs from the times of finished runs.
#[derive(Debug, Default)]
pub struct TimeEstimate {
    known: Vec<RunTime>,
}

/// The time of one finished run.
#[derive(Debug)]
struct RunTime {
    task: String,
    method: String,
    seconds: f64,
}

impl TimeEstimate {
    /// Adds a finished run with its time.
    pub fn note(&mut self, run: &Run, seconds: f64) {
        self.note_named(&run.task_name, &run.method.label, seconds);
    }

    fn note_named(&mut self, task: &str, method: &str, seconds: f64) {
        self.known.push(RunTime {
            task: task.into(),
            method: method.into(),
            seconds,
        });
    }

    /// Estimated time of `runs` in seconds; `None` if there is no estimate for one of them.
    pub fn remaining(&self, runs: &[&Run]) -> Option<f64> {
        let expected = |run: &&Run| {
            let time = run.time_limit().map(|time| time.as_secs_f64());
            self.expected(&run.task_name, &run.method.label, time)
        };
        runs.iter().map(expected).sum()
    }

    /// Estimated time of one run in seconds: the mean over runs of the same task and method, else
    /// `time`, else the mean over the task, else the mean over all runs.
    fn expected(&self, task: &str, method: &str, time: Option<f64>) -> Option<f64> {
        self.mean(|t| t.task == task && t.method == method)
            .or(time)
            .or_else(|| self.mean(|t| t.task == task))
            .or_else(|| self.mean(|_| true))
    }

    /// Mean time in seconds of the known runs that `fits` accepts.
    fn mean(&self, fits: impl Fn(&RunTime) -> bool) -> Option<f64> {
        let seconds: Vec<f64> = (self.known.iter())
            .filter(|t| fits(t))
            .map(|t| t.seconds)
            .collect();
        (!seconds.is_empty()).then(|| seconds.iter().sum::<f64>() / seconds.len() as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_most_similar_runs_are_used() {
        let mut pace = TimeEstimate::default();
        assert_eq!(pace.expected("t", "a", None), None);
        assert_eq!(pace.expected("t", "a", Some(8.0)), Some(8.0));
        pace.note_named("t", "a", 10.0);
        pace.note_named("t", "a", 20.0);
        pace.note_named("t", "b", 30.0);
        pace.note_named("u", "b", 60.0);
        assert_eq!(pace.expected("t", "a", Some(8.0)), Some(15.0));
        assert_eq!(pace.expected("t", "c", None), Some(20.0));
        assert_eq!(pace.expected("v", "a", None), Some(30.0));
    }
}
